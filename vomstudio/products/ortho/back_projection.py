"""Lines drawn on an orthophoto in another program, brought back to the surface by its sidecar."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import SIDECAR_BYTES, open_regular, read_json
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, Silent
from vomstudio.core.words import tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.gis.dxf_properties import read_dxf_properties
from vomstudio.io.gis.line_reading import (
    DEFAULT_LAYERS,
    FeatureAttributes,
    ReadLine,
    ReadLines,
    read_gis_lines,
)
from vomstudio.io.gis.svg_lines import SvgDrawing, read_svg
from vomstudio.products.ortho.drawn_features import mark_of, picture_id
from vomstudio.products.ortho.visible_depth import shown_depths

LIKE_PICTURE = 0.01
"""A page or picture in a drawing is of the orthophoto where its sides have the same ratio within
this."""
LEAST_INSIDE = 0.5
"""Of the vertices of a drawing, those within its picture."""
OWN_LAYERS = ("traces", "patches", "planes", "lines", "frame")
"""Of the drawings that are written over a picture: what lies on them has another name."""
SAME_PLACE = 1e-3
"""Of the size of a picture: two that lie no farther apart are the same."""
_MOST_PIXELS = 1 << 31
_MARK = re.compile(r"(?:VOM Studio picture|VOM Studio view plane) ([0-9a-f]{16})")


@dataclass(frozen=True, eq=False)
class Sidecar:
    """What the pixels of an orthophoto mean. matrix : (4, 4) pixel_to_world; transform : from
    pixels to the coordinates in which the GeoTIFF lies; crs : of these, None on a slanting plane"""

    path: Path
    width: int
    height: int
    matrix: FloatArray
    transform: FloatArray
    crs: str | None
    oblique: bool
    id: str
    content_hash: str | None
    image: str


@dataclass(frozen=True, eq=False)
class BackLine:
    """Line on the surface.

    Parameters
    ----------
    name : str
    layer : str
        Layer on which it was drawn.
    words : FeatureWords
    pixels : (m, 2) float64
        Column and row of its vertices on the picture.
    is_met : (m,) bool
        Whether a vertex meets the surface.
    points : (n, 3) float64
        Those that do, in World.
    """

    name: str
    layer: str
    words: FeatureAttributes
    pixels: FloatArray
    is_met: BoolArray
    points: FloatArray


@dataclass(frozen=True, eq=False)
class Brought:
    """Lines of a drawing on the surface. skipped : those with fewer than two points on it"""

    lines: tuple[BackLine, ...]
    skipped: tuple[BackLine, ...]

    @property
    def points(self) -> int:
        return sum(len(line.points) for line in self.lines)

    @property
    def off_surface(self) -> int:
        """Number of points that meet no surface."""
        return sum(int((~line.is_met).sum()) for line in (*self.lines, *self.skipped))

    @property
    def warnings(self) -> tuple[Finding, ...]:
        return off_surface_findings(self.off_surface, len(self.skipped))


def off_surface_findings(points: int, lines: int) -> tuple[Finding, ...]:
    """Return findings about points that meet no surface, and lines with fewer than two others."""
    findings: tuple[Finding, ...] = ()
    if points:
        findings = (Finding("drawing.points-off-surface", count=points),)
    if lines:
        findings += (Finding("drawing.lines-off-surface", count=lines),)
    return findings


def read_sidecar(path: str | Path) -> Sidecar:
    """Raises InputError where the file is no sidecar of an orthophoto."""
    path = Path(path)
    try:
        facts = read_json(path, SIDECAR_BYTES)
        matrix = np.array(facts["pixel_to_world"], np.float64).reshape(4, 4)
        a, b, c, d, e, f = (float(v) for v in facts["geotransform"])
        width, height = int(facts["width"]), int(facts["height"])
        oblique = facts["plane_coordinates"] is not None
        crs, known = _text(facts.get("crs")), _text(facts.get("content_hash"))
    except OSError as error:
        raise InputError(
            Finding("file.unreadable", reason=error.strerror), file=path, field="--sidecar"
        ) from error
    except (ValueError, KeyError, TypeError, OverflowError) as error:
        raise InputError(Finding("sidecar.other-file"), file=path, field="--sidecar") from error
    transform = np.array([[a, b, c], [d, e, f], [0.0, 0.0, 1.0]])
    if not (np.isfinite(matrix).all() and np.isfinite(transform).all() and width > 0 < height):
        raise InputError(Finding("sidecar.no-place"), file=path)
    with np.errstate(all="ignore"):
        flat = not (abs(np.linalg.det(matrix)) > 0 < abs(np.linalg.det(transform)))
    if flat or max(width, height) > _MOST_PIXELS:
        raise InputError(Finding("sidecar.no-place"), file=path)
    return Sidecar(
        path,
        width,
        height,
        matrix,
        transform,
        crs,
        oblique,
        str(facts.get("picture_id") or picture_id(facts)),
        known,
        str(facts.get("image") or path.name),
    )


@np.errstate(all="ignore")
def read_drawing(
    path: str | Path, sidecar: Sidecar, progress: Progress | None = None
) -> tuple[tuple[ReadLine, ...], tuple[Finding, ...]]:
    """The lines of a drawing in pixels (column, row) of the picture, and what must be said. Raises
    InputError where the file cannot be read, holds no line, or was drawn on another picture."""
    path = Path(path)
    warnings: list[Finding] = []
    if path.suffix.lower() in (".svg", ".svgz"):
        drawing = read_svg(path)
        _check_marks(drawing.marks, sidecar, path)
        to_pixels = _page_to_pixels(drawing, sidecar, path)
        lines = [_through(line, to_pixels) for line in drawing.lines]
    else:
        lines, said = _gis_lines(path, sidecar, progress)
        warnings += said
        if path.suffix.lower() == ".dxf":
            # CAD has no names of lines: what a line is is said by its layer.
            lines = [replace(line, name=line.name or _said_by(line.layer)) for line in lines]
    if not lines:
        raise InputError(Finding("drawing.no-traces"), file=path)
    if not all(np.isfinite(line.points).all() for line in lines):
        raise InputError(Finding("drawing.not-finite"), file=path)
    if _inside_share(lines, sidecar) < LEAST_INSIDE:
        raise InputError(Finding("drawing.other-picture"), file=path, field="--sidecar")
    return tuple(lines), tuple(warnings)


def fitting_sidecars(drawing: Path, progress: Progress | None = None) -> list[Path]:
    """Of the pictures in the folder of a drawing those on which it can have been drawn: the one
    whose name the drawing's begins with, alone, where it is among them."""
    progress = progress or Silent()
    found = []
    there = sorted(drawing.parent.glob("*.json"))
    for done, path in enumerate(there):
        progress.stage(tr("Finding the orthophoto of the drawing"), len(there))
        progress.step(done)
        try:
            read_drawing(drawing, read_sidecar(path), progress)
        except InputError:
            continue
        found.append(path)
    named = [path for path in found if drawing.stem.startswith(path.stem)]
    return [max(named, key=lambda path: len(path.stem))] if named else found


