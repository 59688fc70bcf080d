"""Conversion of a model's arrays to data for drawing and picking, in a worker thread.

All results are private copies until they are handed over through `emit`; then they belong to
the drawing thread. The work is done in pieces whose numpy and VTK calls release the interpreter
lock, so that the window stays responsive.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray
from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkStaticCellLocator

from vomstudio.core.arrays import (
    ByteArray,
    Float32Array,
    FloatArray,
    FloatingArray,
    Int32Array,
    IntegerArray,
)
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.progressive_order import arrange
from vomstudio.geometry.streaming.octree import (
    POINT_BUDGET,
    ArrangedNodes,
    CloudNodes,
    StreamedCloud,
)
from vomstudio.rendering.prepare import vtk_data
from vomstudio.rendering.prepare.events import (
    ChunksDone,
    Emit,
    FieldReady,
    LocatorReady,
    MeshChunkReady,
    Problem,
    ProxyReady,
    Stopped,
    Submit,
    TextureReady,
    TexturesDone,
)
from vomstudio.rendering.prepare.streaming import Streamer
from vomstudio.rendering.prepare.textures import Texture, TextureProblem, load_texture, overview
from vomstudio.rendering.view import spatial_blocks
from vomstudio.rendering.view.scalars import FieldStyle, make_scale, reader
from vomstudio.rendering.view.spatial_blocks import FaceChunk

PROXY_FACES = 45_000
MAX_FACES_WITHOUT_PROXY = 60_000
"""Number of faces that a software renderer draws at every step of a drag, beside features."""
FACES_PER_CHUNK = 30_000
PIECE_SIZE = 1 << 18
IMAGE_ROW_LENGTH = 3 * 512

NEUTRAL_COLOR = (190, 186, 178)


def pieces(count: int, stop_event: threading.Event, size: int = PIECE_SIZE) -> Iterator[slice]:
    """Yield consecutive slices of a range; raise Stopped when `stop_event` is set."""
    for start in range(0, count, size):
        if stop_event.is_set():
            raise Stopped
        yield slice(start, min(start + size, count))


def finite_bounds(points: FloatingArray, stop_event: threading.Event) -> FloatArray:
    """Return the bounds (2, 3) of points, ignoring NaN; zeros if they are not finite."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for part in pieces(len(points), stop_event):
        # Reduces long rows, because a reduction along rows of three elements is eight times
        # slower.
        flat_coordinates = np.ascontiguousarray(points[part]).reshape(-1)
        row_end = len(flat_coordinates) // IMAGE_ROW_LENGTH * IMAGE_ROW_LENGTH
        for rows in (
            flat_coordinates[:row_end].reshape(-1, IMAGE_ROW_LENGTH),
            flat_coordinates[row_end:].reshape(-1, 3),
        ):
            if rows.size:
                lowest_corner, highest_corner = (
                    np.fmin.reduce(rows, axis=0),
                    np.fmax.reduce(rows, axis=0),
                )
                low = np.fmin(low, np.fmin.reduce(lowest_corner.reshape(-1, 3), axis=0))
                high = np.fmax(high, np.fmax.reduce(highest_corner.reshape(-1, 3), axis=0))
    if not (np.isfinite(low).all() and np.isfinite(high).all()):
        return np.zeros((2, 3))
    return np.stack([low, high])


def local_points(
    points: FloatArray, origin: FloatArray, stop_event: threading.Event
) -> Float32Array:
    """Subtract an origin from points in float64, and return float32."""
    out = np.empty((len(points), 3), np.float32)
    for part in pieces(len(points), stop_event):
        out[part] = points[part] - origin
    return out


# -- meshes


def prepare_mesh(
    mesh: Mesh,
    origin: FloatArray,
    stop_event: threading.Event,
    emit: Emit,
) -> None:
    """Emit the proxy, the chunks and the locators of a mesh, but not its textures.

    Raises
    ------
    Stopped
        If `stop_event` is set.
    """
    points = local_points(mesh.vertices, origin, stop_event)
    groups = material_groups(mesh)
    colors = vertex_colors(mesh, groups, stop_event)
    proxy = make_proxy(points, mesh.faces, colors, stop_event)
    if proxy is not None:
        emit(ProxyReady(*proxy))
    chunks = []
    for material, rows in groups:
        for event in mesh_chunks(mesh, points, colors, material, rows, stop_event):
            chunks.append(event.chunk)
            emit(event)
    emit(ChunksDone(len(chunks)))
    del points, colors
    locators = []
    for chunk in chunks:
        if stop_event.is_set():
            raise Stopped
        locators.append(make_locator(chunk))
    emit(LocatorReady(locators))


