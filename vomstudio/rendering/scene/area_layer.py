"""Painted areas of surfaces, drawn translucently over the outcrop.

An area may have a hundred thousand faces. Areas are therefore divided into a fixed number of
bins with one actor each, so that a change of one area rebuilds only its bin. The selected areas
and the area that is being painted are drawn a second time by separate actors.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPlaneCollection, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer

from vomstudio.core.arrays import Float32Array, FloatArray
from vomstudio.rendering.prepare import vtk_data
from vomstudio.rendering.view.drawing import FeatureDrawing
from vomstudio.studio.tools.interaction_types import Area

Color = tuple[float, float, float]
# Returns the metres per device pixel at a point (3,) in the World frame.
Pixel = Callable[[FloatArray], float]

BIN_COUNT = 32
OPACITY = 0.36
SELECTED_OPACITY = 0.14
BORDER_WIDTH = 2.0
SELECTED_BORDER_WIDTH = 3.0
MIN_DOT_PIXELS, MAX_DOT_PIXELS = 3.0, 9.0
WHITE = (1.0, 1.0, 1.0)

# Offsets, in depth-buffer steps, by which an area is drawn in front of its surface. While the
# camera moves, a large model is drawn as a proxy, which has a rougher surface.
SURFACE_OFFSET = -60.0
PROXY_OFFSET = -600.0


class _Piece:
    """Actors of areas: translucent faces, translucent dots and borders."""

    def __init__(self, renderer: vtkRenderer, opacity: float, width: float) -> None:
        self.fill, self.dots, self.border = vtkActor(), vtkActor(), vtkActor()
        self.opacity, self.width = opacity, width
        # Centre of the dots, and mean distance between neighbouring dots.
        self.place: FloatArray | None = None
        self.spacing = 0.0
        for actor in (self.fill, self.dots, self.border):
            mapper = vtkPolyDataMapper()
            mapper.SetInputData(vtkPolyData())
            actor.SetMapper(mapper)
            actor.GetProperty().LightingOff()
            actor.VisibilityOff()
            renderer.AddActor(actor)
        self.fill.GetProperty().SetOpacity(opacity)
        self.dots.GetProperty().SetOpacity(opacity)

    def clip(self, planes: vtkPlaneCollection | None) -> None:
        for actor in (self.fill, self.dots, self.border):
            vtk_data.clip(actor, planes)

    def set(self, areas: list[tuple[Area, Color, Color]], origin: FloatArray) -> None:
        """Set the areas with their fill and border colours."""
        faces = [(a, a.corners, color) for a, color, _ in areas if a.corners.ndim == 3]
        dots = [(a, _shuffle(a.corners), color) for a, color, _ in areas if a.corners.ndim == 2]
        edges = [(a, a.border, color) for a, _, color in areas]
        data = _create_points(faces, origin)
        data.SetPolys(vtk_data.uniform_cells(0, data.GetNumberOfPoints() // 3, 3))
        vtk_data.show(self.fill, data)
        data = _create_points(dots, origin)
        data.SetVerts(vtk_data.uniform_cells(0, data.GetNumberOfPoints(), 1))
        vtk_data.show(self.dots, data)
        data = _create_points(edges, origin)
        data.SetLines(vtk_data.uniform_cells(0, data.GetNumberOfPoints() // 2, 2))
        vtk_data.show(self.border, data)
        for actor in (self.fill, self.dots, self.border):
            actor.SetVisibility(actor.GetMapper().GetInput().GetNumberOfPoints() > 0)
        self.place = dots[0][0].origin if dots else None
        self.spacing = _typical_spacing(dots[0][1]) if dots else 0.0

    def offset_from_surface(self, offset_steps: float, scale: float, pixel: Pixel | None) -> None:
        self.border.GetProperty().SetLineWidth(self.width * scale)
        for actor, offset in (
            (self.fill, offset_steps),
            (self.dots, 4.0 * offset_steps),
            (self.border, 2.0 * offset_steps),
        ):
            mapper = actor.GetMapper()
            mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(0.0, offset)
            mapper.SetRelativeCoincidentTopologyPointOffsetParameter(offset)
            mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0.0, offset)
        if self.place is not None and pixel is not None:
            self._set_dot_spacing(max(self.spacing / pixel(self.place), 1e-3), scale)

    def _set_dot_spacing(self, spacing: float, scale: float) -> None:
        """Adapt the size and number of the dots to their `spacing` in pixels."""
        size = min(max(1.3 * spacing, MIN_DOT_PIXELS * scale), MAX_DOT_PIXELS * scale)
        halvings = max(0, math.floor(2.0 * math.log2(size / spacing) - 1.0))
        layers = max((size / spacing) ** 2 / 2.0**halvings, 1.0)
        self.dots.GetProperty().SetPointSize(size)
        self.dots.GetProperty().SetOpacity(1.0 - (1.0 - self.opacity) ** (1.0 / layers))
        data = self.dots.GetMapper().GetInput()
        # The dots are shuffled, so that the first of them represent all dots.
        count = -(-data.GetNumberOfPoints() // 2**halvings)
        if data.GetNumberOfCells() != count:
            data.SetVerts(vtk_data.uniform_cells(0, count, 1))
            data.Modified()


class AreaLayer:
    """Layer of the areas on the models, in which selected and live areas are emphasised."""

    def __init__(self) -> None:
        self.scale = 1.0
        self._renderer: vtkRenderer | None = None
        self._emphasis: vtkRenderer | None = None
        self._origin: FloatArray = np.zeros(3)
        self._drawings: dict[str, FeatureDrawing] = {}
        self._selected_ids: frozenset[str] = frozenset()
        self._bins: dict[int, _Piece] = {}
        self._stale_bins: set[int] = set()
        self._selected_piece: _Piece | None = None
        self._is_selection_stale = False
        self._preview_areas: list[tuple[Area, Color]] = []
        self._live_piece: _Piece | None = None
        self._is_preview_stale = False
        self._planes: vtkPlaneCollection | None = None

    @property
    def is_emphasis_only(self) -> bool:
        """Whether nothing except the emphasis has changed since the last drawing."""
        return not self._stale_bins

    def attach(self, renderer: vtkRenderer, emphasis: vtkRenderer) -> None:
        """Add the actors to the renderers; `emphasis` draws selected and live areas."""
        self._renderer, self._emphasis = renderer, emphasis
        self._mark_all_stale()

    def set_origin(self, origin: FloatArray) -> None:
        self._origin = origin
        self._mark_all_stale()

    def clip(self, planes: vtkPlaneCollection | None) -> None:
        """Clip all areas to the inner side of planes."""
        self._planes = planes
        for piece in (*self._bins.values(), self._selected_piece, self._live_piece):
            if piece is not None:
                piece.clip(planes)

    def _piece(self, renderer: vtkRenderer, opacity: float, width: float) -> _Piece:
        piece = _Piece(renderer, opacity, width)
        piece.clip(self._planes)
        return piece

    def _mark_all_stale(self) -> None:
        self._stale_bins = {_bin_number(key) for key in self._drawings}
        self._is_selection_stale = self._is_preview_stale = True

    def change(self, key: str, drawing: FeatureDrawing | None) -> None:
        previous_drawing = self._drawings.pop(key, None)
        if drawing is not None and drawing.area is not None and drawing.visible:
            self._drawings[key] = drawing
        current = self._drawings.get(key)
        if (previous_drawing and previous_drawing.area) is (current and current.area) and (
            previous_drawing and previous_drawing.color
        ) == (current and current.color):
            return
        self._stale_bins.add(_bin_number(key))
        self._is_selection_stale = self._is_selection_stale or key in self._selected_ids

    def select(self, ids: frozenset[str]) -> None:
        self._is_selection_stale = self._is_selection_stale or ids != self._selected_ids
        self._selected_ids = ids

    def set_preview_areas(self, areas: list[tuple[Area, Color]]) -> None:
        """Show the areas of an unfinished feature with their colours."""
        self._preview_areas = areas
        self._is_preview_stale = True

    def refresh(self, *, is_moving: bool, pixel: Pixel | None = None) -> None:
        renderer, emphasis = self._renderer, self._emphasis
        if renderer is None or emphasis is None:
            return
        for number in self._stale_bins:
            piece = self._bins.get(number)
            if piece is None:
                piece = self._bins[number] = self._piece(renderer, OPACITY, BORDER_WIDTH)
            drawings = [d for key, d in self._drawings.items() if _bin_number(key) == number]
            piece.set([(d.area, d.color, d.color) for d in drawings if d.area], self._origin)
        self._stale_bins.clear()
        if self._is_selection_stale:
            self._is_selection_stale = False
            if self._selected_piece is None:
                self._selected_piece = self._piece(
                    emphasis, SELECTED_OPACITY, SELECTED_BORDER_WIDTH
                )
            selected_drawings = [
                d for key, d in self._drawings.items() if key in self._selected_ids
            ]
            self._selected_piece.set(
                [(d.area, d.color, WHITE) for d in selected_drawings if d.area], self._origin
            )
        if self._is_preview_stale:
            self._is_preview_stale = False
            if self._live_piece is None:
                self._live_piece = self._piece(emphasis, OPACITY, BORDER_WIDTH)
            self._live_piece.set(
                [(*live_drawing, WHITE) for live_drawing in self._preview_areas], self._origin
            )
        offset = PROXY_OFFSET if is_moving else SURFACE_OFFSET
        for piece in (*self._bins.values(), self._selected_piece, self._live_piece):
            if piece is not None:
                piece.offset_from_surface(offset, self.scale, pixel)


def area_box(area: Area) -> FloatArray:
    """Return the minimum and maximum corners (2, 3) of an area in the World frame."""
    # Reduces column by column, because a reduction along rows of three elements is many times
    # slower.
    corners = area.corners if len(area.corners) else area.border
    columns = corners.reshape(-1, 3).T
    box = [[column.min() for column in columns], [column.max() for column in columns]]
    return np.asarray(np.array(box, np.float64) + area.origin)


def _bin_number(key: str) -> int:
    return zlib.crc32(key.encode()) % BIN_COUNT


def _shuffle(points: Float32Array) -> Float32Array:
    return points[np.random.default_rng(0).permutation(len(points))]


def _typical_spacing(points: Float32Array) -> float:
    """Return the approximate mean distance between neighbouring points on the surface.

    Return 0 for fewer than three points.
    """
    if len(points) < 3:
        return 0.0
    values = np.linalg.eigvalsh(np.cov(points.T.astype(np.float64)))
    # A disc of radius R has a variance of R^2 / 4 along each axis in its plane.
    area = 4.0 * np.pi * float(np.sqrt(max(values[1], 0.0) * values[2]))
    return float(np.sqrt(area / len(points)))


def _create_points(
    parts: list[tuple[Area, Float32Array, Color]], origin: FloatArray
) -> vtkPolyData:
    data = vtkPolyData()
    runs = [
        corners.reshape(-1, 3) + (area.origin - origin).astype(np.float32)
        for area, corners, _ in parts
    ]
    if not sum(map(len, runs)):
        return data
    data.SetPoints(vtk_data.vtk_points(np.concatenate(runs)))
    colors = np.array([vtk_data.rgb(color) for _, _, color in parts], np.uint8)
    vtk_data.set_colors(data, np.repeat(colors, [len(r) for r in runs], axis=0))
    return data
