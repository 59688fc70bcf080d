"""Lines drawn on an orthophoto in another program, brought back to the surface by its sidecar."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.errors import InputError
from vomstudio.files.regular import SIDECAR_BYTES, open_regular, read_json
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.rays.raytree import RayTree
from vomstudio.io.gis.line_reading import ReadLine, read_gis_lines
from vomstudio.io.gis.svg_lines import SvgDrawing, read_svg
from vomstudio.products.ortho.drawn_features import mark_of, picture_id
from vomstudio.words import to_translate, tr

Array = npt.NDArray[np.float64]

OWN_GROUPS = ("page", "frame", "planes", "labels")
"""Of our own drawings: what is no line of anybody."""
LIKE_PICTURE = 0.01
"""A page or picture in a drawing is of the orthophoto where its sides have the same ratio within
this."""
REACH_SPACINGS = 2.0
_MOST_PIXELS = 1 << 31
_MARK = re.compile(r"(?:VOM Studio picture|VOM Studio view plane) ([0-9a-f]{16})")

OTHER_PICTURE = to_translate(
    "This is a drawing of another picture than the sidecar's. Give the sidecar (NAME.json) that "
    "was written beside the orthophoto on which the lines were drawn."
)


@dataclass(frozen=True, eq=False)
class Sidecar:
    """What the pixels of an orthophoto mean. matrix : (4, 4) pixel_to_world; transform : from
    pixels to the coordinates in which the GeoTIFF lies; crs : of these, None on a slanting plane"""

    path: Path
    width: int
    height: int
    matrix: Array
    transform: Array
    crs: str | None
    oblique: bool
    id: str
    content_hash: str | None


@dataclass(frozen=True, eq=False)
class BackLine:
    """A line on the surface. points : (n, 3) World"""

    name: str
    points: Array


@dataclass(frozen=True, eq=False)
class Brought:
    """lines : those with a point on the surface; off_surface : how many points met none; skipped :
    lines that met nothing at all, by name; warnings : sentences"""

    lines: tuple[BackLine, ...]
    off_surface: int
    skipped: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def points(self) -> int:
        return sum(len(line.points) for line in self.lines)


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
            tr("The file cannot be read ({reason}).", reason=error.strerror), file=path,
            field="--sidecar",
        ) from error  # fmt: skip
    except (ValueError, KeyError, TypeError, OverflowError) as error:
        raise InputError(
            tr(
                "This is not the sidecar of an orthophoto. Give the NAME.json that was written "
                "beside it."
            ),
            file=path,
            field="--sidecar",
        ) from error
    transform = np.array([[a, b, c], [d, e, f], [0.0, 0.0, 1.0]])
    if not (np.isfinite(matrix).all() and np.isfinite(transform).all() and width > 0 < height):
        raise InputError(tr("The sidecar holds numbers that are none."), file=path)
    with np.errstate(all="ignore"):
        flat = not (abs(np.linalg.det(matrix)) > 0 < abs(np.linalg.det(transform)))
    if flat or max(width, height) > _MOST_PIXELS:
        raise InputError(
            tr("The sidecar states no place on the model for the pixels. Write it anew."), file=path
        )
    return Sidecar(
        path, width, height, matrix, transform, crs, oblique,
        str(facts.get("picture_id") or picture_id(facts)), known,
    )  # fmt: skip


@np.errstate(all="ignore")
def read_drawing(
    path: str | Path, sidecar: Sidecar
) -> tuple[tuple[ReadLine, ...], tuple[str, ...]]:
    """The lines of a drawing in pixels (column, row) of the picture, and what must be said. Raises
    InputError where the file cannot be read, holds no line, or was drawn on another picture."""
    path = Path(path)
    warnings: list[str] = []
    if path.suffix.lower() in (".svg", ".svgz"):
        drawing = read_svg(path, OWN_GROUPS)
        _check_marks(drawing.marks, sidecar, path)
        to_pixels = _page_to_pixels(drawing, sidecar, path)
        lines = [_through(line, to_pixels) for line in drawing.lines]
    else:
        read = read_gis_lines(path)
        _check_marks((*read.described, read.crs or "", _head_of(path)), sidecar, path)
        if read.skipped:
            warnings.append(
                tr("{count} shapes are neither lines nor polygons.", count=read.skipped)
            )
        inverse = np.asarray(np.linalg.inv(sidecar.transform), np.float64)
        lines = [
            _through(line, inverse) for line in _in_picture(read.lines, read.crs, sidecar, path)
        ]
    if not lines:
        raise InputError(tr("The drawing holds no line and no polygon."), file=path)
    pixels = np.concatenate([line.points for line in lines])
    if not np.isfinite(pixels).all():
        raise InputError(tr("The drawing has coordinates that are no numbers."), file=path)
    size = np.array([sidecar.width, sidecar.height])
    inside = ((pixels >= -1) & (pixels <= size + 1)).all(axis=1)
    if inside.mean() < 0.5:
        raise InputError(tr(OTHER_PICTURE), file=path, field="--sidecar")
    return tuple(lines), tuple(warnings)


def bring_back(
    lines: Sequence[ReadLine], sidecar: Sidecar, data: Mesh | PointCloud, step: float | None = None
) -> Brought:
    """Vertices of lines (pixels) on the surface that the picture shows, the nearest along the view.

    data : of World. step : so many metres apart at most further points are put between the
    vertices. A line whose points meet no surface is skipped; of others those points are left out.
    """
    from vomstudio.io.models.opening import point_spacing

    reach = 0.0 if isinstance(data, Mesh) else REACH_SPACINGS * point_spacing(data)
    tree = RayTree(data, reach)
    way = sidecar.matrix[:3, 2]
    low, high = data.bounds
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1])
                        for z in (low[2], high[2])])  # fmt: skip
    before = float(((corners - sidecar.matrix[:3, 3]) @ way).min()) - 1.0
    gsd = float(np.linalg.norm(sidecar.matrix[:3, 0]))
    found: list[BackLine] = []
    skipped: list[str] = []
    off = 0
    for line, name in zip(lines, _unique([line.name for line in lines]), strict=True):
        pixels = line.points if step is None else _denser(line.points, step / gsd)
        starts = (
            sidecar.matrix[:3, 3]
            + pixels @ sidecar.matrix[:3, :2].T
            + before * way
        )  # fmt: skip
        hits = tree.cast(starts, np.broadcast_to(way, starts.shape))
        met = hits.index >= 0
        off += int((~met).sum())
        if not met.any():
            skipped.append(name)
            continue
        found.append(BackLine(name, starts[met] + hits.distance[met][:, None] * way))
    if not found:
        raise InputError(
            tr(
                "None of the lines meets the surface. Check that the model is the one of the "
                "orthophoto, and the sidecar its own."
            )
        )
    warnings: tuple[str, ...] = ()
    if off:
        warnings = (tr("{count} points lie beside the surface and were left out.", count=off),)
    return Brought(tuple(found), off, tuple(skipped), warnings)


def _page_to_pixels(drawing: SvgDrawing, sidecar: Sidecar, path: Path) -> Array:
    """(3, 3) from the drawing's units to pixels: by the picture in it, else by its page."""
    ratio = sidecar.width / sidecar.height
    corners = list(drawing.images)
    if not corners and drawing.page is not None:
        x, y, w, h = drawing.page
        corners = [np.array([[x, y], [x + w, y], [x + w, y + h], [x, y + h]])]
    for box in corners:
        across, down = box[1] - box[0], box[3] - box[0]
        width, height = float(np.hypot(*across)), float(np.hypot(*down))
        if height > 0 and abs(width / height / ratio - 1) <= LIKE_PICTURE + 1 / min(
            sidecar.width, sidecar.height
        ):
            matrix = np.eye(3)
            matrix[:2, 0], matrix[:2, 1], matrix[:2, 2] = (
                across / sidecar.width,
                down / sidecar.height,
                box[0],
            )
            return np.asarray(np.linalg.inv(matrix))
    raise InputError(tr(OTHER_PICTURE), file=path, field="--sidecar")


