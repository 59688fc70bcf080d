"""What is seen of the outcrop at one moment, as numbers: the eye, and how far it sees in each
pixel. So it can be asked which faces or points lie inside a shape drawn over the picture."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, ByteArray, Float32Array, FloatArray, IntArray
from vomstudio.core.progress import Silent
from vomstudio.geometry.boxes import ClipBox
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.kernels.jit import for_kernels, for_reading
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.nearby.point_grid import run_in_blocks
from vomstudio.geometry.streaming.octree import StreamedCloud

_AT_ONCE = 1_000_000
_STEEPEST = 10.0
"""So many times as far as it is wide the surface may run back within one pixel: seen at 84 degrees
from its normal. A longer way is a gap, behind which is another surface."""
_SLACK = 1.5
"""Pixels by which a surface that was drawn in 32 bits may stand before itself."""


@dataclass(frozen=True, eq=False)
class Looking:
    """position : (3,) World; right, up, direction : orthonormal, direction away from the viewer
    half_height : of the picture in metres where the view is parallel, else the tangent of half its
        angle
    size : (width, height) of the picture in its own pixels; ratio : of these for one of the window
    depth : (height, width) float32 metres along the direction to what is seen, first row on top,
        infinite where there is nothing; None where it is not known
    clip : what lies outside of it is cut away; None for nothing
    """

    position: FloatArray
    right: FloatArray
    up: FloatArray
    direction: FloatArray
    half_height: float
    parallel: bool
    size: tuple[int, int]
    ratio: float = 1.0
    depth: Float32Array | None = None
    clip: ClipBox | None = None

    @property
    def scale(self) -> float:
        """Pixels of a metre across the view, at depth 1 where that matters."""
        return self.size[1] / (2.0 * self.half_height)

    def before_eye(self, to_world: FloatArray) -> FloatArray:
        """(3, 4) from a file's frame to metres right, up and away from the eye."""
        frame = np.stack([self.right, self.up, self.direction])
        linear = frame @ to_world[:3, :3]
        return np.column_stack([linear, frame @ (to_world[:3, 3] - self.position)])

    def filled(self, outline: Sequence[tuple[float, float]]) -> ByteArray:
        """(height, width) 1 inside of a ring of places in the window's pixels, 0 outside."""
        from PIL import Image, ImageDraw

        picture = Image.new("L", self.size)
        if len(outline) > 2:
            ring = [(x * self.ratio, y * self.ratio) for x, y in outline]
            ImageDraw.Draw(picture).polygon(ring, fill=1)
        return np.array(picture, np.uint8)

    def farthest(self) -> Float32Array:
        """(height, width) depth beyond which what lies in a pixel is hidden; of no rows where it is
        not known what is seen."""
        if self.depth is None:
            return np.zeros((0, 0), np.float32)
        depth = self.depth
        around = depth.copy()
        for here, there in ((slice(1, None), slice(-1)), (slice(-1), slice(1, None))):
            np.maximum(around[here], depth[there], out=around[here])
        wide = around.copy()
        for here, there in ((slice(1, None), slice(-1)), (slice(-1), slice(1, None))):
            np.maximum(wide[:, here], around[:, there], out=wide[:, here])
        pixel = np.float32(1.0 / self.scale) * (np.float32(1.0) if self.parallel else depth)
        with np.errstate(invalid="ignore"):
            back = np.minimum(wide - depth, np.float32(_STEEPEST) * pixel)
            limit = depth + np.where(np.isfinite(depth), back, 0.0) + np.float32(_SLACK) * pixel
        return np.ascontiguousarray(limit + np.float32(1e-5) * np.abs(depth), np.float32)

    def inside(
        self,
        data: Mesh | PointCloud,
        to_world: FloatArray,
        shape: ByteArray,
        *,
        through: bool,
        spacing: float = 0.0,
    ) -> BoolArray:
        """(n,) which faces of a mesh, by their centres of gravity, or points of a cloud lie inside
        a shape; unless `through` only those that are seen. Of a cloud that is read as it is looked
        at those that are there.

        to_world : (4, 4) similarity from the file's frame; shape : (height, width), not 0 inside
        spacing : metres between points of a cloud, which are drawn as large as that
        """
        matrix = for_kernels(self.before_eye(to_world), np.float64)
        farthest = np.zeros((0, 0), np.float32) if through else self.farthest()
        told = (self.scale, self.parallel, for_kernels(shape, np.uint8), farthest, 2.0 * spacing)
        out = np.zeros(count_of(data), np.bool_)
        if isinstance(data, Mesh):
            self._faces(data, matrix, told, out)
        else:
            self._points(data, matrix, told, out)
        return out if self.clip is None else self._uncut(data, to_world, self.clip, out)

    def _faces(self, mesh: Mesh, matrix: FloatArray, told: tuple, out: BoolArray) -> None:  # type: ignore[type-arg]
        from vomstudio.extraction.selection.picture_kernels import faces_inside

        vertices, faces = for_reading(mesh.vertices, np.float64), for_reading(mesh.faces, np.int32)

        def work(rows: slice) -> None:
            faces_inside(vertices, faces[rows], matrix, *told, out[rows])

        run_in_blocks(work, len(faces), Silent(), _AT_ONCE)

    def _points(self, cloud: PointCloud, matrix: FloatArray, told: tuple, out: BoolArray) -> None:  # type: ignore[type-arg]
        from vomstudio.extraction.selection.picture_kernels import points_inside

        for start, part in pieces_of(cloud):
            points = for_reading(part, np.float64)
            own = out[start : start + len(points)]

            def work(rows: slice, points: FloatArray = points, own: BoolArray = own) -> None:
                points_inside(points[rows], matrix, *told, own[rows])

            run_in_blocks(work, len(points), Silent(), _AT_ONCE)

    def _uncut(
        self, data: Mesh | PointCloud, to_world: FloatArray, box: ClipBox, chosen: BoolArray
    ) -> BoolArray:
        ids = np.flatnonzero(chosen)
        places = places_of(data, ids) @ to_world[:3, :3].T + to_world[:3, 3]
        chosen[ids[~box.holds(places)]] = False
        return chosen


def count_of(data: Mesh | PointCloud) -> int:
    """How many faces a mesh, or points a cloud has."""
    return len(data.faces) if isinstance(data, Mesh) else data.count


def places_of(data: Mesh | PointCloud, ids: IntArray) -> FloatArray:
    """(k, 3) centres of gravity of faces, or points, in the file's frame."""
    if isinstance(data, Mesh):
        return np.asarray(data.vertices[data.faces[ids]].mean(axis=1), np.float64)
    if isinstance(data, StreamedCloud):
        return data.store.points_of(ids)
    return np.asarray(data.points[ids], np.float64)


def pieces_of(cloud: PointCloud) -> Iterator[tuple[int, FloatArray]]:
    """The first id and the points (k, 3) of each run of points that are there."""
    if not isinstance(cloud, StreamedCloud):
        yield 0, cloud.points
        return
    for row, piece in cloud.store.loaded().items():
        yield int(cloud.store.starts[row]), piece.points
