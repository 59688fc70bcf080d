"""Stretches in which a followed path has jumped from its contact to a parallel one.

A path that leaves its contact crosses rock without a visible contact, which costs more, and
continues beside the plane of the contact. It returns at the next way-point, which was clicked on
the contact. In each leg, one stretch between two crossings is excluded: the stretch whose omission
leaves the other points closest to a single plane. The stretch is doubtful if its offset from this
plane exceeds the error of the plane and the scatter of its points. A gap in a contact is crossed in
the same way, but the path behind the gap lies in the plane of the other points.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, pairwise

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.geology.doubtful_stretches import (
    MARGIN_VERTICES,
    MIN_POINTS,
    VertexRange,
    offset_from_plane,
)
from vomstudio.geometry.planes import FittedPlane, fit_planes

CONTACT_QUANTILE = 0.25
"""Quantile of the costs along a path that represents its contact."""
MIN_PEAK_HEIGHT = 0.1
"""Minimum height of a crossing between the cost of the contact (0) and that of typical rock (1)."""
MAX_PEAKS = 7
MAX_VERTICES = 500
MIN_VERTICES = 3
MIN_LENGTH_RESOLUTIONS = 4.0
"""Minimum length of a stretch, in model resolutions."""
MIN_OFFSET_RATIO = 1.3
"""Minimum ratio of the offset to the error and the scatter, both at 95 %.

Up to 2 % of single contacts then have a doubtful stretch, in most cases because the path has
actually left the contact (docs/plane_errors.md)."""


def find_jumps(
    points: FloatArray, costs: FloatArray, index: IntArray, resolution: float
) -> tuple[VertexRange, ...]:
    """Find the stretches of a path that are offset from the plane of the remaining points.

    Parameters
    ----------
    points : (n, 3) array
    costs : (n,) array
        Cost at each point, relative to the median over the searched surface or photo.
    index : (w,) array
        Rows of the way-points in ascending order.
    resolution : float
        Resolution of the model, in the unit of the points.

    Returns
    -------
    tuple of (int, int)
        First and last row of each stretch, in order; at most one stretch per leg.
    """
    step = -(-len(points) // MAX_VERTICES)
    if step > 1:
        # Average consecutive pixels of a photo.
        starts = np.arange(0, len(points), step)
        sizes = np.diff(np.append(starts, len(points)))
        means = np.add.reduceat(np.column_stack([points, costs]), starts, axis=0) / sizes[:, None]
        coarse_jumps = find_jumps(means[:, :3], means[:, 3], index // step, resolution)
        return tuple((a * step, min((b + 1) * step, len(points)) - 1) for a, b in coarse_jumps)
    legs = _jump_candidates(points, costs, index, resolution)
    is_used = np.ones(len(points), np.bool_)
    excluded_ranges: list[VertexRange] = []
    while (best_stretch := _find_best_stretch(points, is_used, legs)) is not None:
        leg, stretch = best_stretch
        excluded_ranges.append(stretch)
        is_used[_row_slice(stretch)] = False
        legs[leg] = []
    while excluded_ranges:
        fit = _fit_masked(points, [is_used])[0]
        ratios = [
            0.0 if fit is None else _offset_ratio(points, item, fit, resolution)
            for item in excluded_ranges
        ]
        weakest_row = int(np.argmin(ratios))
        if ratios[weakest_row] >= MIN_OFFSET_RATIO:
            break
        is_used[_row_slice(excluded_ranges.pop(weakest_row))] = True
        for stretch in excluded_ranges:
            is_used[_row_slice(stretch)] = False
    return tuple(sorted(excluded_ranges))


def _row_slice(stretch: VertexRange) -> slice:
    return slice(max(stretch[0] - MARGIN_VERTICES, 0), stretch[1] + 1 + MARGIN_VERTICES)


def _jump_candidates(
    points: FloatArray, costs: FloatArray, index: IntArray, resolution: float
) -> list[list[VertexRange]]:
    """Return the stretches of sufficient length between any two crossings of each leg."""
    from scipy.ndimage import uniform_filter1d
    from scipy.signal import find_peaks

    level = float(np.quantile(costs, CONTACT_QUANTILE))
    min_height = level + MIN_PEAK_HEIGHT * max(1.0 - level, 0.0)
    smoothed_costs = uniform_filter1d(costs, 3, mode="nearest")
    distances = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    legs = []
    for first, last in pairwise(index.tolist()):
        # A peak can be located at the way-point itself.
        peaks, properties = find_peaks(
            np.pad(smoothed_costs[first : last + 1], 1), height=min_height
        )
        peak_rows = np.sort(peaks[np.argsort(properties["peak_heights"])[-MAX_PEAKS:]]) + first - 1
        legs.append(
            [
                (a + 1, b - 1)
                for a, b in combinations(peak_rows.tolist(), 2)
                if b - a > MIN_VERTICES
                and distances[b - 1] - distances[a + 1] >= MIN_LENGTH_RESOLUTIONS * resolution
            ]
        )
    return legs


def _find_best_stretch(
    points: FloatArray, is_used: BoolArray, legs: Sequence[Sequence[VertexRange]]
) -> tuple[int, VertexRange] | None:
    """Return the leg and the stretch without which the points are closest to one plane.

    The points of the stretch may lie in a parallel plane. Return None if there is no such stretch.
    """
    choices = [(leg, stretch) for leg, stretches in enumerate(legs) for stretch in stretches]
    masks = []
    for _, stretch in choices:
        mask = is_used.copy()
        mask[_row_slice(stretch)] = False
        masks.append(mask)
    best_stretch, lowest_score = None, np.inf
    for choice, fit in zip(choices, _fit_masked(points, masks), strict=True):
        if fit is None or fit.rms is None:
            continue
        (a, b) = choice[1]
        offsets = (points[a : b + 1] - fit.centroid) @ fit.normal
        total = fit.n * fit.rms**2 + float(((offsets - offsets.mean()) ** 2).sum())
        if (score := total / (fit.n + len(offsets))) < lowest_score:
            best_stretch, lowest_score = choice, score
    return best_stretch


def _fit_masked(points: FloatArray, masks: Sequence[BoolArray]) -> list[FittedPlane | None]:
    """Fit a plane to the points of each mask (n,); None if they do not define a plane."""
    usable_rows = [i for i, mask in enumerate(masks) if mask.sum() >= MIN_POINTS]
    fits: list[FittedPlane | None] = [None] * len(masks)
    if not usable_rows:
        return fits
    groups = [points[masks[i]] for i in usable_rows]
    batch = fit_planes(np.concatenate(groups), np.cumsum([0, *map(len, groups)]))
    for i, fit in zip(usable_rows, batch.rows(), strict=True):
        fits[i] = None if fit.error is not None else fit
    return fits


def _offset_ratio(
    points: FloatArray, stretch: VertexRange, fit: FittedPlane, resolution: float
) -> float:
    """Return the offset of a stretch from a plane, in multiples of the allowed offset.

    Return 0 if the error of the plane is unknown.
    """
    if fit.max_confidence95_deg is None or fit.min_confidence95_deg is None or fit.rms is None:
        return 0.0
    centre = points[stretch[0] : stretch[1] + 1].mean(axis=0) - fit.centroid
    angles = np.radians(np.minimum([fit.min_confidence95_deg, fit.max_confidence95_deg], 89.9))
    distances_along = np.tan(angles) * (fit.axes[:2] @ centre)
    allowed_distance = np.sqrt((distances_along**2).sum() + (2.0 * fit.rms) ** 2 + resolution**2)
    return abs(offset_from_plane(points, stretch, fit)) / float(max(allowed_distance, 1e-300))