def material_groups(mesh: Mesh) -> list[tuple[int, slice]]:
    """Return each material with its range of faces; -1 stands for faces without a material."""
    offsets = mesh.material_offsets
    if not mesh.materials:
        return [(-1, slice(0, len(mesh.faces)))]
    groups = [
        (i, slice(int(offsets[i]), int(offsets[i + 1])))
        for i in range(len(mesh.materials))
        if offsets[i + 1] > offsets[i]
    ]
    if offsets[-1] < len(mesh.faces):
        groups.append((-1, slice(int(offsets[-1]), len(mesh.faces))))
    return groups


def vertex_colors(
    mesh: Mesh, groups: list[tuple[int, slice]], stop_event: threading.Event
) -> ByteArray | None:
    """Return vertex colours (n, 3) from the file, or else from textures or materials.

    Return None if the mesh has no colours.
    """
    if mesh.colors is not None:
        return np.array(mesh.colors, np.uint8)
    small_textures = {
        i: overview(m.texture) if m.texture is not None and mesh.uv is not None else None
        for i, m in enumerate(mesh.materials)
    }
    diffuse = [m.diffuse for m in mesh.materials]
    if all(s is None for s in small_textures.values()) and all(d is None for d in diffuse):
        return None
    out = np.empty((len(mesh.vertices), 3), np.uint8)
    out[:] = NEUTRAL_COLOR
    for material, rows in groups:
        if material < 0:
            continue
        tint, picture = diffuse[material], small_textures[material]
        is_coloured = np.zeros(len(out), np.bool_)
        for part in pieces(rows.stop - rows.start, stop_event):
            is_coloured[
                mesh.faces[rows.start + part.start : rows.start + part.stop].reshape(-1)
            ] = True
        used_vertices = np.flatnonzero(is_coloured)
        for part in pieces(len(used_vertices), stop_event):
            vertex_rows = used_vertices[part]
            if picture is not None and mesh.uv is not None:
                uv = mesh.uv[vertex_rows]
                is_finite_uv = np.isfinite(uv).all(axis=1)
                height, width = picture.shape[:2]
                wrapped_uv = uv[is_finite_uv] - np.floor(uv[is_finite_uv])
                column = np.minimum((wrapped_uv[:, 0] * width).astype(np.int32), width - 1)
                line = np.minimum(((1.0 - wrapped_uv[:, 1]) * height).astype(np.int32), height - 1)
                out[vertex_rows[is_finite_uv]] = picture[line, column]
            elif tint is not None:
                out[vertex_rows] = np.round(np.clip(tint, 0.0, 1.0) * np.array(255.0)).astype(
                    np.uint8
                )
    return out


