"""Faces of the clipping box as VTK planes."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPlane, vtkPlaneCollection
from vtkmodules.vtkRenderingCore import vtkActor

from vomstudio.core.arrays import FloatArray
from vomstudio.rendering.prepare import vtk_data
from vomstudio.rendering.view.clipping import BOX_FACES, ClipBox


class ClipPlanes:
    """Clipping planes of `box`, outside which nothing is drawn; None disables clipping."""

    def __init__(self) -> None:
        self.box: ClipBox | None = None
        self._planes = [vtkPlane() for _ in BOX_FACES]
        self._cutting_planes: list[int] = []

    def place(self, models: Iterable[FloatArray], origin: FloatArray) -> bool:
        """Move the planes to the faces of the box; return whether the planes of `cut` change.

        Models are clipped only by the planes that they cross, because a software renderer takes
        a third longer with all six planes.

        Parameters
        ----------
        models : iterable of (n, 3) float64
            Corners of a box around each model, in the World frame.
        origin : (3,) float64
            Origin of VTK's coordinates in the World frame.
        """
        cutting_planes: list[int] = []
        if self.box is not None:
            corners = list(models)
            for k, (axis, side) in enumerate(BOX_FACES):
                normal = np.zeros(3)
                normal[axis] = -1.0 if side else 1.0
                position = self.box.face_centre(axis, side)
                self._planes[k].SetNormal(*normal)
                self._planes[k].SetOrigin(*(position - origin))
                if any(((c - position) @ normal).min() < 0.0 for c in corners):
                    cutting_planes.append(k)
        is_changed = cutting_planes != self._cutting_planes
        self._cutting_planes = cutting_planes
        return is_changed

    def cut(self, actor: vtkActor) -> None:
        """Clip an actor of a model."""
        planes = [self._planes[k] for k in self._cutting_planes]
        vtk_data.clip(actor, collection(planes) if planes else None)

    def all_planes(self) -> vtkPlaneCollection:
        """Return all six planes, which clip the features over the models."""
        return collection(self._planes)


def collection(planes: list[vtkPlane]) -> vtkPlaneCollection:
    """Return a VTK collection of planes."""
    out = vtkPlaneCollection()
    for plane in planes:
        out.AddItem(plane)
    return out
