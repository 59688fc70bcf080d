"""Fusion of all depth maps into one point cloud.

A pixel becomes a point if enough other maps agree with its position and normal, and if these are at
least as many as the maps that see through it. Among agreeing pixels, the one with the finest
footprint is used and moved along its normal to their weighted mean. The cloud is therefore regular,
without layers, and everywhere as dense as the sharpest photo. The points of a photo depend only on
the maps of its neighbours, so memory is bounded and the order does not matter.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.kernels.jit import to_kernel_array
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.dense.depthmaps import DepthMap
from vomstudio.photogrammetry.dense.pairs import DepthMapPlans
from vomstudio.photogrammetry.dense.undistortion import UndistortedPhoto

# Ratio up to which footprints count as equally fine; the first photo then keeps the point.
_MAX_FOOTPRINT_RATIO = 1.3


@dataclass(frozen=True)
class FusionOptions:
    """Options of the fusion.

    Attributes
    ----------
    min_views : int
        Minimum number of views that agree on a point.
    max_reprojection_px, max_depth_share, max_normal_deg : float
        Maximum differences between agreeing maps.
    min_confidence : float
        Minimum confidence of a point, from 0 to 1.
    cache_bytes : int
        Maximum size of the depth maps held in memory.
    """

    min_views: int = 2
    max_reprojection_px: float = 1.0
    max_depth_share: float = 0.01
    max_normal_deg: float = 30.0
    min_confidence: float = 0.0
    cache_bytes: int = 1_000_000_000


def neighbours_by_name(scene: SparseScene, pairs: DepthMapPlans) -> dict[str, tuple[str, ...]]:
    """Return, for each photo with a plan, the photos whose maps show the same rock."""
    names = [view.name for view in scene.views]
    return {names[p.view]: tuple(names[row] for row in p.neighbours) for p in pairs.plans}


def fuse_depth_maps(
    names: Sequence[str],
    depth_maps: Sequence[DepthMap],
    photos: Sequence[UndistortedPhoto] | None,
    neighbours: Mapping[str, Sequence[str]] | None = None,
    options: FusionOptions | None = None,
    progress: Progress | None = None,
) -> PointCloud:
    """Compute the points on which depth maps agree, in the scene's frame.

    Parameters
    ----------
    names : sequence of str
        Names of the photos. `depth_maps` and `photos` have the same order and may be lazy
        sequences.
    depth_maps : sequence of DepthMap
    photos : sequence of UndistortedPhoto or None
        Photos from which the points are coloured.
    neighbours : mapping, optional
        See `neighbours_by_name`. By default, each photo is compared with all others.
    options : FusionOptions, optional
    progress : Progress, optional

    Returns
    -------
    PointCloud
        Cloud with colours, unit normals, and the fields "confidence" (0 to 1, float32) and "views"
        (uint8). A normal points to the side of its own photo, regardless of the other photos, since
        an object may be photographed all around.

    Raises
    ------
    GeometryError
        If no maps agree.
    ValueError
        If names, maps and photos differ in number.
    """
    options, progress = options or FusionOptions(), progress or SilentProgress()
    if len(names) != len(depth_maps) or (photos is not None and len(photos) != len(depth_maps)):
        raise ValueError("names, maps and photos differ in number")
    rows = {name: row for row, name in enumerate(names)}
    cache = _DepthMapCache(depth_maps, options.cache_bytes)
    photo_results = []
    progress.stage(tr("Fusing depth maps"), len(depth_maps))
    for row, name in enumerate(names):
        progress.step(row)
        other_rows = (
            range(len(names))
            if neighbours is None
            else _rows_of_names(neighbours.get(name, ()), rows)
        )
        photo_result = _fuse_photo(
            row, [other_row for other_row in other_rows if other_row != row], cache, options
        )
        if photo_result is not None:
            colors = np.zeros((len(photo_result[0]), 0), np.uint8)
            if photos is not None:
                colors = photos[row].pixels()[photo_result[0], photo_result[1]]
            photo_results.append((*photo_result[2:], colors))
    progress.step(len(depth_maps))
    if not photo_results:
        raise GeometryError(Finding("dense.no-agreement"))
    columns = [list(column) for column in zip(*photo_results, strict=True)]
    photo_results.clear()
    points, normals, confidence, views, colors = (_concatenate(column) for column in columns)
    return PointCloud(
        points,
        colors if photos is not None else None,
        normals,
        {"confidence": confidence, "views": views},
    )


def peak_memory_bytes(pixels: int, max_pixels: int) -> int:
    """Estimate the peak memory of `fuse_depth_maps`, in bytes.

    Measured: 0.1 to 0.25 points per pixel for photos with an overlap of at least 60 %.

    pixels : number of pixels of all maps
    max_pixels : number of pixels of the largest map
    """
    return int(0.25 * pixels * 70) + 70 * max_pixels + FusionOptions.cache_bytes


def _concatenate(parts: list[Any]) -> Any:
    """Concatenate arrays, and release the parts, which are the largest data in memory."""
    joined_array = np.concatenate(parts)
    parts.clear()
    return joined_array


class _DepthMapCache:
    """Cache of recently used maps, limited in bytes."""

    def __init__(self, depth_maps: Sequence[DepthMap], max_bytes: int) -> None:
        self._depth_maps, self._max_bytes = depth_maps, max_bytes
        self._entries: OrderedDict[int, DepthMap] = OrderedDict()
        self._bytes = 0

    def __getitem__(self, row: int) -> DepthMap:
        if row in self._entries:
            self._entries.move_to_end(row)
            return self._entries[row]
        depth_map = self._depth_maps[row]
        self._entries[row] = depth_map
        self._bytes += _size_bytes(depth_map)
        while self._bytes > self._max_bytes and len(self._entries) > 2:
            self._bytes -= _size_bytes(self._entries.popitem(last=False)[1])
        return depth_map


def _size_bytes(depth_map: DepthMap) -> int:
    return depth_map.depth.nbytes + depth_map.normals.nbytes + depth_map.confidence.nbytes


def _rows_of_names(names: Sequence[str], rows: Mapping[str, int]) -> Iterator[int]:
    return (rows[name] for name in names if name in rows)


def _lens_parameters(depth_map: DepthMap) -> FloatArray:
    lens = depth_map.view.intrinsics
    return np.array([*lens.focal, *lens.centre])


def _fuse_photo(  # type: ignore[no-untyped-def]
    row: int, other_rows: Sequence[int], depth_maps: _DepthMapCache, options: FusionOptions
):
    """Return rows, columns, points, normals, confidence and views of the used pixels.

    Returns None if no pixel is used.
    """
    from vomstudio.photogrammetry.dense._fusion_kernels import compare

    reference_map = depth_maps[row]
    shape = reference_map.depth.shape
    if not (reference_map.depth > 0).any():
        return None
    confidence_share = reference_map.confidence.astype(np.float32) / np.float32(255.0)
    has_depth = reference_map.depth > 0
    weight = np.zeros(shape, np.float32)
    weight[has_depth] = (
        confidence_share[has_depth]
        * (np.float32(reference_map.view.intrinsics.focal[0]) / reference_map.depth[has_depth]) ** 2
    )
    sums = np.zeros((*shape, 6), np.float32)
    sums[..., 0] = weight
    sums[..., 2] = 1.0 - confidence_share
    sums[..., 3:] = weight[..., None] * reference_map.normals
    votes = np.zeros((*shape, 3), np.uint8)
    limits = np.array(
        [
            options.max_reprojection_px,
            options.max_depth_share,
            np.cos(np.radians(options.max_normal_deg)),
            _MAX_FOOTPRINT_RATIO,
        ]
    )
    depth = to_kernel_array(reference_map.depth, np.float32)
    normals = to_kernel_array(reference_map.normals, np.float32)
    for other_row in other_rows:
        other_map = depth_maps[other_row]
        rotation = other_map.view.rotation @ reference_map.view.rotation.T
        transform = np.column_stack(
            [rotation, other_map.view.translation - rotation @ reference_map.view.translation]
        )
        compare(
            depth,
            normals,
            _lens_parameters(reference_map),
            to_kernel_array(other_map.depth, np.float32),
            to_kernel_array(other_map.normals, np.float32),
            to_kernel_array(other_map.confidence, np.uint8),
            _lens_parameters(other_map),
            to_kernel_array(transform, np.float64),
            other_row > row,
            limits,
            sums,
            votes,
        )
    confidence = 1.0 - sums[..., 2]
    is_kept = (
        has_depth
        & (votes[..., 0] + 1 >= options.min_views)
        & (votes[..., 1] <= votes[..., 0])
        & (votes[..., 2] == 0)
        & (confidence >= options.min_confidence)
    )
    j, i = np.nonzero(is_kept)
    if not len(j):
        return None
    rays = reference_map.view.intrinsics.rays(np.column_stack([i, j]) + 0.5)
    point_sums = sums[j, i].astype(np.float64)
    points = rays * reference_map.depth[j, i, None].astype(np.float64)
    points += (
        reference_map.normals[j, i]
        * (point_sums[:, 1] / np.maximum(point_sums[:, 0], 1e-300))[:, None]
    )
    mean_normals = _orient_normals(
        point_sums[:, 3:], reference_map.normals[j, i].astype(np.float64), rays
    )
    rotation = reference_map.view.rotation
    return (
        j,
        i,
        (points - reference_map.view.translation) @ rotation,
        (mean_normals @ rotation).astype(np.float32),
        confidence[j, i],
        votes[j, i, 0] + np.uint8(1),
    )


def _orient_normals(mean: FloatArray, photo_normals: FloatArray, rays: FloatArray) -> FloatArray:
    """Return unit normals (n, 3) towards the camera.

    This is the mean of the agreeing normals, or the photo's own normal if the mean points away from
    the camera.
    """
    normals = np.where(((mean * rays).sum(axis=1) < 0.0)[:, None], mean, photo_normals)
    normals = np.where(((normals * rays).sum(axis=1) <= 0.0)[:, None], normals, -normals)
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300))
