"""Painted pieces of surfaces, translucent over the outcrop.

They may have a hundred thousand faces each, so they are kept in a fixed number of bins, an actor
for each: a change of one of them builds its bin anew and leaves the others alone. The selected ones
are drawn a second time by actors of their own, and so is what a brush is touching.
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
# Metres of a device pixel at a place (3,) in World.
Pixel = Callable[[FloatArray], float]

BINS = 32
OPACITY = 0.36
SELECTED_OPACITY = 0.14
BORDER_WIDTH = 2.0
SELECTED_BORDER_WIDTH = 3.0
SMALLEST_DOT, LARGEST_DOT = 3.0, 9.0
WHITE = (1.0, 1.0, 1.0)

# Steps of the depth buffer by which an area stands before the surface that it is a piece of. While
# the camera moves a stand-in is drawn in the place of a large model, whose surface is rougher.
OVER_SURFACE = -60.0
OVER_STAND_IN = -600.0


class _Piece:
    """Three actors: translucent faces, translucent dots, and the lines around them."""

    def __init__(self, renderer: vtkRenderer, opacity: float, width: float) -> None:
        self.fill, self.dots, self.border = vtkActor(), vtkActor(), vtkActor()
        self.opacity, self.width = opacity, width
        # Of the dots: a place among them and the mean distance between neighbours.
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
        """Areas with the colours of their fill and of their border."""
        faces = [(a, a.corners, color) for a, color, _ in areas if a.corners.ndim == 3]
        dots = [(a, _shuffled(a.corners), color) for a, color, _ in areas if a.corners.ndim == 2]
        edges = [(a, a.border, color) for a, _, color in areas]
        data = _points(faces, origin)
        data.SetPolys(vtk_data.runs_of_cells(0, data.GetNumberOfPoints() // 3, 3))
        vtk_data.show(self.fill, data)
        data = _points(dots, origin)
        data.SetVerts(vtk_data.runs_of_cells(0, data.GetNumberOfPoints(), 1))
        vtk_data.show(self.dots, data)
        data = _points(edges, origin)
        data.SetLines(vtk_data.runs_of_cells(0, data.GetNumberOfPoints() // 2, 2))
        vtk_data.show(self.border, data)
        for actor in (self.fill, self.dots, self.border):
            actor.SetVisibility(actor.GetMapper().GetInput().GetNumberOfPoints() > 0)
        self.place = dots[0][0].origin if dots else None
        self.spacing = _spacing(dots[0][1]) if dots else 0.0

    def stand(self, over: float, scale: float, pixel: Pixel | None) -> None:
        self.border.GetProperty().SetLineWidth(self.width * scale)
        for actor, way in ((self.fill, over), (self.dots, 4.0 * over), (self.border, 2.0 * over)):
            mapper = actor.GetMapper()
            mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(0.0, way)
            mapper.SetRelativeCoincidentTopologyPointOffsetParameter(way)
            mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0.0, way)
        if self.place is not None and pixel is not None:
            self._space(max(self.spacing / pixel(self.place), 1e-3), scale)

    def _space(self, apart: float, scale: float) -> None:
        """Dots that are `apart` pixels from each other: large enough to be seen from nearby, few
        enough from afar not to hide the rock under many layers."""
        size = min(max(1.3 * apart, SMALLEST_DOT * scale), LARGEST_DOT * scale)
        halvings = max(0, math.floor(2.0 * math.log2(size / apart) - 1.0))
        layers = max((size / apart) ** 2 / 2.0**halvings, 1.0)
        self.dots.GetProperty().SetPointSize(size)
        self.dots.GetProperty().SetOpacity(1.0 - (1.0 - self.opacity) ** (1.0 / layers))
        data = self.dots.GetMapper().GetInput()
        # They are in no order, so that the first of them stand for all.
        count = -(-data.GetNumberOfPoints() // 2**halvings)
        if data.GetNumberOfCells() != count:
            data.SetVerts(vtk_data.runs_of_cells(0, count, 1))
            data.Modified()


class AreaLayer:
    def __init__(self) -> None:
        self.scale = 1.0
        self._renderer: vtkRenderer | None = None
        self._emphasis: vtkRenderer | None = None
        self._origin: FloatArray = np.zeros(3)
        self._drawings: dict[str, FeatureDrawing] = {}
        self._selected: frozenset[str] = frozenset()
        self._bins: dict[int, _Piece] = {}
        self._stale: set[int] = set()
        self._chosen: _Piece | None = None
        self._chosen_stale = False
        self._live: tuple[Area, Color] | None = None
        self._live_piece: _Piece | None = None
        self._live_stale = False
        self._planes: vtkPlaneCollection | None = None

    @property
    def only_emphasis(self) -> bool:
        """Whether no area itself has changed since they were drawn last."""
        return not self._stale

    def attach(self, renderer: vtkRenderer, emphasis: vtkRenderer) -> None:
        """emphasis : draws what is selected or being painted"""
        self._renderer, self._emphasis = renderer, emphasis
        self._all_stale()

    def set_origin(self, origin: FloatArray) -> None:
        self._origin = origin
        self._all_stale()

    def clip(self, planes: vtkPlaneCollection | None) -> None:
        """Draw only what lies on the inner side of all these planes."""
        self._planes = planes
        for piece in (*self._bins.values(), self._chosen, self._live_piece):
            if piece is not None:
                piece.clip(planes)

    def _piece(self, renderer: vtkRenderer, opacity: float, width: float) -> _Piece:
        piece = _Piece(renderer, opacity, width)
        piece.clip(self._planes)
        return piece

    def _all_stale(self) -> None:
        self._stale = {_bin(key) for key in self._drawings}
        self._chosen_stale = self._live_stale = True

    def change(self, key: str, drawing: FeatureDrawing | None) -> None:
        before = self._drawings.pop(key, None)
        if drawing is not None and drawing.area is not None and drawing.visible:
            self._drawings[key] = drawing
        after = self._drawings.get(key)
        if (before and before.area) is (after and after.area) and (before and before.color) == (
            after and after.color
        ):
            return
        self._stale.add(_bin(key))
        self._chosen_stale = self._chosen_stale or key in self._selected

    def select(self, ids: frozenset[str]) -> None:
        self._chosen_stale = self._chosen_stale or ids != self._selected
        self._selected = ids

    def set_live(self, area: Area | None, color: Color) -> None:
        """What a brush is touching; None for nothing."""
        self._live = None if area is None else (area, color)
        self._live_stale = True

    def refresh(self, *, moving: bool, pixel: Pixel | None = None) -> None:
        renderer, emphasis = self._renderer, self._emphasis
        if renderer is None or emphasis is None:
            return
        for number in self._stale:
            piece = self._bins.get(number)
            if piece is None:
                piece = self._bins[number] = self._piece(renderer, OPACITY, BORDER_WIDTH)
            inside = [d for key, d in self._drawings.items() if _bin(key) == number]
            piece.set([(d.area, d.color, d.color) for d in inside if d.area], self._origin)
        self._stale.clear()
        if self._chosen_stale:
            self._chosen_stale = False
            if self._chosen is None:
                self._chosen = self._piece(emphasis, SELECTED_OPACITY, SELECTED_BORDER_WIDTH)
            chosen = [d for key, d in self._drawings.items() if key in self._selected]
            self._chosen.set([(d.area, d.color, WHITE) for d in chosen if d.area], self._origin)
        if self._live_stale:
            self._live_stale = False
            if self._live_piece is None:
                self._live_piece = self._piece(emphasis, OPACITY, BORDER_WIDTH)
            self._live_piece.set([(*self._live, WHITE)] if self._live else [], self._origin)
        over = OVER_STAND_IN if moving else OVER_SURFACE
        for piece in (*self._bins.values(), self._chosen, self._live_piece):
            if piece is not None:
                piece.stand(over, self.scale, pixel)


def area_box(area: Area) -> FloatArray:
    """(2, 3) lowest and highest corner in World."""
    # Column by column: a reduction along rows of three is many times slower.
    drawn = area.corners if len(area.corners) else area.border
    columns = drawn.reshape(-1, 3).T
    box = [[column.min() for column in columns], [column.max() for column in columns]]
    return np.asarray(np.array(box, np.float64) + area.origin)


def _bin(key: str) -> int:
    return zlib.crc32(key.encode()) % BINS


def _shuffled(points: Float32Array) -> Float32Array:
    return points[np.random.default_rng(0).permutation(len(points))]


def _spacing(points: Float32Array) -> float:
    """Mean distance between neighbours on the surface that the points lie on, roughly."""
    if len(points) < 3:
        return 0.0
    values = np.linalg.eigvalsh(np.cov(points.T.astype(np.float64)))
    # A disc of radius R has variances of R^2 / 4 in its plane.
    area = 4.0 * np.pi * float(np.sqrt(max(values[1], 0.0) * values[2]))
    return float(np.sqrt(area / len(points)))


def _points(parts: list[tuple[Area, Float32Array, Color]], origin: FloatArray) -> vtkPolyData:
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