def _in_picture(
    lines: Sequence[ReadLine], crs: str | None, sidecar: Sidecar, path: Path
) -> list[ReadLine]:
    """Lines in the coordinates of the GeoTIFF."""
    geojson = path.suffix.lower() in (".geojson", ".json")
    if crs is None or not lines:
        return list(lines)
    from pyproj import CRS, Transformer
    from pyproj.exceptions import CRSError

    try:
        theirs = CRS.from_user_input(crs)
        ours = None if sidecar.crs is None else CRS.from_user_input(sidecar.crs)
    except CRSError:
        return list(lines)
    if not (theirs.is_projected or theirs.is_geographic):
        return list(lines)
    # A GeoJSON that names no CRS counts as degrees; in a plane of its own it is metres.
    unnamed = geojson and theirs.is_geographic
    if sidecar.oblique or ours is None:
        if unnamed:
            return list(lines)
        if sidecar.oblique:
            raise InputError(
                tr(
                    "The drawing lies on the map ({crs}), the picture in a plane of its own. Draw "
                    "on the GeoTIFF in its own coordinates.",
                    crs=theirs.name,
                ),
                file=path,
            )
        return list(lines)
    if theirs == ours:
        return list(lines)
    every = np.concatenate([line.points for line in lines])
    if unnamed and (np.abs(every) > [360.0, 90.0]).any():
        return list(lines)
    turn = Transformer.from_crs(theirs, ours, always_xy=True)
    return [
        ReadLine(line.layer, line.name, np.stack(turn.transform(*line.points.T), 1), line.closed)
        for line in lines
    ]


def _check_marks(said: Sequence[str], sidecar: Sidecar, path: Path) -> None:
    found = {mark for text in said for mark in _MARK.findall(text)}
    if found and sidecar.id not in found:
        raise InputError(tr(OTHER_PICTURE), file=path, field="--sidecar")
    assert _MARK.search(mark_of(sidecar.id)) or not found


def _text(value: object) -> str | None:
    return value if isinstance(value, str) else None


def _head_of(path: Path) -> str:
    """The first words of a DXF, whose comment names its picture; GDAL passes it over."""
    if path.suffix.lower() != ".dxf":
        return ""
    with open_regular(path) as file:
        return file.read(400).decode("latin-1")


def _through(line: ReadLine, matrix: Array) -> ReadLine:
    points = line.points @ matrix[:2, :2].T + matrix[:2, 2]
    return ReadLine(line.layer, line.name, points, line.closed)


def _denser(points: Array, step: float) -> Array:
    """Points of a line and between them, no farther apart than `step`."""
    lengths = np.hypot(*np.diff(points, axis=0).T)
    counts = np.maximum(1, np.ceil(lengths / step)).astype(int)
    parts = [
        a + (b - a) * np.arange(n)[:, None] / n
        for a, b, n in zip(points[:-1], points[1:], counts, strict=True)
    ]
    return np.concatenate([*parts, points[-1:]])


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
        "skipped": list(brought.skipped),
    }
