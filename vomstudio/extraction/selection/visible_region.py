"""Visible part of the outcrop: position of the eye, and depth of each pixel.

It is used to test which faces or points are inside a shape drawn over the picture.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, ByteArray, Float32Array, FloatArray, IntArray
from vomstudio.core.progress import SilentProgress
from vomstudio.geometry.boxes import ClipBox
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.kernels.jit import to_kernel_array, to_read_only_array
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.nearby.point_grid import run_in_blocks
from vomstudio.geometry.streaming.octree import StreamedCloud

_BLOCK = 1_000_000
_MAX_DEPTH_SLOPE = 10.0
"""Maximum slope of a surface within one pixel, which corresponds to a view at 84 degrees from its
normal. A steeper step is a gap with another surface behind it."""
_DEPTH_TOLERANCE_PX = 1.5
"""Depth tolerance, in pixels, for a surface rendered with 32-bit depths."""


@dataclass(frozen=True, eq=False)
class ViewSnapshot:
    """Snapshot of a view of the outcrop.

    Parameters
    ----------
    position : (3,) array
        Position of the eye in the World frame, m.
    right, up, direction : (3,) arrays
        Orthonormal vectors; the direction points away from the viewer.
    half_height : float
        Half the height of the picture in metres for a parallel view, otherwise the tangent of half
        its view angle.
    is_parallel : bool
    size : (int, int)
        Width and height of the picture in pixels.
    ratio : float
        Number of picture pixels per window pixel.
    depth : (height, width) float32 array, optional
        Depth along the direction in metres, starting with the top row; infinite for pixels without
        a surface.
    clip : ClipBox, optional
        Box outside which everything is clipped.
    """

    position: FloatArray
    right: FloatArray
    up: FloatArray
    direction: FloatArray
    half_height: float
    is_parallel: bool
    size: tuple[int, int]
    ratio: float = 1.0
    depth: Float32Array | None = None
    clip: ClipBox | None = None

    @property
    def scale(self) -> float:
        """Pixels per metre across the view; at depth 1 in a perspective view."""
        return self.size[1] / (2.0 * self.half_height)

    def to_eye(self, to_world: FloatArray) -> FloatArray:
        """Return the transform (3, 4) from the file frame to right, up and depth in metres."""
        frame = np.stack([self.right, self.up, self.direction])
        rotation_to_eye = frame @ to_world[:3, :3]
        return np.column_stack([rotation_to_eye, frame @ (to_world[:3, 3] - self.position)])

    def pixels(self, points: FloatArray) -> FloatArray:
        """Project points (n, 3) of the World frame to picture pixels (n, 2).

        The pixels are NaN for points outside the clipping box and, in a perspective view, for
        points behind the eye.
        """
        frame = self.to_eye(np.eye(4))
        eye = points @ frame[:, :3].T + frame[:, 3]
        depth = (
            np.ones(len(eye)) if self.is_parallel else np.where(eye[:, 2] > 0.0, eye[:, 2], np.nan)
        )
        if self.clip is not None:
            depth = np.where(self.clip.contains(points), depth, np.nan)
        screen_offsets = self.scale * eye[:, :2] / depth[:, None]
        return np.asarray(0.5 * np.array(self.size) + screen_offsets * [1.0, -1.0])

    def outline_mask(self, outline: Sequence[tuple[float, float]]) -> ByteArray:
        """Rasterize a ring of window pixels to (height, width), 1 inside and 0 outside."""
        from PIL import Image, ImageDraw

        picture = Image.new("L", self.size)
        if len(outline) > 2:
            ring = [(x * self.ratio, y * self.ratio) for x, y in outline]
            ImageDraw.Draw(picture).polygon(ring, fill=1)
        return np.array(picture, np.uint8)

    def compute_max_depths(self) -> Float32Array:
        """Return the depths (height, width) beyond which points are hidden; empty if unknown."""
        if self.depth is None:
            return np.zeros((0, 0), np.float32)
        depth = self.depth
        local_maximum = depth.copy()
        for pixel_slice, neighbour in ((slice(1, None), slice(-1)), (slice(-1), slice(1, None))):
            np.maximum(local_maximum[pixel_slice], depth[neighbour], out=local_maximum[pixel_slice])
        max_depths = local_maximum.copy()
        for pixel_slice, neighbour in ((slice(1, None), slice(-1)), (slice(-1), slice(1, None))):
            np.maximum(
                max_depths[:, pixel_slice],
                local_maximum[:, neighbour],
                out=max_depths[:, pixel_slice],
            )
        pixel = np.float32(1.0 / self.scale) * (np.float32(1.0) if self.is_parallel else depth)
        with np.errstate(invalid="ignore"):
            depth_range = np.minimum(max_depths - depth, np.float32(_MAX_DEPTH_SLOPE) * pixel)
            limit = (
                depth
                + np.where(np.isfinite(depth), depth_range, 0.0)
                + np.float32(_DEPTH_TOLERANCE_PX) * pixel
            )
        return np.ascontiguousarray(limit + np.float32(1e-5) * np.abs(depth), np.float32)

    def inside(
        self,
        data: Mesh | PointCloud,
        to_world: FloatArray,
        shape: ByteArray,
        *,
        is_through: bool,
        spacing: float = 0.0,
    ) -> BoolArray:
        """Select the faces (by centroid) or points inside a shape.

        Parameters
        ----------
        data : Mesh or PointCloud
            For a streamed cloud, only the loaded points are tested.
        to_world : (4, 4) array
            Similarity from the file frame to the World frame.
        shape : (height, width) uint8 array
            Non-zero inside the shape.
        is_through : bool
            Whether to include hidden elements.
        spacing : float
            Distance between the points of a cloud, m; points are drawn at this size.

        Returns
        -------
        (n,) bool array
        """
        matrix = to_kernel_array(self.to_eye(to_world), np.float64)
        farthest_depths = np.zeros((0, 0), np.float32) if is_through else self.compute_max_depths()
        view = (
            self.scale,
            self.is_parallel,
            to_kernel_array(shape, np.uint8),
            farthest_depths,
            2.0 * spacing,
        )
        out = np.zeros(element_count(data), np.bool_)
        if isinstance(data, Mesh):
            self._select_faces(data, matrix, view, out)
        else:
            self._select_points(data, matrix, view, out)
        return out if self.clip is None else self._remove_clipped(data, to_world, self.clip, out)

    def _select_faces(
        self, mesh: Mesh, matrix: FloatArray, view: tuple[Any, ...], is_inside: BoolArray
    ) -> None:
        from vomstudio.extraction.selection.picture_kernels import select_faces_in_shape

        vertices, faces = (
            to_read_only_array(mesh.vertices, np.float64),
            to_read_only_array(mesh.faces, np.int32),
        )

        def test_rows(rows: slice) -> None:
            select_faces_in_shape(vertices, faces[rows], matrix, *view, is_inside[rows])

        run_in_blocks(test_rows, len(faces), SilentProgress(), _BLOCK)

    def _select_points(
        self, cloud: PointCloud, matrix: FloatArray, view: tuple[Any, ...], is_inside: BoolArray
    ) -> None:
        from vomstudio.extraction.selection.picture_kernels import select_points_in_shape

        for start, part in loaded_pieces(cloud):
            points = to_read_only_array(part, np.float64)
            mask = is_inside[start : start + len(points)]

            def test_rows(rows: slice, points: FloatArray = points, mask: BoolArray = mask) -> None:
                select_points_in_shape(points[rows], matrix, *view, mask[rows])

            run_in_blocks(test_rows, len(points), SilentProgress(), _BLOCK)

    def _remove_clipped(
        self, data: Mesh | PointCloud, to_world: FloatArray, box: ClipBox, selection: BoolArray
    ) -> BoolArray:
        ids = np.flatnonzero(selection)
        positions = element_positions(data, ids) @ to_world[:3, :3].T + to_world[:3, 3]
        selection[ids[~box.contains(positions)]] = False
        return selection


def element_count(data: Mesh | PointCloud) -> int:
    """Return the number of faces of a mesh, or points of a cloud.

    Parameters
    ----------
    data : Mesh or PointCloud

    Returns
    -------
    int
    """
    return len(data.faces) if isinstance(data, Mesh) else data.count


def element_positions(data: Mesh | PointCloud, ids: IntArray) -> FloatArray:
    """Return the centroids of faces, or the positions of points.

    Parameters
    ----------
    data : Mesh or PointCloud
    ids : (k,) ndarray of int

    Returns
    -------
    (k, 3) ndarray
        Positions in the frame of the file.
    """
    if isinstance(data, Mesh):
        return np.asarray(data.vertices[data.faces[ids]].mean(axis=1), np.float64)
    if isinstance(data, StreamedCloud):
        return data.store.points_of(ids)
    return np.asarray(data.points[ids], np.float64)


def loaded_pieces(cloud: PointCloud) -> Iterator[tuple[int, FloatArray]]:
    """Yield the loaded runs of points of a cloud.

    Parameters
    ----------
    cloud : PointCloud

    Yields
    ------
    tuple
        Id of the first point of a run, and its points (k, 3).
    """
    if not isinstance(cloud, StreamedCloud):
        yield 0, cloud.points
        return
    for row, piece in cloud.store.loaded_nodes().items():
        yield int(cloud.store.starts[row]), piece.points
