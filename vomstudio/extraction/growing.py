"""Region growing of planar parts of a surface, which assigns a label to each element.

Seeds are processed in order of planarity. After growing, each element is assigned to the nearest
plane around it, and neighbouring regions that form one plane within their scatter are merged.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, Int32Array, IntArray
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.extraction.elements import Elements, approximate_median
from vomstudio.extraction.kernels import (
    add_moments,
    assign_nearest_planes,
    grow_regions,
    map_labels,
    sort_by_label,
)
from vomstudio.extraction.point_neighbours import N_NEIGHBOURS
from vomstudio.geometry.kernels.jit import to_kernel_array

UNASSIGNED_LABEL, OUTLIER_LABEL = -1, -2
_AXIS_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
# Maximum distance from a plane, in multiples of the local spacing and of the local noise.
_MAX_DISTANCE_SPACINGS = 1.0
_MAX_DISTANCE_NOISE = 3.0
_SEEDS_PER_STEP = 50_000
_MAX_REASSIGNMENTS = 4
_MAX_DEVIATIONS = 3.5
"""Maximum distance of an element from the plane of its facet, in standard deviations."""
_MAX_SCATTER_RATIO = 1.25
"""Maximum ratio of the common scatter of two facets to their separate scatter for a merge."""


_MAX_PARALLEL_DEG = 2.0
_MIN_TURN_SHARE = 0.125
"""Minimum rotation of normals in a piece of a bend, from its middle to its outer third.

The value is a share of the rotation to the next piece: 0.3 on a cylinder, about 0 beside an edge
between planes."""
_PIECE_QUANTILES = (0.35, 0.65, 0.93)
_MIN_MEAN_TURN_SHARE, _MIN_NEIGHBOURS = 0.06, 3
"""Minimum share for the mean over all neighbours, and minimum number of them for this mean."""
_MAX_SAMPLE, _MIN_TURN_SAMPLE, _MAX_FACETS = 1500, 30, 500
_MAX_LOOSE_SHARE = 0.35
"""Maximum share of the neighbours of a facet that do not belong to a facet.

