"""What the panel of fractures asks, worked out in a thread, as the command does."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import FloatArray, ObjectArray
from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding, cause_of
from vomstudio.core.words import tr
from vomstudio.geology.fractures.fracture_options import FractureOptions
from vomstudio.geology.notation import exact_plane
from vomstudio.geology.orientation import Plane
from vomstudio.ui.widgets.drawing_view import DrawingMark
from vomstudio.ui.widgets.vertex_table import parse_number

if TYPE_CHECKING:
    from vomstudio.geology.fractures.network import MappedNetwork, SamplingRegion
    from vomstudio.geology.fractures.trace_plane import TracePlane
    from vomstudio.products.ortho.vector_drawing import Drawing
    from vomstudio.products.section.section_lines import Curtain


_MARGIN = 0.01
"""Of the longer side of the traces, around them."""
EVERYTHING, WINDOW, CIRCLE, SCANLINE = "everything", "window", "circle", "scanline"
GRID = "grid"
_CELL_COLOR = "#9a9a9a"


@dataclass(frozen=True, eq=False)
class MappedTrace:
    """points : (n, 3) World; color : of its type"""

    id: str
    name: str
    set: str
    color: str
    points: FloatArray


@dataclass(frozen=True, eq=False)
class GridCells:
    """corners : (n, 4, 3) World of the cells of a grid that were looked at and could be measured;
    any : (4, 3) of one of its cells, by which its plane is known"""

    name: str
    corners: FloatArray
    any: FloatArray

    @property
    def plane(self) -> Plane:
        right, up = self.any[1] - self.any[0], self.any[3] - self.any[0]
        normal = np.cross(right, up)
        return Plane.from_normal(normal / np.linalg.norm(normal))


@dataclass(frozen=True, eq=False)
class FractureQuestion:
    """plane : of the face, None for that of the grid, else the one that fits best; counted_in,
    place : one of the words above with its numbers on the face; options : snap and cap;
    cells : of the grid in which is counted; crs : of World, None for a local frame"""

    traces: Sequence[MappedTrace]
    plane: Plane | None
    counted_in: str
    place: tuple[float, ...]
    options: FractureOptions
    metric: bool
    north_known: bool
    cells: GridCells | None = None
    crs: str | None = None


@dataclass(frozen=True, eq=False)
class FractureAnswer:
    """lines : (n, 2) each, on the face; plane : of the face; mapped : None with the reason `why`
    if nothing can be counted, and the map can be drawn on"""

    question: FractureQuestion
    face: Curtain
    plane: TracePlane
    lines: list[FloatArray]
    counted: SamplingRegion
    drawing: Drawing
    mark: DrawingMark | None
    mapped: MappedNetwork | None
    why: Finding | None = None


def numbers_of(text: str) -> tuple[float, ...] | None:
    """Numbers between commas, semicolons or blanks; None for what is none."""
    words = text.replace(";", ",").replace(",", " ").split()
    values = [parse_number(word) for word in words]
    if any(v is None or not np.isfinite(v) for v in values):
        return None
    return tuple(float(v) for v in values if v is not None)


def wanted_of(counted_in: str, place: tuple[float, ...]) -> Finding | None:
    """Why these numbers are no place of this kind; None where they are one, or none are given."""
    n, text = len(place), ", ".join(f"{value:g}" for value in place)
    if counted_in in (EVERYTHING, GRID) or not n:
        return None
    if counted_in == WINDOW and not (n == 4 or (n >= 6 and n % 2 == 0)):
        return Finding("fractures.not-a-window", text=text)
    if counted_in == CIRCLE and not (n == 3 and place[2] > 0):
        return Finding("fractures.not-a-circle", text=text)
    if counted_in == SCANLINE and (n < 4 or n % 2):
        return Finding("fractures.not-a-scanline", text=text)
    return None


def mark_of(counted_in: str, place: tuple[float, ...]) -> DrawingMark | None:
    """How it looks on the map."""
    if counted_in == EVERYTHING or not place or wanted_of(counted_in, place) is not None:
        return None
    if counted_in == CIRCLE:
        x, y, radius = place
        return DrawingMark(np.array([[x, y], [x + radius, y]]), circle=True)
    points = np.array(place).reshape(-1, 2)
    if counted_in == WINDOW and len(points) == 2:
        (x0, y0), (x1, y1) = points.tolist()
        points = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    return DrawingMark(points, closed=counted_in == WINDOW)


def answer(question: FractureQuestion) -> FractureAnswer:
    """In a thread: what `vomstudio fractures` says of these traces on their face."""
    from vomstudio.geology.fractures.network import SamplingRegion
    from vomstudio.geology.fractures.trace_plane import TracePlane
    from vomstudio.products.fractures.mapping import FractureOrder, map_fractures
    from vomstudio.products.section.trace_map import face_of, map_to_face

    q = question
    plane = q.cells.plane if q.plane is None and q.cells is not None else q.plane
    face = face_of([trace.points for trace in q.traces], plane)
    lines = map_to_face([trace.points for trace in q.traces], face)
    assert face.plane is not None
    placed = TracePlane.through(face.plane, [trace.points for trace in q.traces])
    cells = _on_face(q.cells, face)
    drawing = _drawing(q, face, lines, cells)
    place = q.place
    if q.counted_in == WINDOW and not place:
        place = _place_around(np.concatenate(lines), q.options.snap_m)
    mark = mark_of(q.counted_in, place)
    counted = SamplingRegion()
    why = wanted_of(q.counted_in, place)
    if q.counted_in in (CIRCLE, SCANLINE) and not place:
        why = Finding("fractures.no-mark")
    if q.cells is not None and not len(cells):
        why = Finding("fractures.no-cells", grid=q.cells.name)
    if why is None:
        counted = _of_cells(cells) if len(cells) else _counted(q.counted_in, place, mark)
        try:
            mapped = map_fractures(
                FractureOrder(None, replace(q.options, plane=exact_plane(face.plane))),
                lines=_shapes([trace.points for trace in q.traces]),
                crs=q.crs,
                counted=counted,
                sets=[trace.set for trace in q.traces],
            )
            if not q.north_known:
                mapped = replace(mapped, y_axis="y")
            return FractureAnswer(q, face, placed, lines, counted, drawing, mark, mapped)
        except VomError as error:
            why = cause_of(error)
    return FractureAnswer(q, face, placed, lines, counted, drawing, mark, None, why)


def _place_around(points: FloatArray, snap_m: float) -> tuple[float, ...]:
    """Return the corners of a window around points (n, 2) on the face.

    It is larger than they are, so that no trace ends on its edge, where ends count as cut off.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    margin = _MARGIN * float((high - low).max()) + 2.0 * snap_m
    return (*(low - margin).tolist(), *(high + margin).tolist())


