"""Intersection of a World ray with models, computed exactly in float64.

The face or point is determined on float32 copies in the local frame of the model. Its position
is always computed from the float64 coordinates of the model.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, Protocol

import numpy as np
from vtkmodules.vtkCommonCore import mutable
from vtkmodules.vtkCommonDataModel import vtkStaticCellLocator

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.geometry.boxes import box_range, is_box_hit
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.rendering.view.camera import Camera
from vomstudio.rendering.view.clipping import ClipBox, PickLimits, find_pick_limits
from vomstudio.rendering.view.spatial_blocks import (
    FaceChunk,
    PointChunk,
    first_face,
    points_near_ray,
)
from vomstudio.studio.tools.interaction_types import Hit

Triple = tuple[float, float, float]

MAX_PICK_DISTANCE_PIXELS = 6.0
"""Maximum distance of a picked cloud point from the cursor, pixels."""

SURFACE_THICKNESS = 4.0
"""Depth behind the front-most point, in multiples of the maximum pick distance, within which points
belong to the same surface."""


class Pickable(Protocol):
    """Protocol of a model that can be picked."""

    model_id: str
    data: Mesh | PointCloud
    origin: FloatArray
    low: FloatArray
    high: FloatArray
    to_world: FloatArray
    from_world: FloatArray
    locators: list[vtkStaticCellLocator]
    face_chunks: list[FaceChunk]
    point_chunks: list[PointChunk]
    hidden: BoolArray | None

    def chunk_boxes(self) -> tuple[FloatArray, FloatArray]: ...

    def corners_world(self) -> FloatArray: ...


def pick_front(
    models: Iterable[Pickable],
    camera: Camera,
    x: float,
    y: float,
    size: tuple[float, float],
    clip: ClipBox | None = None,
) -> Hit | None:
    """Return the front-most point of the models at a pixel, or None."""
    origin, direction = camera.ray(x, y, size)
    tangent = 2.0 * camera.tangent / max(size[1], 1.0)
    if camera.orthographic:
        radius, spread = tangent * camera.distance, 0.0
    else:
        radius, spread = 0.0, tangent
    best_hit, best_depth = None, np.inf
    for model in models:
        hit = pick_model(model, origin, direction, radius, spread, clip)
        if hit is None:
            continue
        world = model.to_world[:3, :3] @ np.array(hit.position) + model.to_world[:3, 3]
        depth = float((world - origin) @ direction)
        if depth < best_depth:
            best_hit, best_depth = hit, depth
    return best_hit


def pick_model(
    model: Pickable,
    origin: FloatArray,
    direction: FloatArray,
    radius: float,
    spread: float,
    box: ClipBox | None = None,
) -> Hit | None:
    """Return the front-most point of a model on a ray inside the clipping box, or None.

    Parameters
    ----------
    model : Pickable
    origin, direction : (3,) ndarray
        Origin and direction of the ray in the World frame.
    radius, spread : float
        Size of a pixel in metres at depth 0, and its growth per metre of depth; used only for
        clouds.
    box : ClipBox, optional
    """
    linear_part = model.from_world[:3, :3]
    start = linear_part @ origin + model.from_world[:3, 3] - model.origin
    heading = linear_part @ direction
    scale = math.hypot(*heading.tolist())
    heading = heading / scale
    pad = (radius + spread * math.hypot(*start.tolist())) * scale * MAX_PICK_DISTANCE_PIXELS
    if not is_box_hit(model.low, model.high, start, heading, pad):
        return None
    limits = None
    if box is not None:
        max_distance = 0.0
        if not isinstance(model.data, Mesh):
            # A point inside the box may be near a ray that passes just outside it.
            distance = float(np.linalg.norm(model.corners_world() - origin, axis=1).max())
            max_distance = (radius + spread * distance) * MAX_PICK_DISTANCE_PIXELS
        limits = find_pick_limits(
            box, origin, direction, model.to_world, model.origin, max_distance
        )
        if limits is None:
            return None
    if isinstance(model.data, Mesh):
        return _pick_mesh(model, model.data, start, heading, limits)
    return _pick_cloud(model, model.data, start, heading, radius * scale, spread, limits)


def _pick_mesh(
    model: Pickable, mesh: Mesh, start: FloatArray, heading: FloatArray, limits: PickLimits | None
) -> Hit | None:
    distance_range = (0.0, np.inf) if limits is None else (limits.first, limits.last)
    face = (
        _locate(model, start, heading, distance_range)
        if model.locators and model.hidden is None
        else first_face(model.face_chunks, start, heading, distance_range, model.hidden)
    )
    if face is None:
        return None
    corners = np.asarray(mesh.vertices[mesh.faces[face]], np.float64)
    a = corners[0]
    # Uses plain numbers, because NumPy takes twenty times as long for single vectors.
    ray: Triple = tuple(heading.tolist())
    e1, e2, s = ((row - a).tolist() for row in (corners[1], corners[2], start + model.origin))
    p = _cross(ray, e2)
    det = _dot(e1, p)
    if det == 0.0 or not math.isfinite(det):
        return None
    u, v = _dot(s, p) / det, _dot(ray, _cross(s, e1)) / det
    # In float32, the face across a shared edge may have been selected; stay on the selected
    # face.
    u, v = min(max(u, 0.0), 1.0), min(max(v, 0.0), 1.0)
    if u + v > 1.0:
        u, v = u / (u + v), v / (u + v)
    weights = (1.0 - u - v, u, v)
    position = np.asarray(weights) @ corners
    return Hit(
        model.model_id,
        "face",
        int(face),
        (float(position[0]), float(position[1]), float(position[2])),
        weights,
    )


def _cross(a: Triple, b: Triple) -> Triple:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _dot(a: Triple, b: Triple) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _locate(
    model: Pickable, start: FloatArray, heading: FloatArray, depth_range: tuple[float, float]
) -> int | None:
    """Return the row of the front-most face between two depths, or None.

    Only locators of chunks whose boxes are hit by the ray are used.
    """
    low, high = model.chunk_boxes()
    enter_distances, leave_distances = box_range(low, high, start, heading)
    slack = 1e-3 * (leave_distances - enter_distances) + 1e-6
    # The section of the ray inside the chunk is slightly extended, within the permitted depths.
    min_distances = np.maximum(enter_distances - slack, depth_range[0])
    max_distances = np.minimum(leave_distances + slack, depth_range[1])
    met_blocks = (
        (leave_distances >= enter_distances) & (max_distances >= min_distances)
    ).nonzero()[0]
    best_distance, face = np.inf, None
    t: Any = mutable(0.0)
    sub: Any = mutable(0)
    cell: Any = mutable(-1)
    x, pcoords = [0.0] * 3, [0.0] * 3
    for i in met_blocks[np.argsort(enter_distances[met_blocks])]:
        if enter_distances[i] > best_distance:
            break
        first_depth, last_depth = float(min_distances[i]), float(max_distances[i])
        hit = model.locators[i].IntersectWithLine(
            (start + heading * first_depth).tolist(),
            (start + heading * last_depth).tolist(),
            0.0,
            t,
            x,
            pcoords,
            sub,
            cell,
        )
        if hit and int(cell) >= 0:
            depth = first_depth + float(t) * (last_depth - first_depth)
            if depth < best_distance:
                best_distance, face = depth, int(model.face_chunks[i].face_ids[int(cell)])
    return face


def _pick_cloud(
    model: Pickable,
    cloud: PointCloud,
    start: FloatArray,
    heading: FloatArray,
    radius: float,
    spread: float,
    limits: PickLimits | None,
) -> Hit | None:
    if not model.point_chunks:
        return None
    rows, depth, distance_to_ray = points_near_ray(
        model.point_chunks,
        model.chunk_boxes(),
        start,
        heading,
        radius * MAX_PICK_DISTANCE_PIXELS,
        spread * MAX_PICK_DISTANCE_PIXELS,
        SURFACE_THICKNESS,
        None if limits is None else limits.inside,
        model.hidden,
    )
    if not len(rows):
        return None
    # The front-most point near the cursor determines the surface, and the point of this surface
    # nearest to the cursor is picked.
    nearest_depth = float(depth.min())
    thick = SURFACE_THICKNESS * (radius + spread * nearest_depth) * MAX_PICK_DISTANCE_PIXELS
    surface_rows = np.flatnonzero(depth <= nearest_depth + thick)
    row = int(rows[surface_rows[np.argmin(distance_to_ray[surface_rows])]])
    x, y, z = (float(v) for v in cloud.position(row))
    return Hit(model.model_id, "point", row, (x, y, z))