def in_frame(sidecar: Sidecar, to_world: Sequence[Sequence[float]]) -> Sidecar:
    """The picture in the frame of a model's file, whose matrix to World this is: what is looked at
    need not be moved."""
    to_file = np.asarray(np.linalg.inv(np.array(to_world, np.float64).reshape(4, 4)), np.float64)
    matrix = to_file @ sidecar.matrix
    matrix[:3, 2] /= np.linalg.norm(matrix[:3, 2])
    return replace(sidecar, matrix=matrix)


def bring_back(
    lines: Sequence[ReadLine], sidecar: Sidecar, data: Mesh | PointCloud, step: float | None = None
) -> Brought:
    """Project the vertices of lines (pixels) onto the surface that the picture shows.

    data : in World; step : maximum distance of further points between the vertices, metres
    """
    gsd = float(np.linalg.norm(sidecar.matrix[:3, 0]))
    pixels = [line.points if step is None else _denser(line.points, step / gsd) for line in lines]
    size = (sidecar.width, sidecar.height)
    depths = shown_depths(data, sidecar.matrix, size, np.concatenate(pixels))
    parts = np.split(depths, np.cumsum([len(part) for part in pixels])[:-1])
    brought: list[BackLine] = []
    skipped: list[BackLine] = []
    names = _unique([line.name for line in lines])
    for place, depth, name, line in zip(pixels, parts, names, lines, strict=True):
        is_met = np.isfinite(depth)
        at = np.column_stack([place[is_met], depth[is_met]])
        points = at @ sidecar.matrix[:3, :3].T + sidecar.matrix[:3, 3]
        one = BackLine(name, line.layer, line.words, place, is_met, points)
        (brought if len(points) > 1 else skipped).append(one)
    if not brought:
        raise InputError(Finding("drawing.off-surface"))
    return Brought(tuple(brought), tuple(skipped))


