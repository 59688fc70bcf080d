"""Where a followed path has left its contact for a parallel one.

A path that leaves its contact crosses rock on which nothing is to be seen, which costs more than to
follow a contact, and goes on beside the plane in which the contact lies; at the next way-point,
which was clicked on the contact, it is back. So of each leg the stretch between two crossings is
left out with which the others lie best in one plane. It is doubtful if it is beside that plane by
more than the plane's error and the scatter of its points allow. A gap in a contact is crossed in
the same manner; what is behind it lies in the plane of the rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, pairwise

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.geology.doubtful_stretches import MARGIN, MIN_POINTS, Range, offset
from vomstudio.geometry.planes import PlaneFit, fit_planes

CONTACT_QUANTILE = 0.25
"""Of the costs along a path: the level of its contact."""
MIN_PEAK = 0.1
"""A crossing costs this part of the way from the level of the contact to that of usual rock."""
MAX_PEAKS = 7
MAX_VERTICES = 500
MIN_VERTICES = 3
MIN_LENGTH = 4.0
"""Of a stretch, in resolutions of the model."""
MIN_RATIO = 1.3
"""Of the offset to what error and scatter allow, both 95 %. Of single contacts up to 2 % then
have a doubtful stretch, most of them where the path has in fact left (docs/plane_errors.md)."""


def find_jumps(
    points: FloatArray, costs: FloatArray, at: IntArray, resolution: float
) -> tuple[Range, ...]:
    """Find the stretches of a path that are beside the plane of the rest.

    Parameters
    ----------
    points : (n, 3) array
    costs : (n,) array
        Of a metre at each point, in medians of the surface around.
    at : (w,) array
        Rows of the way-points, rising.
    resolution : float
        Of the model, in the unit of the points.

    Returns
    -------
    First and last row of each stretch, in their order; at most one of each leg.
    """
    step = -(-len(points) // MAX_VERTICES)
    if step > 1:
        # Pixels of a photo: the means of several in a row.
        starts = np.arange(0, len(points), step)
        sizes = np.diff(np.append(starts, len(points)))
        means = np.add.reduceat(np.column_stack([points, costs]), starts, axis=0) / sizes[:, None]
        coarse = find_jumps(means[:, :3], means[:, 3], at // step, resolution)
        return tuple((a * step, min((b + 1) * step, len(points)) - 1) for a, b in coarse)
    legs = _candidates(points, costs, at, resolution)
    kept = np.ones(len(points), np.bool_)
    left_out: list[Range] = []
    while (best := _best(points, kept, legs)) is not None:
        leg, stretch = best
        left_out.append(stretch)
        kept[_rows(stretch)] = False
        legs[leg] = []
    while left_out:
        fit = _fits(points, [kept])[0]
        ratios = [0.0 if fit is None else _ratio(points, one, fit, resolution) for one in left_out]
        least = int(np.argmin(ratios))
        if ratios[least] >= MIN_RATIO:
            break
        kept[_rows(left_out.pop(least))] = True
        for stretch in left_out:
            kept[_rows(stretch)] = False
    return tuple(sorted(left_out))


def _rows(stretch: Range) -> slice:
    return slice(max(stretch[0] - MARGIN, 0), stretch[1] + 1 + MARGIN)


def _candidates(
    points: FloatArray, costs: FloatArray, at: IntArray, resolution: float
) -> list[list[Range]]:
    """Of each leg the stretches between any two of its crossings."""
    from scipy.ndimage import uniform_filter1d
    from scipy.signal import find_peaks

    level = float(np.quantile(costs, CONTACT_QUANTILE))
    least = level + MIN_PEAK * max(1.0 - level, 0.0)
    smooth = uniform_filter1d(costs, 3, mode="nearest")
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    legs = []
    for first, last in pairwise(at.tolist()):
        # A peak may be at the way-point itself.
        peaks, known = find_peaks(np.pad(smooth[first : last + 1], 1), height=least)
        highest = np.sort(peaks[np.argsort(known["peak_heights"])[-MAX_PEAKS:]]) + first - 1
        legs.append(
            [
                (a + 1, b - 1)
                for a, b in combinations(highest.tolist(), 2)
                if b - a > MIN_VERTICES and along[b - 1] - along[a + 1] >= MIN_LENGTH * resolution
            ]
        )
    return legs


def _best(
    points: FloatArray, kept: BoolArray, legs: Sequence[Sequence[Range]]
) -> tuple[int, Range] | None:
    """The leg and the stretch without which the other points lie best in one plane, the points of
    the stretch in a parallel one."""
    choices = [(leg, stretch) for leg, stretches in enumerate(legs) for stretch in stretches]
    masks = []
    for _, stretch in choices:
        mask = kept.copy()
        mask[_rows(stretch)] = False
        masks.append(mask)
    best, least = None, np.inf
    for choice, fit in zip(choices, _fits(points, masks), strict=True):
        if fit is None or fit.rms is None:
            continue
        (a, b) = choice[1]
        own = (points[a : b + 1] - fit.centroid) @ fit.normal
        total = fit.n * fit.rms**2 + float(((own - own.mean()) ** 2).sum())
        if (score := total / (fit.n + len(own))) < least:
            best, least = choice, score
    return best


def _fits(points: FloatArray, masks: Sequence[BoolArray]) -> list[PlaneFit | None]:
    """The plane of the points of each mask (n,); None where there are few, or they have none."""
    enough = [i for i, mask in enumerate(masks) if mask.sum() >= MIN_POINTS]
    fits: list[PlaneFit | None] = [None] * len(masks)
    if not enough:
        return fits
    groups = [points[masks[i]] for i in enough]
    batch = fit_planes(np.concatenate(groups), np.cumsum([0, *map(len, groups)]))
    for i, fit in zip(enough, batch.rows(), strict=True):
        fits[i] = None if fit.error is not None else fit
    return fits


def _ratio(points: FloatArray, stretch: Range, fit: PlaneFit, resolution: float) -> float:
    """How far a stretch is beside a plane, in multiples of what is to be expected."""
    if fit.max_confidence95_deg is None or fit.min_confidence95_deg is None or fit.rms is None:
        return 0.0
    middle = points[stretch[0] : stretch[1] + 1].mean(axis=0) - fit.centroid
    angles = np.radians(np.minimum([fit.min_confidence95_deg, fit.max_confidence95_deg], 89.9))
    lever = np.tan(angles) * (fit.axes[:2] @ middle)
    allowed = np.sqrt((lever**2).sum() + (2.0 * fit.rms) ** 2 + resolution**2)
    return abs(offset(points, stretch, fit)) / float(max(allowed, 1e-300))
