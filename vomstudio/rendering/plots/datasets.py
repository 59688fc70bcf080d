"""Conversion of models to PyVista data sets.

Coordinates are World coordinates minus an integer origin near the centre of the model.
The origin is stored in `field_data["origin"]`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.arrays import ByteArray, FloatArray, GenericArray, Int32Array, IntArray
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Material, Mesh

if TYPE_CHECKING:
    from pyvista import MultiBlock as MultiBlock
    from pyvista import PolyData as PolyData


def local_origin(bounds: FloatArray) -> FloatArray:
    """Return an integer origin (3,), in metres, near the centre of bounds (2, 3)."""
    return np.asarray(np.round(np.mean(bounds, axis=0)), np.float64)


def mesh_dataset(mesh: Mesh, origin: FloatArray) -> PolyData | MultiBlock:
    """Return a mesh as PolyData, or as MultiBlock with one block per material.

    Parameters
    ----------
    mesh : Mesh
        Mesh in the World frame.
    origin : (3,) float64
        Origin that is subtracted from all coordinates.

    Returns
    -------
    PolyData or MultiBlock
        Each block has active texture coordinates if the mesh has any. Its `field_data` contains
        the origin ("origin"), the names of its material ("material") and texture file ("texture"),
        and its colour ("diffuse"), if present.
    """
    import pyvista

    if len(mesh.materials) < 2:
        material = mesh.materials[0] if mesh.materials else None
        return _block(mesh, mesh.faces, origin, material)
    blocks = pyvista.MultiBlock()
    for i, material in enumerate(mesh.materials):
        first_face, last_face = mesh.material_offsets[i : i + 2]
        if last_face > first_face:
            blocks.append(
                _block(mesh, mesh.faces[first_face:last_face], origin, material), material.name
            )
    blocks.add_field_data(origin, "origin")
    return blocks


def cloud_dataset(cloud: PointCloud, origin: FloatArray) -> PolyData:
    """Return a point cloud as PolyData with colours, normals and fields."""
    import pyvista

    data = pyvista.PolyData(np.asarray(cloud.points) - origin)
    _add_values(data, cloud.colors, cloud.fields, None)
    if cloud.normals is not None:
        data.point_data["Normals"] = np.asarray(cloud.normals)
    data.add_field_data(origin, "origin")
    return data


def _block(
    mesh: Mesh, faces: Int32Array, origin: FloatArray, material: Material | None
) -> PolyData:
    import pyvista

    used_rows, rows = np.unique(faces, return_inverse=True)
    used_indices = used_rows.astype(np.int64)
    corners: Any = rows.reshape(-1, 3).astype(np.int64)
    data: PolyData = pyvista.PolyData.from_regular_faces(
        mesh.vertices[used_indices] - origin, corners
    )
    _add_values(data, mesh.colors, mesh.fields, used_indices)
    if mesh.uv is not None:
        # VTK requires separate texture coordinates for every corner.
        data.active_texture_coordinates = np.nan_to_num(mesh.uv[used_indices].astype(np.float64))
    if material is not None:
        data.add_field_data([material.name], "material")
        if material.texture is not None:
            data.add_field_data([str(material.texture)], "texture")
        if material.diffuse is not None:
            data.add_field_data(np.array(material.diffuse), "diffuse")
    data.add_field_data(origin, "origin")
    return data


def _add_values(
    data: Any,
    colors: ByteArray | None,
    fields: Mapping[str, GenericArray],
    rows: IntArray | None,
) -> None:
    for name, values in fields.items():
        data.point_data[name] = np.asarray(values if rows is None else values[rows])
    if colors is not None:
        data.point_data["RGB"] = np.asarray(colors if rows is None else colors[rows])
    data.set_active_scalars("RGB" if colors is not None else None)


def dataset_blocks(data: Any) -> Sequence[Any]:
    """Return the data sets of a MultiBlock, or the data set itself."""
    import pyvista

    return list(data) if isinstance(data, pyvista.MultiBlock) else [data]


def dataset_triangles(data: Any) -> tuple[FloatArray, IntArray]:
    """Return the points and triangles of a data set or of all its blocks.

    Parameters
    ----------
    data : DataSet or MultiBlock
        ``field_data["origin"]`` (3,) is added to its points, if present.

    Returns
    -------
    points : (n, 3) float64
    faces : (m, 3) int64
        Empty if the data set has no faces.
    """
    points, faces, count = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], 0
    for block in dataset_blocks(data):
        surface = block.extract_surface() if not hasattr(block, "is_all_triangles") else block
        surface = surface.triangulate()
        origin = np.asarray(block.field_data.get("origin", 0.0))
        points.append(np.asarray(surface.points, np.float64) + origin)
        if surface.faces.size:
            faces.append(surface.faces.reshape(-1, 4)[:, 1:] + count)
        count += surface.n_points
    return np.vstack(points), np.vstack(faces)


def texture_file(block: Any) -> Path | None:
    """Return the texture file of a block.

    Return None if the block has no texture or no texture coordinates, or if the file is missing.
    """
    if "texture" not in block.field_data or block.active_texture_coordinates is None:
        return None
    path = Path(str(block.field_data["texture"][0]))
    return path if path.is_file() else None