def _page_to_pixels(drawing: SvgDrawing, sidecar: Sidecar, path: Path) -> FloatArray:
    """(3, 3) from the drawing's units to pixels: by the picture in it that has the orthophoto's
    name, else by that of its shape, else, where there is no picture at all, by the page."""
    ratio = sidecar.width / sidecar.height
    stem = Path(sidecar.image).stem.casefold()
    shown = [(image.name, image.fitted_corners(ratio), image.corners) for image in drawing.images]
    named = [box for name, box, _ in shown if name and Path(name).stem.casefold() == stem]
    places = named or [box for _, box, place in shown if _is_like(place, sidecar)]
    if not drawing.images and drawing.page is not None:
        x, y, w, h = drawing.page
        page = np.array([[x, y], [x + w, y], [x + w, y + h], [x, y + h]])
        places = [page] if _is_like(page, sidecar) else []
    if not places:
        raise InputError(Finding("drawing.other-picture"), file=path, field="--sidecar")
    first = places[0]
    size = float(np.ptp(first, axis=0).max())
    if any(np.abs(box - first).max() > SAME_PLACE * size for box in places[1:]):
        raise InputError(
            Finding("drawing.several-pictures", count=len(places), name=sidecar.image),
            file=path,
        )
    matrix = np.eye(3)
    matrix[:2, 0] = (first[1] - first[0]) / sidecar.width
    matrix[:2, 1] = (first[3] - first[0]) / sidecar.height
    matrix[:2, 2] = first[0]
    if not abs(np.linalg.det(matrix)) > 0:
        raise InputError(Finding("drawing.other-picture"), file=path, field="--sidecar")
    return np.asarray(np.linalg.inv(matrix))


def _is_like(box: FloatArray, sidecar: Sidecar) -> bool:
    """Whether a picture or page (4, 2) has the shape of the orthophoto."""
    across, down = (float(np.hypot(*(box[k] - box[0]))) for k in (1, 3))
    limit = LIKE_PICTURE + 1 / min(sidecar.width, sidecar.height)
    ratio = sidecar.width / sidecar.height
    return down > 0 and abs(across / down / ratio - 1) <= limit


def _gis_lines(
    path: Path, sidecar: Sidecar, progress: Progress | None
) -> tuple[list[ReadLine], list[Finding]]:
    """The lines of a GIS layer or a drawing for CAD in pixels, and what must be said."""
    read = read_gis_lines(path, progress)
    warnings: list[Finding] = list(read.warnings)
    _check_marks((_head_of(path),), sidecar, path)
    lines, said = _in_picture(read, sidecar, path)
    warnings += said
    inverse = np.asarray(np.linalg.inv(sidecar.transform), np.float64)
    pixels = [_through(line, inverse) for line in lines]
    if not pixels or _inside_share(pixels, sidecar) >= LEAST_INSIDE:
        return pixels, warnings
    unit = read_dxf_properties(path).unit_m if path.suffix.lower() == ".dxf" else None
    if unit not in (None, 1.0):
        scaled = [_through(replace(line, points=line.points * unit), inverse) for line in lines]
        if _inside_share(scaled, sidecar) >= LEAST_INSIDE:
            warnings.append(Finding("drawing.unit-converted", unit_m=unit))
            return scaled, warnings
    return pixels, warnings


def _inside_share(lines: Sequence[ReadLine], sidecar: Sidecar) -> float:
    """Of the vertices, those within the picture."""
    pixels = np.concatenate([line.points for line in lines])
    size = np.array([sidecar.width, sidecar.height])
    return float(((pixels >= -1) & (pixels <= size + 1)).all(axis=1).mean())


