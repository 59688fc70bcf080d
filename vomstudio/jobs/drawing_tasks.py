"""Jobs on lines that were drawn on an orthophoto in another program."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.core.findings import Message
from vomstudio.jobs.job import Job, Lane
from vomstudio.jobs.standing_model import StandingModel, read_standing
from vomstudio.progress import Progress
from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.products.ortho.drawing_back import Sidecar

Point = tuple[float, float, float]


@dataclass(frozen=True)
class DrawingFile:
    """sidecar : of the picture on which it was drawn, None where that is to be found"""

    path: Path
    sidecar: Path | None


@dataclass(frozen=True)
class FittingPictures:
    """sidecars : of the pictures on which it can have been drawn; content_hashes : of the model
    that each shows, "" where that is not said"""

    sidecars: tuple[Path, ...]
    content_hashes: tuple[str, ...]


def _find_pictures(asked: DrawingFile, progress: Progress) -> FittingPictures:
    from vomstudio.errors import InputError
    from vomstudio.products.ortho.drawing_back import fitting_sidecars, read_sidecar

    chosen = asked.sidecar
    found = fitting_sidecars(asked.path, progress) if chosen is None else [chosen]
    hashes = []
    for path in found:
        try:
            hashes.append(read_sidecar(path).content_hash or "")
        except InputError:
            # It is said when the lines are read.
            hashes.append("")
    return FittingPictures(tuple(found), tuple(hashes))


FIND_PICTURES = Job("find_pictures", Lane.PRODUCTS, DrawingFile, FittingPictures, _find_pictures)
"""Look which orthophotos of its folder a drawing can have been made on."""


@dataclass(frozen=True)
class DrawingOrder:
    """The lines of `drawing`, made on the picture of `sidecar`, on the surface of a model."""

    drawing: Path
    sidecar: Path
    model: StandingModel


@dataclass(frozen=True)
class Picture:
    """Size of an orthophoto, and the matrix from its pixels to World."""

    width: int
    height: int
    matrix: tuple[tuple[float, ...], ...]

    @classmethod
    def of(cls, sidecar: Sidecar) -> Picture:
        """Return the picture of a sidecar."""
        rows = tuple(tuple(float(value) for value in row) for row in sidecar.matrix)
        return cls(sidecar.width, sidecar.height, rows)


@dataclass(frozen=True)
class DrawnLine:
    """Line that was brought back to the surface.

    Parameters
    ----------
    name : str
    named : bool
        Whether the drawing states the name.
    layer : str
    points : tuple of (x, y, z)
        In the frame of the model's file.
    pixels : tuple of (column, row)
        All vertices on the picture.
    id, kind, set : str
        Attributes of the shape, "" if the drawing has none.
    """

    name: str
    named: bool
    layer: str
    points: tuple[Point, ...]
    pixels: tuple[tuple[float, float], ...] = ()
    id: str = ""
    kind: str = ""
    set: str = ""


@dataclass(frozen=True)
class DrawnLines:
    """Lines of a drawing on the surface of a model.

    Parameters
    ----------
    lines : tuple of DrawnLine
    skipped : tuple of str
        Names of lines that meet no surface.
    content_hash : str or None
        Of the model that the picture shows, None if the sidecar states none.
    warnings : tuple of Message
    picture : Picture or None
        The picture on which the lines were drawn.
    """

    lines: tuple[DrawnLine, ...]
    skipped: tuple[str, ...]
    content_hash: str | None
    warnings: tuple[Message, ...]
    picture: Picture | None = None


def _read_lines(asked: DrawingOrder, progress: Progress) -> DrawnLines:
    from vomstudio.errors import InputError
    from vomstudio.products.ortho.drawing_back import (
        bring_back,
        in_frame,
        read_drawing,
        read_sidecar,
    )

    picture = read_sidecar(asked.sidecar)
    progress.stage(tr("Reading {file}", file=asked.drawing.name))
    lines, said = read_drawing(asked.drawing, picture, progress)
    data = read_standing(asked.model, progress).data
    progress.stage(tr("Projecting {count} lines onto the surface", count=len(lines)))
    try:
        brought = bring_back(lines, in_frame(picture, asked.model.to_world), data)
    except InputError as error:
        raise error.of_file(asked.drawing) from error
    own = {line.name.strip() for line in lines}
    return DrawnLines(
        tuple(
            DrawnLine(
                name=line.name,
                named=line.name in own,
                layer=line.layer,
                points=tuple((float(x), float(y), float(z)) for x, y, z in line.points),
                pixels=tuple((float(x), float(y)) for x, y in line.pixels),
                id=line.words.id,
                kind=line.words.kind,
                set=line.words.set,
            )
            for line in brought.lines
        ),
        brought.skipped,
        picture.content_hash,
        (*said, *brought.warnings),
        Picture.of(picture),
    )


READ_DRAWN_LINES = Job("read_drawn_lines", Lane.PRODUCTS, DrawingOrder, DrawnLines, _read_lines)
"""Bring the lines of a drawing back to the surface that its picture shows."""

JOBS = (FIND_PICTURES, READ_DRAWN_LINES)
