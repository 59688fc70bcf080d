"""Lines and discs of the features as a handful of actors, however many features there are."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import count

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPlaneCollection, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor, vtkMapper, vtkPolyDataMapper, vtkRenderer

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.rendering.prepare import vtk_data
from vomstudio.rendering.scene.area_layer import AreaLayer, Pixel
from vomstudio.rendering.scene.feature_runs import FeatureRuns, Runs, lines_of, spots
from vomstudio.rendering.view.drawing import FeatureDrawing
from vomstudio.studio.tools.interaction_types import Area

LINE_WIDTH = 3.0
SELECTED_WIDTH = 5.0
HALO_EXTRA = 2.0
SELECTED_HALO_EXTRA = 4.0
THIN_ABOVE = 4000
"""Points of lines above which only the lines themselves are drawn while the camera moves."""

FEW = 64
"""Changes up to which the picture of all other features is kept."""

DISC_OPACITY = 0.32
HIDDEN_OPACITY = 0.28
DARK = (20, 20, 22)
BRIGHT = (255, 255, 255)

# Steps of the depth buffer (1/65536 of its range) by which lines stand before the surface that
# they lie on, and by which the faint copy stands before everything. The first has to cover the rise
# of a slanting surface across half a line's width, or the halo is cut off on the near side.
OVER_SURFACE = -150.0
OVER_ALL = -65000.0


class FeatureLayer:
    """Registered drawings and the actors made of them.

    drawings : in the order in which they came, in which they are drawn
    """

    def __init__(self) -> None:
        self.drawings: dict[str, FeatureDrawing] = {}
        self.selected: frozenset[str] = frozenset()
        self.areas = AreaLayer()
        self.scale = 1.0
        self._origin: FloatArray = np.zeros(3)
        self._runs = FeatureRuns()
        self._corners: FloatArray = np.zeros((0, 3))
        self.thin = False
        self._stale = True
        self._changed: list[FeatureDrawing] = []
        self._whole = False
        self._chosen_stale = True
        self._actors: dict[str, vtkActor] = {}
        self._numbers: dict[str, int] = {}
        self._next = count()

    def changed(self) -> FloatArray | None:
        """(n, 3) World points of what has come or gone since the features were drawn last, the
        selection and what is being painted aside; None where that may be anything."""
        if self._stale or not self.areas.only_emphasis:
            return None
        return np.concatenate([np.zeros((0, 3)), *(spots(drawing) for drawing in self._changed)])

    def attach(self, renderer: vtkRenderer, emphasis: vtkRenderer) -> None:
        """emphasis : draws what is selected, over all others"""
        # Polygons stay where they are: only the lines of this layer are shifted.
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
            look = actor.GetProperty()
            look.LightingOff()
            # Drawn one over the other in this order, and without a trace in the depth buffer: what
            # stands before the surface by an offset would hide the very points that it runs through
            # from `Scene.seen`.
            actor.ForceTranslucentOn()
            selected = name.endswith("+")
            over = 2.5 * OVER_SURFACE if selected else OVER_SURFACE
            if name == "discs":
                look.SetOpacity(DISC_OPACITY)
            elif name.startswith("halo"):
                mapper.ScalarVisibilityOff()
                look.SetColor(*(v / 255.0 for v in (BRIGHT if selected else DARK)))
                mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0.0, over)
            elif name.startswith("line"):
                mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0.0, over - 8.0)
            else:
                look.SetOpacity(HIDDEN_OPACITY)
                mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0.0, OVER_ALL)
            self._actors[name] = actor
            (emphasis if selected else renderer).AddActor(actor)
        self._stale = True

    def set_origin(self, origin: FloatArray) -> None:
        self._origin = origin
        self._runs.set_origin(origin)
        self.areas.set_origin(origin)
        self._stale = True

    def clip(self, planes: vtkPlaneCollection | None) -> None:
        """Draw only what lies on the inner side of all these planes."""
        self.areas.clip(planes)
        for actor in self._actors.values():
            vtk_data.clip(actor, planes)

    def set_scale(self, scale: float) -> None:
        """Device pixels per logical pixel: widths are logical."""
        self.scale = scale
        self.areas.scale = scale
        self._stale = True

    def change(self, changes: Mapping[str, FeatureDrawing | None]) -> None:
        for key, drawing in changes.items():
            if not self._stale:
                self._changed += [d for d in (self.drawings.get(key), drawing) if d is not None]
            if drawing is None:
                self.drawings.pop(key, None)
                self._numbers.pop(key, None)
            else:
                self.drawings[key] = drawing
                self._numbers.setdefault(key, next(self._next))
            self.areas.change(key, drawing)
        self._stale = self._stale or len(self._changed) > FEW
        self._chosen_stale = True
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
        self._chosen_stale = True

    def set_live(self, area: Area | None, color: tuple[float, float, float]) -> None:
        """What a brush is touching; None for nothing."""
        self.areas.set_live(area, color)

    def shown(self) -> list[FeatureDrawing]:
        return [d for d in self.drawings.values() if d.visible]

    @property
    def points(self) -> int:
        """Of all lines that are shown."""
        return self._runs.points

    def corners(self) -> FloatArray:
        """(8, 3) World corners of all drawings, or none."""
        return self._corners

    def refresh(
        self,
        pixel: Pixel | None = None,
        wanted: Callable[[FloatArray], BoolArray] | None = None,
    ) -> None:
        """Bring the actors up to date; called before every drawing of the layer. pixel: metres of
        a device pixel at a place in World. wanted : of boxes (n, 2, 3) in World, which features are
        to be drawn; None for all"""
        if not self._actors:
            return
        if wanted is not None:
            self._fill(*self._runs.some(wanted))
            self._whole = False
        elif self._stale or self._changed or not self._whole:
            self._fill(self._runs.lines(), self._runs.discs())
            self._whole = self._chosen_stale = True
        self._stale = False
        self._changed.clear()
        self.refresh_emphasis(pixel)

    def refresh_emphasis(self, pixel: Pixel | None = None) -> None:
        """Bring those actors up to date that draw what is selected or being painted."""
        if not self._actors:
            return
        self.areas.refresh(moving=self.thin, pixel=pixel)
        if self._chosen_stale:
            # The selected ones are drawn once more over all the others, so that a change of the
            # selection leaves the large arrays alone.
            self._chosen_stale = False
            # In the order of the others: which of two that cross is on top is no matter of chance.
            keys = sorted(self.selected & self.drawings.keys(), key=self._numbers.__getitem__)
            shown = [d for d in map(self.drawings.__getitem__, keys) if d.visible]
            runs = lines_of(shown, self._origin)
            self._dress("+", _poly(runs, polygons=False), SELECTED_WIDTH, SELECTED_HALO_EXTRA)
        points = self._actors["line"].GetMapper().GetInput().GetNumberOfPoints()
        rich = not self.thin or points < THIN_ABOVE
        for name, actor in self._actors.items():
            filled = actor.GetMapper().GetInput().GetNumberOfPoints() > 0
            actor.SetVisibility(filled and (rich or name not in ("halo", "hidden")))

    def _fill(self, lines: Runs, discs: Runs) -> None:
        self._dress("", _poly(lines, polygons=False), LINE_WIDTH, HALO_EXTRA)
        vtk_data.show(self._actors["discs"], _poly(discs, polygons=True))

    def _dress(self, mark: str, data: vtkPolyData, width: float, halo: float) -> None:
        for name, wide in (("halo", width + halo), ("line", width), ("hidden", width)):
            actor = self._actors[name + mark]
            vtk_data.show(actor, data)
            actor.GetProperty().SetLineWidth(wide * self.scale)


def _poly(runs: Runs, *, polygons: bool) -> vtkPolyData:
    data = vtkPolyData()
    if not len(runs.sizes):
        return data
    data.SetPoints(vtk_data.vtk_points(runs.points))
    cells = vtk_data.cells_of(runs.sizes)
    if polygons:
        data.SetPolys(cells)
    else:
        data.SetLines(cells)
    vtk_data.set_colors(data, runs.colors)
    return data
