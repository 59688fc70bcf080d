"""Lines and discs of all features, drawn by a small number of actors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Literal

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPlaneCollection, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor, vtkMapper, vtkPolyDataMapper, vtkRenderer

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.rendering.prepare import vtk_data
from vomstudio.rendering.scene.area_layer import AreaLayer, Pixel
from vomstudio.rendering.scene.feature_runs import FeatureRuns, Runs, simplify, spots
from vomstudio.rendering.view.drawing import FeatureDrawing
from vomstudio.studio.tools.interaction_types import Area

LINE_WIDTH = 3.0
SELECTED_WIDTH = 5.0
HALO_EXTRA = 2.0
SELECTED_HALO_EXTRA = 4.0
MIN_THIN_POINTS = 4000
"""Number of line points, of all or of the selected features, above which their halos are omitted
and their lines simplified while the camera is moving."""
MOVING_VERTEX_PIXELS = 6.0
"""Length of a simplified line per vertex, logical pixels; the line deviates by less than half."""

MAX_PARTIAL_CHANGES = 64
"""Maximum number of changed features that are redrawn over the saved picture of the others."""

DISC_OPACITY = 0.32
HIDDEN_OPACITY = 0.28
DARK_COLOR = (20, 20, 22)
BRIGHT_COLOR = (255, 255, 255)

# Offsets, in depth-buffer steps (1/65536 of its range), by which lines are drawn in front of
# their surface, and by which their faint copy is drawn in front of everything. The first must
# exceed the depth change of an inclined surface across half a line width, or the near half of
# the halo is cut off.
SURFACE_OFFSET = -150.0
HIDDEN_LINE_OFFSET = -65000.0


PixelSizes = Callable[[FloatArray], FloatArray]
"""Function that returns the metres per device pixel (n,) at points (n, 3) in the World frame."""
_Content = Literal["none", "part", "simple", "all"]
"""Lines that the actors contain: none, those in a part of the view, simplified lines, or all."""


class FeatureLayer:
    """Layer that draws features, with their drawings and actors.

    `drawings` is in order of creation, which is also the drawing order.
    """

    def __init__(self) -> None:
        self.drawings: dict[str, FeatureDrawing] = {}
        self.selected: frozenset[str] = frozenset()
        self.areas = AreaLayer()
        self.scale = 1.0
        self._origin: FloatArray = np.zeros(3)
        self._runs = FeatureRuns()
        self._corners: FloatArray = np.zeros((0, 3))
        self.is_thin = False
        """Whether halos are omitted and lines simplified, if there are many."""
        self.is_simplified = False
        """Whether this was done in the last drawing."""
        self._is_stale = True
        self._changed_drawings: list[FeatureDrawing] = []
        self._content: _Content = "none"
        self._emphasis_content: _Content = "none"
        self._is_selection_stale = True
        self._pixel_sizes: PixelSizes | None = None
        self._line_points = {"": 0, "+": 0}
        self._actors: dict[str, vtkActor] = {}

    def changed(self) -> FloatArray | None:
        """Return points (n, 3) of the features that have changed since the last drawing.

        Points are in the World frame. Changes of the selection and the live area are ignored. The
        result is None if anything may have changed.
        """
        if self._is_stale or not self.areas.is_emphasis_only:
            return None
        return np.concatenate(
            [np.zeros((0, 3)), *(spots(drawing) for drawing in self._changed_drawings)]
        )

    def attach(self, renderer: vtkRenderer, emphasis: vtkRenderer) -> None:
        """Add the actors to the renderers; `emphasis` draws the selection over all features."""
        # Polygons have no offset; only the lines of this layer have one.
        vtkMapper.SetResolveCoincidentTopologyToPolygonOffset()
        vtkMapper.SetResolveCoincidentTopologyPolygonOffsetParameters(0.0, 0.0)
        vtkMapper.SetResolveCoincidentTopologyLineOffsetParameters(0.0, 0.0)
        self.areas.attach(renderer, emphasis)
        order = ["discs", "halo", "line", "hidden", "halo+", "line+", "hidden+"]
        for name in order:
            actor = vtkActor()
            mapper = vtkPolyDataMapper()
            mapper.SetInputData(vtkPolyData())
            actor.SetMapper(mapper)
            actor_property = actor.GetProperty()
            actor_property.LightingOff()
            # Drawn in this order without writing depth, because lines with an offset would hide
            # their own points in the test of visibility.
            actor.ForceTranslucentOn()
            is_selected = name.endswith("+")
            offset = 2.5 * SURFACE_OFFSET if is_selected else SURFACE_OFFSET
            if name == "discs":
                actor_property.SetOpacity(DISC_OPACITY)
            elif name.startswith("halo"):
                mapper.ScalarVisibilityOff()
                actor_property.SetColor(
                    *(v / 255.0 for v in (BRIGHT_COLOR if is_selected else DARK_COLOR))
                )
                mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0.0, offset)
            elif name.startswith("line"):
                mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0.0, offset - 8.0)
            else:
                actor_property.SetOpacity(HIDDEN_OPACITY)
                mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0.0, HIDDEN_LINE_OFFSET)
            self._actors[name] = actor
            (emphasis if is_selected else renderer).AddActor(actor)
        self._is_stale = True

    def set_origin(self, origin: FloatArray) -> None:
        self._origin = origin
        self._runs.set_origin(origin)
        self.areas.set_origin(origin)
        self._is_stale = True

    def clip(self, planes: vtkPlaneCollection | None) -> None:
        """Clip all features to the inner side of planes."""
        self.areas.clip(planes)
        for actor in self._actors.values():
            vtk_data.clip(actor, planes)

    def set_scale(self, scale: float) -> None:
        """Set the number of device pixels per logical pixel, the unit of line widths."""
        self.scale = scale
        self.areas.scale = scale
        self._is_stale = True

    def change(self, changes: Mapping[str, FeatureDrawing | None]) -> None:
        for key, drawing in changes.items():
            if not self._is_stale:
                self._changed_drawings += [
                    d for d in (self.drawings.get(key), drawing) if d is not None
                ]
            if drawing is None:
                self.drawings.pop(key, None)
            else:
                self.drawings[key] = drawing
            self.areas.change(key, drawing)
        self._is_stale = self._is_stale or len(self._changed_drawings) > MAX_PARTIAL_CHANGES
        self._is_selection_stale = True
        self._runs.change(changes)
        box = self._runs.box()
        if len(box):
            grid = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
            self._corners = np.where(grid == 1, box[1], box[0])
        else:
            self._corners = np.zeros((0, 3))

    def select(self, ids: frozenset[str]) -> None:
        self.selected = ids
        self.areas.select(ids)
        self._is_selection_stale = True

    def set_preview_areas(self, areas: list[tuple[Area, tuple[float, float, float]]]) -> None:
        """Show the areas of an unfinished feature with their colours."""
        self.areas.set_preview_areas(areas)

    def begin_moving(self, pixel_sizes: PixelSizes) -> None:
        """Adapt the simplified lines, which are drawn while the camera moves, to the view."""
        self._pixel_sizes = pixel_sizes
        self._content = "none" if self._content == "simple" else self._content
        self._is_selection_stale |= self._emphasis_content == "simple"

    def shown(self) -> list[FeatureDrawing]:
        return [d for d in self.drawings.values() if d.visible]

    @property
    def points(self) -> int:
        """Total number of points of all visible lines."""
        return self._runs.points

    def corners(self) -> FloatArray:
        """Return the corners (8, 3) of the World box of all drawings, or (0, 3) if empty."""
        return self._corners

    def refresh(
        self,
        pixel: Pixel | None = None,
        is_needed: Callable[[FloatArray], BoolArray] | None = None,
    ) -> None:
        """Update the actors, as required before every drawing of the layer.

        Parameters
        ----------
        pixel : callable, optional
            Function that returns the metres per device pixel at a point in the World frame.
        is_needed : callable, optional
            Function that returns which features to draw, given their World boxes (n, 2, 3). By
            default all features are drawn.
        """
        if not self._actors:
            return
        content: _Content = "simple" if self.is_thin and self._pixel_sizes is not None else "all"
        if is_needed is not None:
            self._fill(*self._runs.visible_runs(is_needed))
            self._content = "part"
        elif self._is_stale or self._changed_drawings or self._content != content:
            self._fill(self._runs.lines(), self._runs.discs())
            self._content = content
            self._is_selection_stale = True
        self._is_stale = False
        self._changed_drawings.clear()
        self.refresh_emphasis(pixel)

    def refresh_emphasis(
        self,
        pixel: Pixel | None = None,
        is_needed: Callable[[FloatArray], BoolArray] | None = None,
    ) -> None:
        """Update the actors of selected and live features; arguments as for `refresh`."""
        if not self._actors:
            return
        self.areas.refresh(is_moving=self.is_thin, pixel=pixel)
        content: _Content = "simple" if self.is_thin and self._pixel_sizes is not None else "all"
        if is_needed is not None or self._is_selection_stale or self._emphasis_content != content:
            # Selected features are redrawn over all features, so that a change of the selection
            # does not rebuild the large arrays. They are drawn in the same order, so that
            # crossing features always overlap in the same way.
            self._is_selection_stale = False
            self._emphasis_content = content if is_needed is None else "part"
            lines = self._runs.line_runs_by_id(self.selected, is_needed)
            self._update_lines("+", lines, SELECTED_WIDTH, SELECTED_HALO_EXTRA)
        for name, actor in self._actors.items():
            points = actor.GetMapper().GetInput().GetNumberOfPoints()
            is_omitted = name.startswith(("halo", "hidden")) and self._is_simple(name[-1:])
            actor.SetVisibility(points > 0 and not is_omitted)
        self.is_simplified = self._is_simple("") or self._is_simple("+")

    def _is_simple(self, mark: str) -> bool:
        """Return whether lines are now drawn without halos.

        `mark` is "+" for the lines of selected features.
        """
        points = self._line_points["+" if mark == "+" else ""]
        return self.is_thin and points >= MIN_THIN_POINTS

    def _fill(self, lines: Runs, discs: Runs) -> None:
        self._update_lines("", lines, LINE_WIDTH, HALO_EXTRA)
        vtk_data.show(self._actors["discs"], _poly_data(discs, draws_polygons=True))

    def _update_lines(self, mark: str, lines: Runs, width: float, halo_width: float) -> None:
        self._line_points[mark] = len(lines.points)
        if self._is_simple(mark) and self._pixel_sizes is not None:
            pixel_sizes = self._pixel_sizes(lines.points + self._origin)
            lines = simplify(lines, MOVING_VERTEX_PIXELS * self.scale * pixel_sizes)
        data = _poly_data(lines, draws_polygons=False)
        for name, line_width in (("halo", width + halo_width), ("line", width), ("hidden", width)):
            actor = self._actors[name + mark]
            vtk_data.show(actor, data)
            actor.GetProperty().SetLineWidth(line_width * self.scale)


def _poly_data(runs: Runs, *, draws_polygons: bool) -> vtkPolyData:
    data = vtkPolyData()
    if not len(runs.sizes):
        return data
    data.SetPoints(vtk_data.vtk_points(runs.points))
    cells = vtk_data.cells_of_sizes(runs.sizes)
    if draws_polygons:
        data.SetPolys(cells)
    else:
        data.SetLines(cells)
    vtk_data.set_colors(data, runs.colors)
    return data