def _on_face(cells: GridCells | None, face: Curtain) -> FloatArray:
    """(n, 4, 2) corners as they lie on the face."""
    from vomstudio.products.section.trace_map import map_to_face

    if cells is None or not len(cells.corners):
        return np.zeros((0, 4, 2))
    (flat,) = map_to_face([cells.corners.reshape(-1, 3)], face)
    return flat.reshape(-1, 4, 2)


def _of_cells(cells: FloatArray) -> SamplingRegion:
    """Cells side by side are one area."""
    import shapely

    from vomstudio.geology.fractures.network import SamplingRegion

    # Corners that are the same but for the rounding would leave slits between cells.
    size = float(np.linalg.norm(cells[0, 1] - cells[0, 0]))
    return SamplingRegion(shapely.union_all(shapely.polygons(cells), grid_size=1e-6 * size))


def _counted(counted_in: str, place: tuple[float, ...], mark: DrawingMark | None) -> SamplingRegion:
    import shapely

    from vomstudio.geology.fractures.network import SamplingRegion
    from vomstudio.geology.fractures.pieces import circle_area
    from vomstudio.geometry.outlines.self_crossing import resolve_crossings

    if mark is None:
        return SamplingRegion()
    if counted_in == CIRCLE:
        x, y, radius = place
        return SamplingRegion(circle_area(x, y, radius), circle=(x, y, radius))
    if counted_in == WINDOW:
        area, said = resolve_crossings(shapely.Polygon(mark.points))
        return SamplingRegion(area, warnings=tuple(said))
    return SamplingRegion(scanlines=_shapes([mark.points]))


def _shapes(lines: Sequence[FloatArray]) -> ObjectArray:
    import shapely

    made = np.empty(len(lines), object)
    made[:] = [shapely.LineString(line) for line in lines]
    return made


def _drawing(
    q: FractureQuestion, face: Curtain, lines: Sequence[FloatArray], cells: FloatArray
) -> Drawing:
    from vomstudio.products.ortho.vector_drawing import Drawing, DrawingShape
    from vomstudio.products.section.writing import end_names

    every = np.concatenate([*lines, cells.reshape(-1, 2)])
    low, high = every.min(axis=0), every.max(axis=0)
    pad = max(0.05 * float((high - low).max()), 1e-3)
    unit = "m" if q.metric else tr("units")
    up = tr("Z ({unit})", unit=unit) if face.vertical else tr("up the face ({unit})", unit=unit)
    shapes = (
        *(DrawingShape("cells", cell, _CELL_COLOR, closed=True) for cell in cells),
        *(
            DrawingShape("traces", line, trace.color)
            for trace, line in zip(q.traces, lines, strict=True)
        ),
    )
    return Drawing(
        shapes,
        np.stack([low - pad, high + pad]),
        end_names(face, q.north_known),
        (tr("along the face ({unit})", unit=unit), up),
        metric=q.metric,
    )


def draw_figure(mapped: MappedNetwork, dpi: float = 150.0) -> bytes:
    """In a thread: the figure as PNG."""
    from vomstudio.products.fractures.figure import write_fractures

    file = io.BytesIO()
    write_fractures(file, mapped, format="png", dpi=dpi)
    return file.getvalue()


def write_figure(mapped: MappedNetwork, path: Path) -> None:
    """In a thread: the figure, as svg, pdf or png."""
    from vomstudio.core.files.atomic import atomic_write
    from vomstudio.products.fractures.figure import write_fractures

    with atomic_write(path, True) as temporary:
        write_fractures(temporary, mapped, format=path.suffix.lower().removeprefix("."))
