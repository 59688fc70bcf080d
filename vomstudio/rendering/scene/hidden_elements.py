"""Hiding of faces and points of models, which are then neither drawn nor picked."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vomstudio.core.arrays import BoolArray, IntegerArray
from vomstudio.geometry.mesh import Mesh
from vomstudio.rendering.prepare import vtk_data
from vomstudio.rendering.scene.model_scene import ModelScene, Part


def hide(model: ModelScene, is_hidden: BoolArray | None) -> None:
    """Hide the marked faces or points (n,) of a model; None shows all."""
    was_hidden, model.hidden = model.hidden, is_hidden
    for number, part in enumerate(model.parts):
        _hide_part(model, number, part, was_hidden)
    if isinstance(model.data, Mesh) and model.proxies:
        _thin_proxies(model, model.data)


def hide_newest(model: ModelScene) -> None:
    """Hide elements of the part of a model that was added last."""
    if model.hidden is not None:
        _hide_part(model, len(model.parts) - 1, model.parts[-1], None)


def _hide_part(model: ModelScene, number: int, part: Part, was_hidden: BoolArray | None) -> None:
    data = part.actor.GetMapper().GetInput()
    assert isinstance(data, vtkPolyData)
    if isinstance(model.data, Mesh):
        chunk = model.face_chunks[number]
        if _has_no_masked(chunk.face_ids, was_hidden) and _has_no_masked(
            chunk.face_ids, model.hidden
        ):
            return
        faces = chunk.faces if model.hidden is None else chunk.faces[~model.hidden[chunk.face_ids]]
        data.SetPolys(vtk_data.triangle_cells(faces))
        part.elements = len(faces)
    else:
        points = model.point_chunks[number]
        if _has_no_masked(points.point_ids, was_hidden) and _has_no_masked(
            points.point_ids, model.hidden
        ):
            return
        position = points.points
        if model.hidden is not None:
            # Hidden points are moved to the position of a visible point.
            is_hidden = model.hidden[points.point_ids]
            visible_rows = np.flatnonzero(~is_hidden)
            position = position.copy()
            position[is_hidden] = (
                position[visible_rows[0]] if len(visible_rows) else np.float32(np.nan)
            )
        data.SetPoints(vtk_data.vtk_points(position))
    data.Modified()
    part.is_uploaded = False


def _has_no_masked(ids: IntegerArray, mask: BoolArray | None) -> bool:
    return mask is None or not mask[ids].any()


def _thin_proxies(model: ModelScene, mesh: Mesh) -> None:
    """Remove triangles that represent only hidden faces from the proxies."""
    is_visible = np.ones(len(mesh.vertices), np.bool_)
    if model.hidden is not None:
        is_visible[:] = False
        is_visible[np.asarray(mesh.faces)[~model.hidden].ravel()] = True
    for part in model.proxies:
        data = part.actor.GetMapper().GetInput()
        if part.all_triangles is None:
            cells = vtk_data.to_array(data.GetPolys().GetConnectivityArray())
            part.all_triangles = np.array(cells, np.int32).reshape(-1, 3)
        corners = is_visible[part.rows[part.all_triangles]]
        data.SetPolys(vtk_data.triangle_cells(part.all_triangles[corners.any(axis=1)]))
        data.Modified()
        part.is_uploaded = False
