"""Camera positions of photos, drawn as small pyramids over the outcrop."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry.frusta import Frustum
from vomstudio.rendering.prepare import vtk_data

CAMERA_COLOR = (0.34, 0.71, 0.91)
SELECTED_COLOR = (0.90, 0.62, 0.0)
# Vermilion, for photos that are weakly connected to the others.
WEAK_COLOR = (0.84, 0.37, 0.0)
DARK_COLOR = (0.08, 0.08, 0.09)
LINE_WIDTH = 1.6
HALO_WIDTH = 3.6
FACE_OPACITY = 0.16
SELECTED_OPACITY = 0.42


class CameraLayer:
    """Layer of cameras, which needs seven actors for any number of cameras."""

    def __init__(self) -> None:
        self.scale = 1.0
        self.frusta: tuple[Frustum, ...] = ()
        self.selection: frozenset[str] = frozenset()
        self._origin: FloatArray = np.zeros(3)
        self._is_stale = True
        self._actors: dict[str, vtkActor] = {}

    @property
    def is_stale(self) -> bool:
        """Whether the cameras have changed since the last drawing."""
        return self._is_stale

    def attach(self, renderer: vtkRenderer) -> None:
        for name in ("faces", "faces!", "faces+", "halo", "lines", "lines!", "lines+"):
            actor, mapper = vtkActor(), vtkPolyDataMapper()
            mapper.SetInputData(vtkPolyData())
            mapper.ScalarVisibilityOff()
            actor.SetMapper(mapper)
            display_property = actor.GetProperty()
            display_property.LightingOff()
            # Does not write depth, because hidden points of the rock are determined from the
            # depth.
            actor.ForceTranslucentOn()
            colors = {"o": DARK_COLOR, "+": SELECTED_COLOR, "!": WEAK_COLOR}
            display_property.SetColor(*colors.get(name[-1], CAMERA_COLOR))
            if name.startswith("faces"):
                display_property.SetOpacity(
                    SELECTED_OPACITY if name.endswith("+") else FACE_OPACITY
                )
            actor.VisibilityOff()
            self._actors[name] = actor
            renderer.AddActor(actor)

    def set_origin(self, origin: FloatArray) -> None:
        self._origin = origin
        self._is_stale = True

    def set_scale(self, scale: float) -> None:
        self.scale = scale
        self._is_stale = True

    def show(self, frusta: Sequence[Frustum]) -> None:
        """Set the cameras, given in the World frame."""
        self.frusta = tuple(frusta)
        self._is_stale = True

    def select(self, names: frozenset[str]) -> None:
        """Emphasise only the cameras of these photos."""
        self.selection = names
        self._is_stale = True

    def corners(self) -> FloatArray:
        """Return points (n, 3) that bound all cameras, in the World frame."""
        if not self.frusta:
            return np.zeros((0, 3))
        return np.concatenate([np.vstack([f.tip, f.corners]) for f in self.frusta])

    def refresh(self) -> None:
        """Update the actors, as required before every drawing of the layer."""
        if not self._is_stale or not self._actors:
            return
        self._is_stale = False
        selected_cameras = [f for f in self.frusta if f.name in self.selection]
        others = [f for f in self.frusta if f.name not in self.selection]
        plain_cameras = [f for f in others if not f.is_weak]
        weak_cameras = [f for f in others if f.is_weak]
        width = {
            "halo": HALO_WIDTH,
            "lines": LINE_WIDTH,
            "lines!": 1.5 * LINE_WIDTH,
            "lines+": 1.5 * LINE_WIDTH,
        }
        for name, group in (
            ("faces", plain_cameras),
            ("faces!", weak_cameras),
            ("faces+", selected_cameras),
            ("halo", list(self.frusta)),
            ("lines", plain_cameras),
            ("lines!", weak_cameras),
            ("lines+", selected_cameras),
        ):
            actor = self._actors[name]
            make = self._faces if name.startswith("faces") else self._lines
            vtk_data.show(actor, make(group))
            actor.SetVisibility(bool(group))
            if name in width:
                actor.GetProperty().SetLineWidth(width[name] * self.scale)

    def _faces(self, frusta: Sequence[Frustum]) -> vtkPolyData:
        """Return a polygon for each photo."""
        data = vtkPolyData()
        if frusta:
            runs = [f.outline[:-1] - self._origin for f in frusta]
            data.SetPoints(vtk_data.vtk_points(np.concatenate(runs).astype(np.float32)))
            data.SetPolys(vtk_data.cells_of_sizes([len(run) for run in runs]))
        return data

    def _lines(self, frusta: Sequence[Frustum]) -> vtkPolyData:
        data = vtkPolyData()
        if frusta:
            runs = []
            for f in frusta:
                runs.append(f.outline - self._origin)
                runs += [np.stack([f.tip, corner]) - self._origin for corner in f.corners]
            data.SetPoints(vtk_data.vtk_points(np.concatenate(runs).astype(np.float32)))
            data.SetLines(vtk_data.cells_of_sizes([len(run) for run in runs]))
        return data