A slice through points that do not form a surface, such as clutter, has a larger share."""


@dataclass(frozen=True, eq=False)
class FacetPlanes:
    """Planes of f facets, computed from the moments of their elements.

    Parameters
    ----------
    centre, normal : (f, 3) arrays
        Centres are relative to the origin of the elements.
    rms, area : (f,) arrays
    count : (f,) int array
    scatter : (f, 3, 3) array
        Area-weighted covariance of the positions.
    squared_tolerances : (f,) array
        Sum of the squared tolerances of the elements; 0 if they are unknown.
    """

    centre: FloatArray
    normal: FloatArray
    rms: FloatArray
    area: FloatArray
    count: IntArray
    scatter: FloatArray
    squared_tolerances: FloatArray


def element_tolerances(elements: Elements, max_distance: float | None) -> FloatArray:
    """Return the maximum distance of each element from a plane.

    Parameters
    ----------
    elements : Elements
    max_distance : float or None
        Distance in metres. If None, the local spacing is used, or three times the local noise if
        this is larger. The noise is limited to twice its typical value, and the distances on a mesh
        to their median.

    Returns
    -------
    (n,) ndarray
        Distances in metres.
    """
    if max_distance is not None:
        return np.full(len(elements), max_distance)
    noise = np.nan_to_num(elements.noise)
    # At edges, the local scatter is relief rather than noise, so it is limited by the typical
    # noise. Only elements with a normal count, because there may be many cells with a few scattered
    # points.
    planar_noise = noise[np.isfinite(elements.normals[:, 0])]
    typical_noise = approximate_median(planar_noise) if len(planar_noise) else 0.0
    tolerance = np.minimum(noise, 2.0 * typical_noise)
    tolerance *= _MAX_DISTANCE_NOISE
    np.maximum(tolerance, _MAX_DISTANCE_SPACINGS * elements.spacing, out=tolerance)
    if elements.kind == "face":
        # Large and small faces of a mesh are equally accurate.
        tolerance = np.minimum(tolerance, max(float(np.median(tolerance)), 1e-300))
    return to_kernel_array(tolerance, np.float64)


def grow_facets(
    elements: Elements,
    *,
    angle_deg: float,
    max_distances: FloatArray,
    min_count: int,
    min_area: float,
    typical_tolerance: float,
    progress: Progress,
    known_labels: Int32Array | None = None,
) -> Int32Array:
    """Grow facets from seeds and assign the elements to them.

    Parameters
    ----------
    elements : Elements
    angle_deg : float
        Maximum angle between the normal of an element and the plane of the facet, degrees.
    max_distances : (n,) array
        Maximum distance of each element from the plane of its facet, m.
    min_count, min_area
        Minimum number of elements and minimum area; a facet must reach one of the two.
    typical_tolerance : float
        Median of `max_distances`, m.
    progress : Progress
        Its steps are the seeds processed so far.
    known_labels : (n,) int32 array, optional
        Facets that are already known.

    Returns
    -------
    (n,) int32 array
        Facet of each element, in order of decreasing size; -1 if it belongs to none.

    Raises
    ------
    Cancelled
        Through `progress`.
    """
    n = len(elements)
    labels = (
        np.full(n, UNASSIGNED_LABEL, np.int32)
        if known_labels is None
        else to_kernel_array(known_labels, np.int32)
    )
    is_usable = np.isfinite(elements.normals[:, 0]) & np.isfinite(max_distances)
    labels[~is_usable] = OUTLIER_LABEL
    rows, inner_sums = np.arange(n), None
    if known_labels is not None:
        is_listed = np.diff(elements.starts) > 0
        rows, closed_rows = np.flatnonzero(is_listed), np.flatnonzero(~is_listed)
        inner_sums = _sum_moments(
            elements, labels, closed_rows, _count_facets(labels), max_distances=max_distances
        )
    free_rows = rows[labels[rows] == UNASSIGNED_LABEL]
    roughness = np.nan_to_num(elements.variation[free_rows], nan=1.0)
    order = free_rows[np.argsort(roughness, kind="stable")]
    queue, sums = np.empty(n, np.int32), np.zeros(10)
    cosine = float(np.cos(np.radians(angle_deg)))
    progress.stage(tr("Growing facets"), len(order))
    label = _count_facets(labels)
    for first in range(0, len(order), _SEEDS_PER_STEP):
        seed_stop = min(first + _SEEDS_PER_STEP, len(order))
        label = grow_regions(
            order,
            first,
            seed_stop,
            elements.places,
            elements.normals,
            elements.areas,
            elements.inner_moments,
            max_distances,
            elements.starts,
            elements.neighbours,
            cosine,
            min_count,
            min_area,
            labels,
            queue,
            label,
            sums,
        )
        progress.step(seed_stop)
    progress.stage(tr("Merging facets"), None)
    for _ in range(2):
        labels = _reassign_elements(
            elements, rows, inner_sums, max_distances, typical_tolerance, cosine, labels
        )
        labels, inner_sums = _merge_coplanar_facets(
            elements, rows, inner_sums, max_distances, angle_deg, labels
        )
        progress.step(0)
    labels = _reassign_elements(
        elements, rows, inner_sums, max_distances, typical_tolerance, cosine, labels
    )
    return _remove_small_facets(
        elements,
        rows,
        facet_planes(elements, labels, rows, inner_sums),
        labels,
        min_count,
        min_area,
    )


@dataclass(frozen=True, eq=False)
class _FacetSums:
    """Sums (f, 11) of f facets: weight, moments about reference points, squared tolerances."""

    reference_points: FloatArray
    is_known: BoolArray
    sums: FloatArray
    count: IntArray

    def extend_to(self, f: int) -> _FacetSums:
        """Return a copy extended to `f` facets."""
        n_added = f - len(self.is_known)
        return _FacetSums(
            np.concatenate([self.reference_points, np.zeros((n_added, 3))]),
            np.concatenate([self.is_known, np.zeros(n_added, np.bool_)]),
            np.concatenate([self.sums, np.zeros((n_added, 11))]),
            np.concatenate([self.count, np.zeros(n_added, np.int64)]),
        )

    def merge_facets(self, number: IntArray) -> _FacetSums:
        """Return the sums after merging facets with equal numbers (f,)."""
        merged_sums = _zero_sums(int(number.max(initial=-1)) + 1)
        used_rows = np.flatnonzero(self.is_known)
        merged_sums.is_known[number[used_rows]] = True
        merged_sums.reference_points[number[used_rows][::-1]] = self.reference_points[used_rows][
            ::-1
        ]
        shift, sums = (
            self.reference_points[used_rows] - merged_sums.reference_points[number[used_rows]],
            self.sums[used_rows].copy(),
        )
        weight, first = sums[:, 0], sums[:, 1:4].copy()
        for position, (i, j) in enumerate(_AXIS_PAIRS):
            sums[:, 4 + position] += (
                first[:, i] * shift[:, j]
                + first[:, j] * shift[:, i]
                + weight * shift[:, i] * shift[:, j]
            )
        sums[:, 1:4] += weight[:, None] * shift
        np.add.at(merged_sums.sums, number[used_rows], sums)
        np.add.at(merged_sums.count, number[used_rows], self.count[used_rows])
        return merged_sums


def _zero_sums(f: int) -> _FacetSums:
    return _FacetSums(
        np.zeros((f, 3)), np.zeros(f, np.bool_), np.zeros((f, 11)), np.zeros(f, np.int64)
    )


def _sum_moments(
    elements: Elements,
    labels: Int32Array,
    rows: IntArray,
    f: int,
    inner_sums: _FacetSums | None = None,
    max_distances: FloatArray | None = None,
) -> _FacetSums:
    sums = _zero_sums(f) if inner_sums is None else inner_sums.extend_to(f)
    kernel_labels = to_kernel_array(labels, np.int32)
    add_moments(
        rows,
        elements.places,
        elements.areas,
        elements.inner_moments,
        np.zeros(1) if max_distances is None else max_distances,
        kernel_labels,
        sums.reference_points,
        sums.is_known,
        sums.sums,
        sums.count,
    )
    return sums


def facet_planes(
    elements: Elements,
    labels: Int32Array,
    rows: IntArray | None = None,
    inner_sums: _FacetSums | None = None,
    max_distances: FloatArray | None = None,
) -> FacetPlanes:
    """Compute the area-weighted planes of all facets, from 0 to the largest label.

    Parameters
    ----------
    elements : Elements
    labels : (n,) int32 array
    rows : int array, optional
        Elements to add; by default, all elements.
    inner_sums : _FacetSums, optional
        Sums of all other elements.
    max_distances : (n,) array, optional
        Tolerances of the elements, for `FacetPlanes.squared_tolerances`.
    """
    rows = np.arange(len(labels)) if rows is None else rows
    sums = _sum_moments(elements, labels, rows, _count_facets(labels), inner_sums, max_distances)
    area = sums.sums[:, 0]
    means = sums.sums[:, 1:] / np.where(area > 0.0, area, 1.0)[:, None]
    mean = means[:, :3]
    scatter = np.empty((len(area), 3, 3))
    for position, (i, j) in enumerate(_AXIS_PAIRS):
        scatter[:, i, j] = scatter[:, j, i] = means[:, 3 + position] - mean[:, i] * mean[:, j]
    values, vectors = np.linalg.eigh(scatter)
    return FacetPlanes(
        sums.reference_points + mean,
        np.ascontiguousarray(vectors[:, :, 0]),
        np.sqrt(np.maximum(values[:, 0], 0.0)),
        area,
        sums.count,
        scatter,
        sums.sums[:, 10],
    )


def facet_limits(planes: FacetPlanes, typical_tolerance: float) -> FloatArray:
    """Return the maximum distance of elements from the planes of facets, based on scatter.

    Parameters
    ----------
    planes : FacetPlanes
    typical_tolerance : float
        Median tolerance of the elements, m.

    Returns
    -------
    (f,) ndarray
        Distances in metres.
    """
    return to_kernel_array(
        np.maximum(_MAX_DEVIATIONS * planes.rms, 0.1 * typical_tolerance), np.float64
    )


def _reassign_elements(
    elements: Elements,
    rows: IntArray,
    inner_sums: _FacetSums | None,
    max_distances: FloatArray,
    typical_tolerance: float,
    cosine: float,
    labels: Int32Array,
) -> Int32Array:
    for _ in range(_MAX_REASSIGNMENTS):
        planes = facet_planes(elements, labels, rows, inner_sums)
        if not len(planes.area):
            return labels
        out = np.empty(len(rows), np.int32)
        changed_count = assign_nearest_planes(
            rows,
            elements.places,
            elements.normals,
            max_distances,
            elements.starts,
            elements.neighbours,
            cosine,
            to_kernel_array(planes.centre, np.float64),
            to_kernel_array(planes.normal, np.float64),
            facet_limits(planes, typical_tolerance),
            labels,
            out,
        )
        labels[rows] = out
        if changed_count <= 1e-4 * len(labels):
            break
    return labels


def _merge_coplanar_facets(
    elements: Elements,
    rows: IntArray,
    inner_sums: _FacetSums | None,
    max_distances: FloatArray,
    angle_deg: float,
    labels: Int32Array,
) -> tuple[Int32Array, _FacetSums | None]:
    """Merge neighbouring facets that form one plane; return the labels and the merged sums."""
    f = _count_facets(labels)
    if f < 2:
        return labels, inner_sums
    pairs = _adjacent_facets(elements, labels, f, rows)
    planes = facet_planes(elements, labels, rows, inner_sums, max_distances)
    owner = np.arange(f)
    weight = planes.area.copy()
    mean, normal, rms = planes.centre.copy(), planes.normal.copy(), planes.rms.copy()
    scatter = planes.scatter.copy()
    limit = np.sqrt(planes.squared_tolerances / np.maximum(planes.count, 1))
    cosine = np.abs((normal[pairs[:, 0]] * normal[pairs[:, 1]]).sum(axis=1))
    is_parallel = cosine >= np.cos(np.radians(angle_deg))
    pairs = pairs[is_parallel][np.argsort(-cosine[is_parallel], kind="stable")]
    for first, second in pairs.tolist():
        a, b = _find_root(owner, first), _find_root(owner, second)
        if a == b or weight[a] <= 0.0 or weight[b] <= 0.0:
            continue
        total = weight[a] + weight[b]
        centre_offset = mean[b] - mean[a]
        joint_scatter = (
            weight[a] * scatter[a]
            + weight[b] * scatter[b]
            + weight[a] * weight[b] / total * np.outer(centre_offset, centre_offset)
        ) / total
        values, vectors = np.linalg.eigh(joint_scatter)
        joint_rms = float(np.sqrt(max(values[0], 0.0)))
        separate_rms = np.sqrt((weight[a] * rms[a] ** 2 + weight[b] * rms[b] ** 2) / total)
        max_scatter = max(_MAX_SCATTER_RATIO * separate_rms, 0.1 * min(limit[a], limit[b]))
        if joint_rms > max_scatter:
            continue
        # The common scatter is not a suitable test for a small facet beside a large one: the small
        # facet must lie in the plane of the large one.
        smaller_facet, larger_facet = (a, b) if weight[a] < weight[b] else (b, a)
        distance = abs(float((mean[smaller_facet] - mean[larger_facet]) @ normal[larger_facet]))
        tilt = abs(float(normal[smaller_facet] @ vectors[:, 0]))
        width = np.sqrt(max(float(np.trace(scatter[smaller_facet])), 0.0))
        rise = width * np.sqrt(max(1.0 - tilt * tilt, 0.0))
        if distance > 2.0 * max(rms[larger_facet], 0.05 * limit[larger_facet]) or rise > 2.0 * max(
            rms[smaller_facet], 0.05 * limit[smaller_facet]
        ):
            continue
        owner[b] = a
        mean[a] = mean[a] + (weight[b] / total) * centre_offset
        weight[a], scatter[a], normal[a], rms[a] = total, joint_scatter, vectors[:, 0], joint_rms
    roots = np.array([_find_root(owner, i) for i in range(f)])
    _, number = np.unique(roots, return_inverse=True)
    # The last two entries represent OUTLIER_LABEL and UNASSIGNED_LABEL, which index from the end.
    out = np.empty_like(labels)
    map_labels(labels, np.append(number, [OUTLIER_LABEL, UNASSIGNED_LABEL]).astype(np.int32), out)
    return out, None if inner_sums is None else inner_sums.extend_to(f).merge_facets(number)


def _find_root(owner: IntArray, i: int) -> int:
    while owner[i] != i:
        owner[i] = owner[owner[i]]
        i = int(owner[i])
    return i


def _adjacent_facets(
    elements: Elements, labels: Int32Array, f: int, rows: IntArray | None = None
) -> IntArray:
    """Return the pairs (p, 2) of facets that have neighbouring elements among `rows`."""
    number = np.diff(elements.starts)
    labels_and_counts = (labels, number) if rows is None else (labels[rows], number[rows])
    source = np.repeat(*labels_and_counts)
    target = labels[elements.neighbours]
    border = (source != target) & (source >= 0) & (target >= 0)
    a, b = source[border].astype(np.int64), target[border].astype(np.int64)
    key = np.unique(np.minimum(a, b) * f + np.maximum(a, b))
    return np.stack([key // f, key % f], axis=1)


def _remove_small_facets(
    elements: Elements,
    rows: IntArray,
    planes: FacetPlanes,
    labels: Int32Array,
    min_count: int,
    min_area: float,
) -> Int32Array:
    """Remove facets that are too small or not part of a surface; sort the others by size.

    Elements of removed facets receive -1; the others are numbered by decreasing area.
    """
    is_kept = (planes.count >= min_count) | ((planes.area >= min_area) & (planes.area > 0.0))
    is_kept &= _loose_shares(elements, rows, planes, labels) <= _MAX_LOOSE_SHARE
    order = np.argsort(-np.where(is_kept, planes.area, -1.0), kind="stable")
    # The last two entries represent OUTLIER_LABEL and UNASSIGNED_LABEL.
    number = np.full(len(planes.area) + 2, UNASSIGNED_LABEL, np.int32)
    number[order[: int(is_kept.sum())]] = np.arange(int(is_kept.sum()))
    out = np.empty_like(labels)
    map_labels(labels, number, out)
    return out


def _loose_shares(
    elements: Elements, rows: IntArray, planes: FacetPlanes, labels: Int32Array
) -> FloatArray:
    """Return the share (f,) of the neighbours of each facet that do not belong to a facet.

    The shares of faces and cells are zero.
    """
    f = len(planes.area)
    if elements.kind != "point":
        return np.zeros(f)
    source = np.repeat(labels[rows], np.diff(elements.starts)[rows])
    is_inside = source >= 0
    is_free = labels[elements.neighbours[is_inside]] < 0
    facet_labels = source[is_inside]
    listed_labels = labels[rows]
    # Points without a list of neighbours are in the interior of their facet.
    interior_counts = planes.count - np.bincount(listed_labels[listed_labels >= 0], minlength=f)
    total = np.bincount(facet_labels, minlength=f) + N_NEIGHBOURS * interior_counts
    return np.asarray(np.bincount(facet_labels, is_free, f) / np.maximum(total, 1))


def _count_facets(labels: Int32Array) -> int:
    return max(int(labels.max(initial=UNASSIGNED_LABEL)) + 1, 0)


def find_bent_facets(elements: Elements, labels: Int32Array, angle_deg: float) -> BoolArray:
    """Find facets that bend and continue into a neighbour: parts of a wavy or curved face.

    The angle between the two facets must be between 2 degrees and the threshold, and the slope of
    the facet must change from its middle toward the neighbour, as on a bend. Beside an edge between
    planes, the slope changes only at the edge. In large models, a pair is tested only if it
    contains one of the largest facets.

    Parameters
    ----------
    elements : Elements
    labels : (n,) int32 array
        Facet of each element, in order of decreasing size.
    angle_deg : float
        Maximum angle between two pieces of a bend, degrees.

    Returns
    -------
    (f,) bool array
    """
    f = _count_facets(labels)
    is_bent = np.zeros(f, np.bool_)
    if f < 2:
        return is_bent
    planes = facet_planes(elements, labels)
    pairs = _adjacent_facets(elements, labels, f)
    angle = _angle_deg(planes.normal[pairs[:, 0]], planes.normal[pairs[:, 1]])
    pairs = pairs[(angle > _MAX_PARALLEL_DEG) & (angle < angle_deg)]
    pairs = pairs[(pairs < _MAX_FACETS).any(axis=1)]
    ends, rows = np.zeros(f + 1, np.int64), np.empty(len(labels), np.int64)
    sort_by_label(labels, ends, rows)
    samples = [rows[a:b][:: max(1, (b - a) // _MAX_SAMPLE)] for a, b in pairwise(ends.tolist())]
    # A single neighbour of a small facet may not be significant, but all its neighbours together
    # are.
    sums = np.zeros((f, 3))
    for first, second in pairs.tolist():
        first_turn = _rotation_to_neighbour(elements, planes, samples[first], first, second)
        second_turn = _rotation_to_neighbour(elements, planes, samples[second], second, first)
        for facet, (turn_share, error) in ((first, first_turn), (second, second_turn)):
            is_bent[facet] |= bool(turn_share > _MIN_TURN_SHARE + 2.0 * np.sqrt(error))
            if 0.0 < error < np.inf:
                sums[facet] += 1.0, 1.0 / error, turn_share / error
    is_known = sums[:, 0] >= _MIN_NEIGHBOURS
    weight = np.where(is_known, sums[:, 1], 1.0)
    is_bent |= is_known & (sums[:, 2] / weight > _MIN_MEAN_TURN_SHARE + 3.0 / np.sqrt(weight))
    return np.asarray(is_bent)


def _rotation_to_neighbour(
    elements: Elements, planes: FacetPlanes, rows: IntArray, first: int, second: int
) -> FloatArray:
    """Return the relative rotation of a facet toward a neighbour, and its variance.

    It is the rotation from the middle to the outer third of the facet, as a share of the rotation
    between the facets; both values are zero if it is undefined. Normals are not used, because they
    are averages over wide neighbourhoods.
    """
    normal, other_normal = planes.normal[first], planes.normal[second]
    # Perpendicular to the intersection of the two planes; the centre of a long facet would not be.
    direction = other_normal - (other_normal @ normal) * normal
    if direction @ (planes.centre[second] - planes.centre[first]) < 0.0:
        direction = -direction
    size, angle_tangent = float(np.linalg.norm(direction)), -float(other_normal @ direction)
    if len(rows) < _MIN_TURN_SAMPLE or size <= 0.0 or angle_tangent == 0.0:
        return np.zeros(2)
    angle_tangent /= float(other_normal @ normal) * size
    offset = elements.places[rows] - planes.centre[first]
    positions, height = offset @ (direction / size), offset @ normal
    inner_limit, centre, outer_limit = np.sort(positions)[
        (np.array(_PIECE_QUANTILES) * len(positions)).astype(np.int64)
    ]
    slopes = [
        _fit_slope(positions[is_inside], height[is_inside])
        for is_inside in (
            (positions > centre) & (positions < outer_limit),
            (positions > inner_limit) & (positions < centre),
        )
    ]
    return np.array(
        [
            (slopes[0][0] - slopes[1][0]) / angle_tangent,
            (slopes[0][1] + slopes[1][1]) / angle_tangent**2,
        ]
    )


def _fit_slope(position: FloatArray, height: FloatArray) -> tuple[float, float]:
    """Fit a slope to heights as a function of position; return it and its variance.

    The variance is infinite for fewer than four points or if all positions are equal.
    """
    centred_position = position - position.mean() if len(position) else position
    squared_length = float(centred_position @ centred_position)
    if len(position) < 4 or squared_length <= 0.0:
        return 0.0, np.inf
    slope = float(centred_position @ height) / squared_length
    residuals = height - height.mean() - slope * centred_position
    return slope, float(residuals @ residuals) / (len(position) - 2) / squared_length


def _angle_deg(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the angles (k,) between pairs of axes (k, 3), degrees."""
    return np.asarray(np.degrees(np.arccos(np.minimum(np.abs((first * second).sum(axis=1)), 1.0))))