def make_proxy(
    points: Float32Array,
    faces: Int32Array,
    colors: ByteArray | None,
    stop_event: threading.Event,
) -> tuple[vtkPolyData, Int32Array] | None:
    """Simplify a mesh to about PROXY_FACES triangles.

    Return the proxy, with vertex colours if available, and the row of `points` for each of its
    vertices, or None if the mesh is small. All materials are merged first, because decimating
    them separately leaves gaps at their borders.
    """
    if len(faces) <= MAX_FACES_WITHOUT_PROXY:
        return None
    from vtkmodules.vtkFiltersCore import vtkBinnedDecimation

    sample = faces[:: max(1, len(faces) // 200_000)]
    a, b, c = (points[sample[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a).astype(np.float64), axis=1) / 2.0
    area = float(np.nansum(areas)) * len(faces) / len(sample)
    extent = (np.nanmax(points, axis=0) - np.nanmin(points, axis=0)).astype(np.float64)
    cell = max(np.sqrt(2.0 * area / PROXY_FACES), float(extent.max()) / 2000.0, 1e-9)
    if stop_event.is_set():
        raise Stopped
    data = vtk_data.triangles(points, np.array(faces, np.int32), colors=colors)
    out = vtkPolyData()
    for _ in range(3):
        divisions = np.clip(np.ceil(extent / cell), 1, 2000).astype(int)
        decimation = vtkBinnedDecimation()
        decimation.SetInputData(data)
        decimation.SetNumberOfDivisions(*(int(d) for d in divisions))
        decimation.AutoAdjustNumberOfDivisionsOff()
        decimation.SetPointGenerationModeToUseInputPoints()
        decimation.Update()
        out = decimation.GetOutput()
        face_count = out.GetNumberOfCells()
        if stop_event.is_set():
            raise Stopped
        if 0.6 * PROXY_FACES <= face_count <= 1.1 * PROXY_FACES:
            break
        cell *= float(np.sqrt(max(face_count, 100) / (0.9 * PROXY_FACES)))
    return compact(out, colors is not None)


def compact(data: vtkPolyData, is_colored: bool) -> tuple[vtkPolyData, Int32Array]:
    """Remove unused points, and return the new data with the original row of each point.

    Points and triangles are sorted by location. The decimation retains all original points,
    which makes drawing three times slower.
    """
    faces = vtk_data.to_array(data.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    points = vtk_data.to_array(data.GetPoints().GetData())
    corner = points[faces[:, 0]]
    low = corner.min(axis=0)
    faces = faces[
        np.argsort(spatial_blocks.morton(corner, low, float((corner.max(axis=0) - low).max())))
    ]
    used_vertices, first, inverse = np.unique(
        faces.reshape(-1), return_index=True, return_inverse=True
    )
    order = np.argsort(first)
    new_rows = np.empty(len(used_vertices), np.int32)
    new_rows[order] = np.arange(len(used_vertices), dtype=np.int32)
    used_vertices = used_vertices[order]
    colors = (
        vtk_data.to_array(data.GetPointData().GetScalars())[used_vertices] if is_colored else None
    )
    faces = new_rows[inverse.reshape(-1)].reshape(-1, 3)
    return vtk_data.triangles(points[used_vertices], faces, colors=colors), used_vertices.astype(
        np.int32
    )


def mesh_chunks(
    mesh: Mesh,
    points: Float32Array,
    colors: ByteArray | None,
    material: int,
    rows: slice,
    stop_event: threading.Event,
) -> Iterator[MeshChunkReady]:
    """Yield the faces of a material in chunks of neighbouring faces."""
    faces = np.asarray(mesh.faces[rows])
    corner = points[faces[:, 0]]
    low = np.nanmin(corner, axis=0)
    size = float(np.nanmax(np.nanmax(corner, axis=0) - low)) or 1.0
    if len(faces) > FACES_PER_CHUNK // 2:
        order = np.argsort(spatial_blocks.morton(corner, low, size))
    else:
        order = np.arange(len(faces))
    del corner
    is_textured = material >= 0 and mesh.materials[material].texture is not None
    uv = mesh.uv if is_textured else None
    is_used = np.zeros(len(points), np.bool_)
    position = np.empty(len(points), np.int32)
    for part in pieces(len(faces), stop_event, FACES_PER_CHUNK):
        ids = order[part]
        chunk_faces = faces[ids]
        is_used[chunk_faces.reshape(-1)] = True
        vertex_ids = np.flatnonzero(is_used)
        is_used[vertex_ids] = False
        position[vertex_ids] = np.arange(len(vertex_ids), dtype=np.int32)
        local_faces = position[chunk_faces]
        chunk_points = points[vertex_ids]
        corners = chunk_points[local_faces]
        boxes = spatial_blocks.block_boxes(
            corners.min(axis=1), corners.max(axis=1), spatial_blocks.FACES_PER_BLOCK
        )
        coordinates, density = None, 0.0
        if uv is not None:
            coordinates = np.nan_to_num(np.asarray(uv[vertex_ids], np.float32))
            density = uv_per_metre(corners, coordinates[local_faces])
        data = vtk_data.triangles(
            chunk_points,
            local_faces,
            uv=coordinates,
            colors=None if colors is None else colors[vertex_ids],
        )
        chunk = FaceChunk(
            chunk_points,
            local_faces,
            (ids + rows.start).astype(np.int32),
            vertex_ids,
            boxes,
            material,
        )
        yield MeshChunkReady(chunk, data, density)


def uv_per_metre(corners: Float32Array, uv: Float32Array) -> float:
    """Return the texture scale in image widths per metre (square root of the area ratio)."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = float(np.linalg.norm(np.cross(a, b), axis=1).sum())
    s, t = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    uv_area = float(np.abs(s[:, 0] * t[:, 1] - s[:, 1] * t[:, 0]).sum())
    return float(np.sqrt(uv_area / area)) if area > 0.0 else 0.0


def make_locator(chunk: FaceChunk) -> vtkStaticCellLocator:
    """Return the cell locator of a chunk.

    Each chunk has its own locator, because building one holds the interpreter lock (1.2 s for
    five million faces).
    """
    locator = vtkStaticCellLocator()
    locator.SetDataSet(vtk_data.triangles(chunk.points, chunk.faces))
    locator.BuildLocator()
    return locator


def prepare_textures(
    mesh: Mesh,
    limit: int,
    stop_event: threading.Event,
    emit: Emit,
    max_whole_side: int | None = None,
) -> None:
    """Emit every texture of a mesh, decoded and downsampled; see `load_texture`.

    Parameters
    ----------
    mesh : Mesh
    limit : int
        Maximum side length of a texture, pixels.
    stop_event : Event
        If set, Stopped is raised.
    emit : Emit
        Receives the events.
    max_whole_side : int, optional
        Maximum side length of textures that are not divided into quarters, pixels.
    """
    loaded_textures: dict[Path, Texture | None] = {}
    for i, material in enumerate(mesh.materials):
        if stop_event.is_set():
            raise Stopped
        path = material.texture
        if path is None or mesh.uv is None:
            continue
        if path not in loaded_textures:
            try:
                loaded_textures[path] = load_texture(path, limit, max_whole_side)
                loaded_texture = loaded_textures[path]
                if loaded_texture is not None and loaded_texture.note is not None:
                    emit(Problem(loaded_texture.note))
            except TextureProblem as error:
                loaded_textures[path] = None
                emit(Problem(error.finding))
        emit(TextureReady(i, loaded_textures[path]))
    emit(TexturesDone())


# -- clouds


def prepare_cloud(
    cloud: PointCloud,
    origin: FloatArray,
    stop_event: threading.Event,
    emit: Emit,
    submit: Submit,
    budget: int = POINT_BUDGET,
) -> None:
    """Emit the nodes for an overview of a cloud, and a streamer for the remaining nodes.

    Parameters
    ----------
    cloud : PointCloud
    origin : (3,) ndarray
        Origin that is subtracted from the coordinates, in the file frame.
    stop_event : Event
        If set, Stopped is raised.
    emit : Emit
        Receives the events.
    submit : callable
        Schedules a job to run in the background after this one.
    budget : int
        Maximum number of points in memory.
    """

    def check() -> None:
        if stop_event.is_set():
            raise Stopped

    if isinstance(cloud, StreamedCloud):
        nodes: CloudNodes = cloud.store
    else:
        nodes = ArrangedNodes(cloud, cloud.arrangement or arrange(cloud.points, check), budget)
    Streamer(cloud, nodes, origin, stop_event, emit, submit).begin()


# -- fields


def prepare_field(
    data: Mesh | PointCloud,
    style: FieldStyle,
    to_world: FloatArray,
    proxies: Sequence[IntegerArray],
    parts: Sequence[IntegerArray],
    stop_event: threading.Event,
    emit: Emit,
) -> None:
    """Emit the colours of a field for the proxies and chunks of a model.

    `proxies` and `parts` contain the rows that each of them shows. The nodes of clouds change
    with the view, and are coloured when they are shown.
    """

    def check() -> None:
        if stop_event.is_set():
            raise Stopped

    scale = make_scale(data, style, to_world, check)
    if isinstance(data, PointCloud):
        emit(FieldReady(style, scale, [], []))
        return
    _, read = reader(data, style.name, to_world)

    def color_rows(rows: IntegerArray) -> vtkUnsignedCharArray:
        check()
        return vtk_data.color_array(scale.colors(read(rows)))

    emit(FieldReady(style, scale, [color_rows(r) for r in proxies], [color_rows(r) for r in parts]))
