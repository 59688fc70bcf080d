"""Background of a scene: tie points far behind the photographed rock.

A point is background if the rock is several times nearer in the photos that show the point. The
depth of the rock in a photo is the median depth of its tie points, weighted by the angles between
their rays: photos are spaced for the rock, so rays to a building or hills behind it are nearly
parallel. Rock that is distant in some photos and near in others is not background, nor is rock that
only overview photos show, because these show all of it at about one depth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, Int32Array, IntArray
from vomstudio.photogrammetry.base.scene import SparseScene

# Range of depths, relative to that of the rock, at which background may begin, and the minimum
# ratio between the depths on both sides of the gap that separates it from the rock.
_MIN_FACTOR, _MAX_FACTOR = 2.0, 6.0
_MIN_GAP_RATIO = 1.3
# Rays at larger angles have equal weights.
_MAX_ANGLE_DEG = 15.0
# A point is rock if at least this share of its photos, by their weights, show it near. A single
# photo of many may look past the rock.
_MIN_NEAR_SHARE = 0.2
# Minimum share of the weight of all points that must remain.
_MIN_ROCK_SHARE = 0.3
# Fewer tie points are single wrong matches.
_MIN_BACKGROUND_SHARE = 0.005
_MAX_ROUNDS = 6
# Tie points belong to one body if their distance is at most this share of their depth.
_MAX_LINK_SHARE = 0.1
_N_NEIGHBOURS = 8
_REGION_PADDING = 0.05


@dataclass(frozen=True, eq=False)
class RockExtent:
    """Division of the tie points of a scene into rock and background.

    Attributes
    ----------
    is_rock : (n,) array of bool
    factor : float
        Depth relative to the rock beyond which a tie point is background.
    depths : (n,) float array
        Depth of each tie point in the nearest photo that shows it.
    """

    is_rock: BoolArray
    factor: float
    depths: FloatArray

    @property
    def has_background(self) -> bool:
        """Whether there are tie points behind the rock."""
        return not bool(self.is_rock.all())

    @property
    def background_share(self) -> float:
        """Share of the tie points that are background."""
        return 1.0 - float(self.is_rock.mean()) if len(self.is_rock) else 0.0

    def contains(self, scene: SparseScene, points: FloatArray) -> BoolArray:
        """Return a mask (n,) of the points (n, 3) of a cloud that are not background.

        Each point is classified like the nearest tie point. Points far from all tie points, such as
        wrong depths in the sky, are background too.
        """
        from scipy.spatial import cKDTree

        if not self.has_background:
            return np.ones(len(points), bool)
        rock_rows = np.flatnonzero(self.is_rock)
        distance, nearest = cKDTree(scene.points[rock_rows]).query(points, workers=-1)
        max_distance = (self.factor - 1.0) * self.depths[rock_rows[nearest]]
        background_distance = cKDTree(scene.points[~self.is_rock]).query(points, workers=-1)[0]
        return np.asarray((distance <= background_distance) & (distance <= max_distance))


def find_rock(scene: SparseScene) -> RockExtent:
    """Divide the tie points of a scene into rock and background.

    All points are rock if the division leaves too few of them as rock or as background.

    Parameters
    ----------
    scene : SparseScene
    """
    count = len(scene.points)
    depths, weights = _observation_depths(scene), _angle_weights(scene)
    nearest_depths = np.full(count, np.inf)
    np.minimum.at(nearest_depths, scene.track_points, np.where(depths > 0, depths, np.inf))
    is_rock, factor = np.ones(count, bool), math.inf
    undivided_extent = RockExtent(is_rock, factor, nearest_depths)
    for _ in range(_MAX_ROUNDS):
        ratios = _depth_ratios(scene, depths, weights, is_rock)
        factor = _depth_ratio_limit(ratios[is_rock])
        is_near = is_rock & (ratios <= factor)
        if is_near.sum() == is_rock.sum():
            break
        is_rock = _remove_background_bodies(scene, is_near, nearest_depths)
    has_enough_rock = weights[is_rock].sum() >= _MIN_ROCK_SHARE * weights.sum()
    if not has_enough_rock or (~is_rock).sum() < _MIN_BACKGROUND_SHARE * count:
        return undivided_extent
    return RockExtent(is_rock, factor, nearest_depths)


def propose_region(scene: SparseScene, extent: RockExtent) -> tuple[float, ...] | None:
    """Return a box around the tie points of the rock, x0, y0, z0, x1, y1, z1.

    It is in the frame of the model and excludes outliers. Returns None if there are no rock points.

    Parameters
    ----------
    scene : SparseScene
    extent : RockExtent
        Result of `find_rock` for the scene.
    """
    points = scene.points[extent.is_rock]
    if not len(points):
        return None
    low, high = np.percentile(points, [0.5, 99.5], axis=0)
    margin = np.maximum(_REGION_PADDING * (high - low), 0.5 * _REGION_PADDING * np.ptp(points))
    origin = np.asarray(scene.origin, np.float64)
    step = 10.0 ** math.floor(math.log10(max(float((high - low).max()), 1e-12)) - 2)
    box = [
        *np.floor((low - margin + origin) / step) * step,
        *np.ceil((high + margin + origin) / step) * step,
    ]
    digits = max(0, -math.floor(math.log10(step)))
    return tuple(round(float(value), digits) for value in box)


def _observation_depths(scene: SparseScene) -> FloatArray:
    """Return the depth (m,) of each observation along the axis of its photo."""
    depths = np.zeros(len(scene.track_views))
    order = np.argsort(scene.track_views, kind="stable")
    stops = np.cumsum(np.bincount(scene.track_views, minlength=len(scene.views)))
    for view, rows in zip(scene.views, np.split(order, stops[:-1]), strict=True):
        depths[rows] = view.depths(scene.points[scene.track_points[rows]])
    return depths


def _angle_weights(scene: SparseScene) -> FloatArray:
    """Return the angle (n,) in degrees between the rays to each tie point.

    Larger angles are reduced to `_MAX_ANGLE_DEG`.
    """
    rays = scene.points[scene.track_points] - scene.centres[scene.track_views]
    rays /= np.maximum(np.linalg.norm(rays, axis=1, keepdims=True), 1e-300)
    count = len(scene.points)
    sums = [np.bincount(scene.track_points, ray, count) for ray in rays.T]
    mean = np.stack(sums, axis=1).astype(np.float64)
    mean /= np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-300)
    sines = np.linalg.norm(np.cross(rays, mean[scene.track_points]), axis=1)
    max_sines = np.zeros(count)
    np.maximum.at(max_sines, scene.track_points, sines)
    return np.minimum(np.degrees(np.arcsin(np.clip(2 * max_sines, 0, 1))), _MAX_ANGLE_DEG)


def _depth_ratios(
    scene: SparseScene, depths: FloatArray, weights: FloatArray, is_rock: BoolArray
) -> FloatArray:
    """Return the depth (n,) of each tie point relative to that of the rock in its photos."""
    rock_depths = _rock_depths(scene, depths, weights * is_rock)
    ratios = depths / rock_depths[scene.track_views]
    # Photos without rock are not evidence for it.
    ratios[~(np.isfinite(ratios) & (ratios > 0))] = np.inf
    views = len(scene.views)
    observations = np.maximum(np.bincount(scene.track_views, minlength=views), 1)
    squares = weights[scene.track_points] ** 2
    photo_weights = np.bincount(scene.track_views, squares, views) / observations
    return _weighted_quantiles(
        ratios,
        photo_weights[scene.track_views],
        scene.track_points,
        len(scene.points),
        _MIN_NEAR_SHARE,
    )


def _remove_background_bodies(
    scene: SparseScene, is_rock: BoolArray, nearest_depths: FloatArray
) -> BoolArray:
    """Return `is_rock` without the points of connected bodies that are mostly background."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    count = len(scene.points)
    if count <= _N_NEIGHBOURS:
        return is_rock
    distance, neighbour = cKDTree(scene.points).query(scene.points, _N_NEIGHBOURS + 1, workers=-1)
    row, column = np.nonzero(distance <= _MAX_LINK_SHARE * nearest_depths[:, None])
    links = coo_matrix((np.ones(len(row), np.int8), (row, neighbour[row, column])), (count, count))
    body = connected_components(links, directed=False)[1]
    rock_share = np.bincount(body, is_rock) / np.bincount(body)
    return np.asarray(is_rock & (rock_share[body] >= 0.5))


