"""Jobs for lines that were drawn on an orthophoto in another program."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.studio.jobs.job import Job, Lane
from vomstudio.studio.jobs.placed_model import PlacedModel, read_in_file_frame

if TYPE_CHECKING:
    from vomstudio.core.arrays import FloatArray
    from vomstudio.products.ortho.back_projection import ProjectedLines, Sidecar

Point = tuple[float, float, float]


@dataclass(frozen=True)
class DrawingFile:
    """Drawing and the sidecar of its picture; if `sidecar` is None, it is searched for."""

    path: Path
    sidecar: Path | None


@dataclass(frozen=True)
class FittingPictures:
    """Pictures on which a drawing may have been made.

    Parameters
    ----------
    sidecars : tuple of Path
    content_hashes : tuple of str
        Hash of the model in each picture, or "" if its sidecar contains no hash.
    """

    sidecars: tuple[Path, ...]
    content_hashes: tuple[str, ...]


def _find_pictures(request: DrawingFile, progress: Progress) -> FittingPictures:
    from vomstudio.core.errors import InputError
    from vomstudio.products.ortho.back_projection import find_sidecars, read_sidecar

    sidecar = request.sidecar
    sidecars = find_sidecars(request.path, progress) if sidecar is None else [sidecar]
    hashes = []
    for path in sidecars:
        try:
            hashes.append(read_sidecar(path).content_hash or "")
        except InputError:
            # The error is reported when the lines are read.
            hashes.append("")
    return FittingPictures(tuple(sidecars), tuple(hashes))


FIND_PICTURES = Job("find_pictures", Lane.PRODUCTS, DrawingFile, FittingPictures, _find_pictures)
"""Find the orthophotos in the folder of a drawing on which it may have been made."""


@dataclass(frozen=True)
class DrawnLinesRequest:
    """Request for the lines of a drawing on a model; `sidecar` is that of its picture."""

    drawing: Path
    sidecar: Path
    model: PlacedModel


@dataclass(frozen=True)
class PictureGeometry:
    """Size of an orthophoto, and the matrix from its pixels to the World frame."""

    width: int
    height: int
    matrix: tuple[tuple[float, ...], ...]

    @classmethod
    def from_sidecar(cls, sidecar: Sidecar) -> PictureGeometry:
        """Return the geometry of the picture that a sidecar describes."""
        rows = tuple(tuple(float(value) for value in row) for row in sidecar.matrix)
        return cls(sidecar.width, sidecar.height, rows)


@dataclass(frozen=True)
class DrawingLine:
    """Drawn line that was projected back onto the surface.

    Parameters
    ----------
    name : str
    is_named : bool
        Whether the drawing contains the name.
    layer : str
    pixels : tuple of (column, row)
        Vertices in pixels of the picture.
    points : tuple of (x, y, z) or None
        The same vertices on the surface, in the file frame of the model; None for vertices that
        miss the surface.
    id, kind, set : str
        Attributes of the line, or "" if the drawing does not contain them.
    """

    name: str
    is_named: bool
    layer: str
    pixels: tuple[tuple[float, float], ...]
    points: tuple[Point | None, ...]
    id: str
    kind: str
    set: str

    @property
    def surface_points(self) -> tuple[Point, ...]:
        """Vertices that lie on the surface, in the file frame of the model."""
        return tuple(point for point in self.points if point is not None)


@dataclass(frozen=True)
class DrawnLines:
    """Lines of a drawing on the surface of a model.

    Parameters
    ----------
    lines : tuple of DrawingLine
    content_hash : str or None
        Hash of the model in the picture, or None if the sidecar contains no hash.
    picture : PictureGeometry
        Geometry of the picture on which the lines were drawn.
    warnings : tuple of Finding
        Findings about reading the drawing.
    """

    lines: tuple[DrawingLine, ...]
    content_hash: str | None
    picture: PictureGeometry
    warnings: tuple[Finding, ...]


def collect_lines(
    projected_lines: ProjectedLines,
    names: Iterable[str],
    sidecar: Sidecar,
    warnings: Iterable[Finding],
    to_file: FloatArray | None = None,
) -> DrawnLines:
    """Convert lines on a surface to plain data.

    Parameters
    ----------
    projected_lines : ProjectedLines
        Lines of the drawing with their positions on the surface.
    names : iterable of str
        Names of the lines that the drawing contains.
    sidecar : Sidecar
    warnings : iterable of Finding
    to_file : (4, 4) array, optional
        Matrix from the frame of the lines to the file frame of the model. If None, the frames
        are identical.
    """
    from vomstudio.geometry import transform

    stated_names = {name.strip() for name in names}
    lines = []
    for line in (*projected_lines.lines, *projected_lines.skipped):
        points = line.points
        if to_file is not None and len(points):
            points = transform.apply(to_file, points)
        positions = iter(points.tolist())
        lines.append(
            DrawingLine(
                name=line.name,
                is_named=line.name in stated_names,
                layer=line.layer,
                pixels=tuple((float(x), float(y)) for x, y in line.pixels),
                points=tuple(
                    _to_point(next(positions)) if is_point_on_surface else None
                    for is_point_on_surface in line.is_on_surface
                ),
                id=line.words.id,
                kind=line.words.kind,
                set=line.words.set,
            )
        )
    return DrawnLines(
        tuple(lines), sidecar.content_hash, PictureGeometry.from_sidecar(sidecar), tuple(warnings)
    )


def _to_point(position: Sequence[float]) -> Point:
    x, y, z = position
    return x, y, z


def _read_lines(request: DrawnLinesRequest, progress: Progress) -> DrawnLines:
    from vomstudio.core.errors import InputError
    from vomstudio.products.ortho.back_projection import (
        project_lines,
        read_drawing,
        read_sidecar,
        transform_sidecar,
    )

    picture = read_sidecar(request.sidecar)
    progress.stage(tr("Reading {file}", file=request.drawing.name))
    lines, findings = read_drawing(request.drawing, picture, progress)
    data = read_in_file_frame(request.model, progress).data
    progress.stage(tr("Projecting lines onto the surface ({count})", count=len(lines)))
    try:
        projected_lines = project_lines(
            lines, transform_sidecar(picture, request.model.to_world), data
        )
    except InputError as error:
        raise error.with_file(request.drawing) from error
    return collect_lines(projected_lines, (line.name for line in lines), picture, findings)


READ_DRAWN_LINES = Job(
    "read_drawn_lines", Lane.PRODUCTS, DrawnLinesRequest, DrawnLines, _read_lines
)
"""Project the lines of a drawing back onto the surface in its picture."""

JOBS = (FIND_PICTURES, READ_DRAWN_LINES)
