"""Analysis of fracture traces on a face, as in the command `fractures`."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import FloatArray, ObjectArray
from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.core.words import tr
from vomstudio.geology.fractures.fracture_options import FractureOptions
from vomstudio.geology.notation import format_exact_plane
from vomstudio.geology.orientation import Plane
from vomstudio.ui.widgets.drawing_view import DrawingMark

if TYPE_CHECKING:
    from vomstudio.geology.fractures.network import MappedNetwork, SamplingRegion
    from vomstudio.geology.fractures.trace_plane import TracePlane
    from vomstudio.products.ortho.vector_drawing import Drawing
    from vomstudio.products.section.section_lines import Curtain


_MARGIN_FRACTION = 0.01
"""Margin around the traces as a fraction of their longer side."""
EVERYTHING, WINDOW, CIRCLE, SCANLINE = "everything", "window", "circle", "scanline"
GRID = "grid"
_CELL_COLOR = "#9a9a9a"


@dataclass(frozen=True, eq=False)
class MappedTrace:
    """Trace of a fracture: points (n, 3) in the World frame and the colour of its type."""

    id: str
    name: str
    set: str
    color: str
    points: FloatArray


@dataclass(frozen=True, eq=False)
class GridCells:
    """Cells of a grid on the face.

    Attributes
    ----------
    corners : (n, 4, 3) float64
        Corners, in the World frame, of the inspected cells, which are marked as done or empty.
    example_cell : (4, 3) float64
        Corners of an arbitrary cell, in the World frame, which define the plane of the grid.
    """

    name: str
    corners: FloatArray
    example_cell: FloatArray

    @property
    def plane(self) -> Plane:
        right, up = (
            self.example_cell[1] - self.example_cell[0],
            self.example_cell[3] - self.example_cell[0],
        )
        normal = np.cross(right, up)
        return Plane.from_normal(normal / np.linalg.norm(normal))


@dataclass(frozen=True, eq=False)
class FractureRequest:
    """Input of the fracture analysis.

    Attributes
    ----------
    plane : Plane or None
        Plane of the face. If None, the plane of the grid is used or, without a grid, the best-fit
        plane.
    region_kind : str
        One of `EVERYTHING`, `WINDOW`, `CIRCLE`, `SCANLINE` and `GRID`.
    region_numbers : tuple of float
        Coordinates (and radius) of the sampling region on the face.
    options : FractureOptions
        Only the snapping distance and the Terzaghi cap are used.
    cells : GridCells or None
        Cells that form the sampling region, or None for another kind of region.
    crs : str or None
        CRS of the World frame, or None for a local frame.
    """

    traces: Sequence[MappedTrace]
    plane: Plane | None
    region_kind: str
    region_numbers: tuple[float, ...]
    options: FractureOptions
    is_metric: bool
    is_north_known: bool
    cells: GridCells | None = None
    crs: str | None = None


@dataclass(frozen=True, eq=False)
class FractureResult:
    """Result of the fracture analysis.

    Attributes
    ----------
    lines : list of (n, 2) float64
        Traces in face coordinates.
    plane : TracePlane
        Plane of the face.
    network : MappedNetwork or None
        Mapped traces, or None if nothing can be counted (see `reason`). The map is drawn in any
        case.
    """

    request: FractureRequest
    face: Curtain
    plane: TracePlane
    lines: list[FloatArray]
    region: SamplingRegion
    drawing: Drawing
    mark: DrawingMark | None
    network: MappedNetwork | None
    reason: Finding | None = None


def check_region_numbers(region_kind: str, numbers: Sequence[float]) -> Finding | None:
    """Check the numbers that define a sampling region of this kind.

    Returns
    -------
    Finding or None
        Why the numbers are not valid, or None if they are valid or missing.
    """
    n, text = len(numbers), ", ".join(f"{value:g}" for value in numbers)
    if region_kind in (EVERYTHING, GRID) or not n:
        return None
    if region_kind == WINDOW and not (n == 4 or (n >= 6 and n % 2 == 0)):
        return Finding("fractures.not-a-window", text=text)
    if region_kind == CIRCLE and not (n == 3 and numbers[2] > 0):
        return Finding("fractures.not-a-circle", text=text)
    if region_kind == SCANLINE and (n < 4 or n % 2):
        return Finding("fractures.not-a-scanline", text=text)
    return None


def region_mark(region_kind: str, numbers: tuple[float, ...]) -> DrawingMark | None:
    """Return the outline of a sampling region on the map, or None if it has no outline."""
    if (
        region_kind == EVERYTHING
        or not numbers
        or check_region_numbers(region_kind, numbers) is not None
    ):
        return None
    if region_kind == CIRCLE:
        x, y, radius = numbers
        return DrawingMark(np.array([[x, y], [x + radius, y]]), circle=True)
    points = np.array(numbers).reshape(-1, 2)
    if region_kind == WINDOW and len(points) == 2:
        (x0, y0), (x1, y1) = points.tolist()
        points = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    return DrawingMark(points, closed=region_kind == WINDOW)


def analyse_fractures(request: FractureRequest) -> FractureResult:
    """Count fractures as in the command `fractures`. Runs in a worker thread."""
    from vomstudio.geology.fractures.network import SamplingRegion
    from vomstudio.geology.fractures.trace_plane import TracePlane
    from vomstudio.products.fractures.mapping import FractureMapRequest, map_fractures
    from vomstudio.products.section.trace_map import curtain_from_traces, map_to_face

    q = request
    plane = q.cells.plane if q.plane is None and q.cells is not None else q.plane
    face = curtain_from_traces([trace.points for trace in q.traces], plane)
    lines = map_to_face([trace.points for trace in q.traces], face)
    assert face.plane is not None
    trace_plane = TracePlane.from_attitude(face.plane, [trace.points for trace in q.traces])
    cells = _project_cells(q.cells, face)
    drawing = _create_drawing(q, face, lines, cells)
    numbers = q.region_numbers
    if q.region_kind == WINDOW and not numbers:
        numbers = _default_window(np.concatenate(lines), q.options.snap_m)
    mark = region_mark(q.region_kind, numbers)
    region = SamplingRegion()
    reason = check_region_numbers(q.region_kind, numbers)
    if q.region_kind in (CIRCLE, SCANLINE) and not numbers:
        reason = Finding("fractures.no-mark")
    if q.cells is not None and not len(cells):
        reason = Finding("fractures.no-cells", grid=q.cells.name)
    if reason is None:
        region = _merge_cells(cells) if len(cells) else _build_region(q.region_kind, numbers, mark)
        try:
            mapped_fractures = map_fractures(
                FractureMapRequest(None, replace(q.options, plane=format_exact_plane(face.plane))),
                lines=_line_strings([trace.points for trace in q.traces]),
                crs=q.crs,
                sampling_region=region,
                sets=[trace.set for trace in q.traces],
            )
            if not q.is_north_known:
                mapped_fractures = replace(mapped_fractures, y_axis="y")
            return FractureResult(
                request=q,
                face=face,
                plane=trace_plane,
                lines=lines,
                region=region,
                drawing=drawing,
                mark=mark,
                network=mapped_fractures,
            )
        except VomError as error:
            reason = cause_finding(error)
    return FractureResult(
        request=q,
        face=face,
        plane=trace_plane,
        lines=lines,
        region=region,
        drawing=drawing,
        mark=mark,
        network=None,
        reason=reason,
    )


def _default_window(points: FloatArray, snap_m: float) -> tuple[float, ...]:
    """Return the corners of a window around points (n, 2) in face coordinates.

    A margin separates the trace ends from the edge, where they would count as censored.
    """
    lower_corner, upper_corner = points.min(axis=0), points.max(axis=0)
    margin = _MARGIN_FRACTION * float((upper_corner - lower_corner).max()) + 2.0 * snap_m
    return (*(lower_corner - margin).tolist(), *(upper_corner + margin).tolist())


def _project_cells(cells: GridCells | None, face: Curtain) -> FloatArray:
    """Return the corners (n, 4, 2) of the cells in face coordinates."""
    from vomstudio.products.section.trace_map import map_to_face

    if cells is None or not len(cells.corners):
        return np.zeros((0, 4, 2))
    (face_corners,) = map_to_face([cells.corners.reshape(-1, 3)], face)
    return face_corners.reshape(-1, 4, 2)


def _merge_cells(cells: FloatArray) -> SamplingRegion:
    """Merge cells into a single sampling region."""
    import shapely

    from vomstudio.geology.fractures.network import SamplingRegion

    # Rounding of shared corners would otherwise leave gaps between cells.
    cell_size = float(np.linalg.norm(cells[0, 1] - cells[0, 0]))
    return SamplingRegion(shapely.union_all(shapely.polygons(cells), grid_size=1e-6 * cell_size))


def _build_region(
    region_kind: str, numbers: tuple[float, ...], mark: DrawingMark | None
) -> SamplingRegion:
    import shapely

    from vomstudio.geology.fractures.network import SamplingRegion
    from vomstudio.geology.fractures.pieces import circle_area
    from vomstudio.geometry.outlines.self_crossing import resolve_crossings

    if mark is None:
        return SamplingRegion()
    if region_kind == CIRCLE:
        x, y, radius = numbers
        return SamplingRegion(circle_area(x, y, radius), circle=(x, y, radius))
    if region_kind == WINDOW:
        area, warnings = resolve_crossings(shapely.Polygon(mark.points))
        return SamplingRegion(area, warnings=tuple(warnings))
    return SamplingRegion(scanlines=_line_strings([mark.points]))


def _line_strings(lines: Sequence[FloatArray]) -> ObjectArray:
    import shapely

    shapes = np.empty(len(lines), object)
    shapes[:] = [shapely.LineString(line) for line in lines]
    return shapes


def _create_drawing(
    q: FractureRequest, face: Curtain, lines: Sequence[FloatArray], cells: FloatArray
) -> Drawing:
    from vomstudio.products.ortho.vector_drawing import Drawing, DrawingShape
    from vomstudio.products.section.writing import end_names

    points = np.concatenate([*lines, cells.reshape(-1, 2)])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = max(0.05 * float((high - low).max()), 1e-3)
    unit = "m" if q.is_metric else tr("units")
    up_title = (
        tr("Z ({unit})", unit=unit) if face.vertical else tr("up the face ({unit})", unit=unit)
    )
    shapes = (
        *(DrawingShape("cells", cell, _CELL_COLOR, is_closed=True) for cell in cells),
        *(
            DrawingShape("traces", line, trace.color)
            for trace, line in zip(q.traces, lines, strict=True)
        ),
    )
    return Drawing(
        shapes,
        np.stack([low - margin, high + margin]),
        end_names(face, q.is_north_known),
        (tr("along the face ({unit})", unit=unit), up_title),
        is_metric=q.is_metric,
    )


def draw_figure(mapped_network: MappedNetwork, dpi: float = 150.0) -> bytes:
    """Draw the figure as PNG. Runs in a worker thread."""
    from vomstudio.products.fractures.figure import write_fractures

    file = io.BytesIO()
    write_fractures(file, mapped_network, format="png", dpi=dpi)
    return file.getvalue()


def write_figure(mapped_network: MappedNetwork, path: Path) -> None:
    """Write the figure as SVG, PDF or PNG. Runs in a worker thread."""
    from vomstudio.core.files.atomic import atomic_write
    from vomstudio.products.fractures.figure import write_fractures

    with atomic_write(path, True) as temporary_path:
        write_fractures(
            temporary_path, mapped_network, format=path.suffix.lower().removeprefix(".")
        )