def _rock_depths(scene: SparseScene, depths: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the weighted median depth (v,) of the points of each photo; NaN if undefined."""
    weight = np.where(depths > 0, weights[scene.track_points], 0.0)
    return _weighted_quantiles(depths, weight, scene.track_views, len(scene.views), 0.5)


def _weighted_quantiles(
    values: FloatArray, weights: FloatArray, groups: IntArray | Int32Array, count: int, share: float
) -> FloatArray:
    """Return a quantile (count,) of the values of each group; NaN if the weights are zero."""
    order = np.lexsort((values, groups))
    total = np.bincount(groups, weights, count)
    result = np.full(count, np.nan)
    if not total.any():
        return result
    sums = np.cumsum(weights[order])
    group_starts = np.cumsum(total) - total
    has_weight = total > 0
    # Rounding of the sums must not select a neighbouring group.
    last = np.cumsum(np.bincount(groups, minlength=count)) - 1
    rows = np.minimum(np.searchsorted(sums, group_starts + share * total), np.maximum(last, 0))
    result[has_weight] = values[order][rows[has_weight]]
    return result


def _depth_ratio_limit(ratios: FloatArray) -> float:
    """Return the depth ratio in the middle of the widest gap.

    Returns `_MAX_FACTOR` if no gap is wide enough.
    """
    low, high = math.log(_MIN_FACTOR), math.log(_MAX_FACTOR)
    values = np.log(ratios)
    ends = np.sort(np.concatenate([[low], values[(values > low) & (values < high)], [high]]))
    gaps = np.diff(ends)
    widest_gap = int(gaps.argmax())
    if gaps[widest_gap] < math.log(_MIN_GAP_RATIO):
        return _MAX_FACTOR
    return math.exp((ends[widest_gap] + ends[widest_gap + 1]) / 2)
