"""Faces and points of a model that are not drawn and not picked, while the rest of it is."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vomstudio.core.arrays import BoolArray, IntegerArray
from vomstudio.geometry.mesh import Mesh
from vomstudio.rendering.prepare import vtk_data
from vomstudio.rendering.scene.model_scene import ModelScene, Part


def hide(model: ModelScene, hidden: BoolArray | None) -> None:
    """hidden : (n,) which faces or points; None for none"""
    before, model.hidden = model.hidden, hidden
    for number, part in enumerate(model.parts):
        _dress(model, number, part, before)
    if isinstance(model.data, Mesh) and model.proxies:
        _thin_proxies(model, model.data)


def hide_newest(model: ModelScene) -> None:
    """Of the part that has come last."""
    if model.hidden is not None:
        _dress(model, len(model.parts) - 1, model.parts[-1], None)


def _dress(model: ModelScene, number: int, part: Part, before: BoolArray | None) -> None:
    data = part.actor.GetMapper().GetInput()
    assert isinstance(data, vtkPolyData)
    if isinstance(model.data, Mesh):
        chunk = model.face_chunks[number]
        if _none_of(chunk.face_ids, before) and _none_of(chunk.face_ids, model.hidden):
            return
        shown = chunk.faces if model.hidden is None else chunk.faces[~model.hidden[chunk.face_ids]]
        data.SetPolys(vtk_data.triangle_cells(shown))
        part.elements = len(shown)
    else:
        points = model.point_chunks[number]
        if _none_of(points.point_ids, before) and _none_of(points.point_ids, model.hidden):
            return
        at = points.points
        if model.hidden is not None:
            # A point that is hidden stands where one stands that is not.
            gone = model.hidden[points.point_ids]
            seen = np.flatnonzero(~gone)
            at = at.copy()
            at[gone] = at[seen[0]] if len(seen) else np.float32(np.nan)
        data.SetPoints(vtk_data.vtk_points(at))
    data.Modified()
    part.uploaded = False


def _none_of(ids: IntegerArray, mask: BoolArray | None) -> bool:
    return mask is None or not mask[ids].any()


def _thin_proxies(model: ModelScene, mesh: Mesh) -> None:
    """What stands for the model while it moves, without what hangs on hidden faces alone."""
    seen = np.ones(len(mesh.vertices), np.bool_)
    if model.hidden is not None:
        seen[:] = False
        seen[np.asarray(mesh.faces)[~model.hidden].ravel()] = True
    for part in model.proxies:
        data = part.actor.GetMapper().GetInput()
        if part.whole is None:
            cells = vtk_data.array_of(data.GetPolys().GetConnectivityArray())
            part.whole = np.array(cells, np.int32).reshape(-1, 3)
        corners = seen[part.rows[part.whole]]
        data.SetPolys(vtk_data.triangle_cells(part.whole[corners.any(axis=1)]))
        data.Modified()
        part.uploaded = False
