"""What a map of heights lacks between the points that it was made from.

A surface that is drawn straight from point to point is smoother than the rock between them. What is
lacking is told by points that are left out: their distance from what is drawn through the others
(cross-validation, as in geostatistics). Second differences of the map lack six times its variance,
1 + 4 + 1, at all distances longer than the gaps, so that they grow too fast and the exponent comes
out too large where that is not put back.
"""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray

_OUT = 10
"""One in so many points is left out, so that the others are hardly farther apart."""
_MOST = 100_000
_FEWEST = 200
_NOISE = 1.5
"""Variance of noise in such a distance: the point's own, and that of the means around it."""


def lacking(flat: FloatArray, heights: FloatArray, noise: float) -> float:
    """Variance of the heights that a surface drawn between points lacks, m2.

    flat : (n, 2) places in the plane, m; heights : (n,) over it; noise : standard deviation of the
    heights that is the model's own. 0 where points are too few to tell.
    """
    from scipy.interpolate import LinearNDInterpolator
    from scipy.spatial import QhullError

    if len(flat) > _MOST:
        # A part of the surface, as densely covered as the whole.
        away = ((flat - np.median(flat, axis=0)) ** 2).sum(axis=1)
        near = np.argpartition(away, _MOST)[:_MOST]
        flat, heights = flat[near], heights[near]
    out = np.zeros(len(flat), np.bool_)
    out[np.random.default_rng(0).permutation(len(flat))[: len(flat) // _OUT]] = True
    if out.sum() < _FEWEST:
        return 0.0
    try:
        drawn = LinearNDInterpolator(flat[~out], heights[~out])(flat[out])
    except QhullError:
        return 0.0
    off = (heights[out] - drawn)[np.isfinite(drawn)]
    if len(off) < _FEWEST:
        return 0.0
    # Without what lies at the border, or on a step.
    cut = np.abs(off) <= 6.0 * float(np.median(np.abs(off)))
    return max(float(np.mean(off[cut] ** 2)) - _NOISE * noise**2, 0.0)