def _in_picture(
    read: ReadLines, sidecar: Sidecar, path: Path
) -> tuple[list[ReadLine], list[Finding]]:
    """Lines in the coordinates of the GeoTIFF, each layer from its own, and what was left out.
    Raises InputError where nothing is left of a drawing that has lines."""
    geojson = path.suffix.lower() in (".geojson", ".json")
    systems = dict.fromkeys((line.layer, line.crs) for line in read.lines)
    kept: list[ReadLine] = []
    others: list[str] = []
    reasons: list[InputError] = []
    for layer, crs in systems:
        lines = [line for line in read.lines if (line.layer, line.crs) == (layer, crs)]
        try:
            _check_marks((read.described.get(layer, ""), crs or ""), sidecar, path)
            kept += _of_system(lines, crs, geojson, sidecar, path)
        except InputError as error:
            others.append(layer)
            reasons.append(error)
    if reasons and not kept:
        raise reasons[0]
    if not others:
        return kept, []
    return kept, [Finding("drawing.layers-left-out", count=len(others), names=others)]


def _of_system(
    lines: list[ReadLine], crs: str | None, geojson: bool, sidecar: Sidecar, path: Path
) -> list[ReadLine]:
    """Lines of one layer in the coordinates of the GeoTIFF. Raises InputError."""
    if crs is None:
        return lines
    from pyproj import CRS, Transformer
    from pyproj.exceptions import CRSError

    try:
        theirs = CRS.from_user_input(crs)
        ours = None if sidecar.crs is None else CRS.from_user_input(sidecar.crs)
    except CRSError:
        return lines
    if not (theirs.is_projected or theirs.is_geographic):
        return lines
    # A GeoJSON that names no CRS counts as degrees; in a plane of its own it is metres.
    unnamed = geojson and theirs.is_geographic
    if sidecar.oblique or ours is None:
        if unnamed:
            return lines
        if sidecar.oblique:
            raise InputError(Finding("drawing.on-map", crs=theirs.name), file=path)
        return lines
    if theirs == ours:
        return lines
    every = np.concatenate([line.points for line in lines])
    if unnamed and (np.abs(every) > [360.0, 90.0]).any():
        return lines
    turn = Transformer.from_crs(theirs, ours, always_xy=True)
    return [replace(line, points=np.stack(turn.transform(*line.points.T), 1)) for line in lines]


def _check_marks(said: Sequence[str], sidecar: Sidecar, path: Path) -> None:
    found = {mark for text in said for mark in _MARK.findall(text)}
    if found and sidecar.id not in found:
        raise InputError(Finding("drawing.other-picture"), file=path, field="--sidecar")
    assert _MARK.search(mark_of(sidecar.id)) or not found


def _text(value: object) -> str | None:
    return value if isinstance(value, str) else None


def _head_of(path: Path) -> str:
    """The first words of a DXF, whose comment names its picture; GDAL passes it over."""
    if path.suffix.lower() != ".dxf":
        return ""
    with open_regular(path) as file:
        return file.read(400).decode("latin-1")


def _through(line: ReadLine, matrix: FloatArray) -> ReadLine:
    points = line.points @ matrix[:2, :2].T + matrix[:2, 2]
    return replace(line, points=points)


def _denser(points: FloatArray, step: float) -> FloatArray:
    """Points of a line and between them, no farther apart than `step`."""
    lengths = np.hypot(*np.diff(points, axis=0).T)
    counts = np.maximum(1, np.ceil(lengths / step)).astype(int)
    parts = [
        a + (b - a) * np.arange(n)[:, None] / n
        for a, b, n in zip(points[:-1], points[1:], counts, strict=True)
    ]
    return np.concatenate([*parts, points[-1:]])


def _said_by(layer: str) -> str:
    said = layer.strip()
    return "" if said.casefold() in (*DEFAULT_LAYERS, *OWN_LAYERS) else said


def _unique(names: Sequence[str]) -> list[str]:
    """A name for each, none twice; the number of the line where it has none."""
    used: set[str] = set()
    found = []
    for k, name in enumerate(names):
        label = base = name.strip() or str(k + 1)
        number = 1
        while label in used:
            number += 1
            label = f"{base}-{number}"
        used.add(label)
        found.append(label)
    return found


def facts_of(brought: Brought, table: str) -> Mapping[str, Any]:
    """What the command prints."""
    return {
        "lines": len(brought.lines),
        "points": brought.points,
        "off_surface": brought.off_surface,
        "table": table,
        "skipped": [line.name for line in brought.skipped],
    }
