"""Spatial ordering and a two-level bounding-box index of triangles or points.

A ray query takes about a millisecond. The index is available as soon as the chunks exist, long
before a cell locator, and clouds are always picked with it. Coordinates are float32 in the local
frame of the model (file coordinates minus an integer origin). Results are indices; the caller
computes positions from the float64 coordinates of the model.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import (
    BoolArray,
    Float32Array,
    FloatArray,
    Int32Array,
    IntArray,
    IntegerArray,
    UInt32Array,
)
from vomstudio.geometry.boxes import are_boxes_hit, box_range

FACES_PER_BLOCK = 64
POINTS_PER_BLOCK = 128


def spread_bits(v: UInt32Array) -> UInt32Array:
    """Spread the lowest ten bits of `v`, with two zero bits between neighbouring bits."""
    v = (v | (v << np.uint32(16))) & np.uint32(0x030000FF)
    v = (v | (v << np.uint32(8))) & np.uint32(0x0300F00F)
    v = (v | (v << np.uint32(4))) & np.uint32(0x030C30C3)
    return (v | (v << np.uint32(2))) & np.uint32(0x09249249)


def morton(points: Float32Array, low: Float32Array, size: float) -> UInt32Array:
    """Return the positions of points (n, 3) along a Z-order curve with 1024 cells per side."""
    scale = np.float32(1023.0 / max(size, 1e-30))
    code = np.zeros(len(points), np.uint32)
    for axis in range(3):
        cell = (points[:, axis] - low[axis]) * scale
        np.clip(cell, 0.0, 1023.0, out=cell)
        code |= spread_bits(cell.astype(np.uint32)) << np.uint32(axis)
    return code


def ray_triangles(
    origin: FloatArray, direction: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
    """Intersect a ray with n triangles.

    Return t, u, v and whether the triangle is hit in front of the origin, (n,) each. The
    intersection is a + u (b - a) + v (c - a). See Tomas Moeller and Ben Trumbore, Fast, minimum
    storage ray/triangle intersection, J. Graphics Tools 2 (1997).
    """
    e1, e2 = b - a, c - a
    p = np.cross(direction[None, :], e2)
    det = np.einsum("ij,ij->i", e1, p)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        inverse = 1.0 / det
        s = origin - a
        u = np.einsum("ij,ij->i", s, p) * inverse
        q = np.cross(s, e1)
        v = (q @ direction) * inverse
        t = np.einsum("ij,ij->i", e2, q) * inverse
        # A ray through a shared edge must not pass between two triangles because of rounding.
        slack = 1e-9
        is_hit = (u >= -slack) & (v >= -slack) & (u + v <= 1.0 + slack) & (t > 0.0)
    return t, u, v, is_hit & (det != 0.0)


@dataclass(frozen=True, eq=False)
class Blocks:
    """Bounding boxes of runs of `per_block` elements of a chunk, in the order of the chunk.

    `low` and `high` are the corners (b, 3) float64 of the boxes.
    """

    low: FloatArray
    high: FloatArray
    per_block: int
    count: int

    def elements(self, is_hit: BoolArray) -> IntArray:
        """Return the indices in the chunk of the elements in the blocks marked by `is_hit`."""
        first_elements = np.flatnonzero(is_hit) * self.per_block
        rows = (first_elements[:, None] + np.arange(self.per_block)).ravel()
        return rows[rows < self.count]


def block_boxes(low: Float32Array, high: Float32Array, per_block: int) -> Blocks:
    """Group elements with the box corners `low` and `high` (n, 3) into blocks."""
    starts = np.arange(0, len(low), per_block)
    return Blocks(
        np.minimum.reduceat(low, starts, axis=0).astype(np.float64),
        np.maximum.reduceat(high, starts, axis=0).astype(np.float64),
        per_block,
        len(low),
    )


@dataclass(frozen=True, eq=False)
class FaceChunk:
    """Run of neighbouring triangles.

    Parameters
    ----------
    points : (k, 3) float32
        Vertices in the local frame.
    faces : (m, 3) int32
        Triangles as rows of `points`.
    face_ids : (m,) int
        Rows of the triangles in the model.
    vertex_ids : (k,) int
        Rows of the vertices in the model.
    """

    points: Float32Array
    faces: Int32Array
    face_ids: IntegerArray
    vertex_ids: IntegerArray
    blocks: Blocks
    material: int


@dataclass(frozen=True, eq=False)
class PointChunk:
    """Run of neighbouring points; `point_ids` (k,) are their rows in the cloud."""

    points: Float32Array
    point_ids: IntegerArray
    blocks: Blocks

    def spacing(self) -> float:
        """Return the approximate point spacing, treating each block as a square surface patch."""
        diagonals = np.linalg.norm(self.blocks.high - self.blocks.low, axis=1)
        per_block = min(self.blocks.per_block, self.blocks.count)
        return float(np.median(diagonals) / np.sqrt(2.0 * per_block))


def first_face(
    chunks: list[FaceChunk],
    origin: FloatArray,
    direction: FloatArray,
    between: tuple[float, float] = (0.0, np.inf),
    is_hidden: BoolArray | None = None,
) -> int | None:
    """Return the row of the front-most face that a ray hits between two depths, or None.

    The ray is in the local frame. `is_hidden` marks faces of the model that are ignored.
    """
    if not chunks:
        return None
    low = np.stack([c.blocks.low.min(axis=0) for c in chunks])
    high = np.stack([c.blocks.high.max(axis=0) for c in chunks])
    best_distance, face = np.inf, None
    for i in np.flatnonzero(are_boxes_hit(low, high, origin, direction)):
        chunk = chunks[i]
        rows = chunk.blocks.elements(
            are_boxes_hit(chunk.blocks.low, chunk.blocks.high, origin, direction)
        )
        if is_hidden is not None:
            rows = rows[~is_hidden[chunk.face_ids[rows]]]
        if not len(rows):
            continue
        corners = chunk.points[chunk.faces[rows]].astype(np.float64)
        t, _, _, is_hit = ray_triangles(origin, direction, *(corners[:, k] for k in range(3)))
        t = np.where(is_hit & (t >= between[0]) & (t <= between[1]), t, np.inf)
        k = int(np.argmin(t))
        if t[k] < best_distance:
            best_distance, face = float(t[k]), int(chunk.face_ids[rows[k]])
    return face


def points_near_ray(
    chunks: list[PointChunk],
    boxes: tuple[FloatArray, FloatArray],
    origin: FloatArray,
    direction: FloatArray,
    radius: float,
    spread: float,
    thickness: float = np.inf,
    counts: Callable[[FloatArray], BoolArray] | None = None,
    is_hidden: BoolArray | None = None,
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the points of a cloud near a ray in the local frame.

    Parameters
    ----------
    chunks : list of PointChunk
    boxes : (n, 3) and (n, 3) float64
        Minimum and maximum corners of the chunks.
    origin, direction : (3,) ndarray
        Origin and unit direction of the ray.
    radius, spread : float
        Maximum distance from the ray at depth 0, and its increase per unit of depth.
    thickness : float
        Chunks are skipped if they begin farther behind the front-most point than this multiple
        of the maximum distance.
    counts : callable, optional
        Function that returns which points (n, 3) of the local frame are considered; by default all.
    is_hidden : (n,) bool, optional
        Marks the points of the cloud that are ignored.

    Returns
    -------
    rows : (k,) int
        Rows of the points in the cloud.
    depth : (k,) float64
        Depth along the ray.
    offset : (k,) float64
        Distance from the ray divided by the maximum distance, 0 to 1.
    """
    rows_out, depth_out, offset_out = [], [], []
    low, high = boxes
    far_depth = np.linalg.norm((low + high) / 2.0 - origin, axis=1) + np.linalg.norm(
        high - low, axis=1
    )
    pad = (radius + spread * far_depth)[:, None]
    enter_distances, leave_distances = box_range(low - pad, high + pad, origin, direction)
    met_boxes = np.flatnonzero(leave_distances >= np.maximum(enter_distances, 0.0))
    nearest_depth = np.inf
    for i in met_boxes[np.argsort(enter_distances[met_boxes])]:
        if enter_distances[i] > nearest_depth + thickness * (radius + spread * nearest_depth):
            break
        chunk = chunks[i]
        is_hit = are_boxes_hit(
            chunk.blocks.low - pad[i], chunk.blocks.high + pad[i], origin, direction
        )
        rows = chunk.blocks.elements(is_hit)
        if is_hidden is not None:
            rows = rows[~is_hidden[chunk.point_ids[rows]]]
        if not len(rows):
            continue
        q = chunk.points[rows] - origin
        depth = q @ direction
        offsets = q - depth[:, None] * direction
        offset = np.sqrt(np.einsum("ij,ij->i", offsets, offsets))
        allowed_distances = radius + spread * np.maximum(depth, 0.0)
        near_rows = np.flatnonzero((depth > 0.0) & (offset <= allowed_distances))
        if counts is not None and len(near_rows):
            near_rows = near_rows[counts(chunk.points[rows[near_rows]].astype(np.float64))]
        if len(near_rows):
            rows_out.append(chunk.point_ids[rows[near_rows]].astype(np.int64))
            depth_out.append(depth[near_rows])
            offset_out.append(offset[near_rows] / allowed_distances[near_rows])
            nearest_depth = min(nearest_depth, float(depth_out[-1].min()))
    if not rows_out:
        return np.zeros(0, np.int64), np.zeros(0), np.zeros(0)
    return np.concatenate(rows_out), np.concatenate(depth_out), np.concatenate(offset_out)
