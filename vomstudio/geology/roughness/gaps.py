"""Variance that a map of heights lacks between its points.

A surface interpolated between points is smoother than the rock. The missing variance follows from
points that are held out: their distance from the surface through the others (cross-validation, as
in geostatistics). Second differences of the map lack 1 + 4 + 1 = six times this variance at all
distances longer than the gaps, so that they grow too fast and the exponent is too large without a
correction.
"""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray

HOLDOUT_STEP = 10
"""One in this number of points is held out, so that the gaps of the others remain similar."""
MAX_POINTS = 100_000
MIN_POINTS = 200
NOISE_VARIANCE_RATIO = 1.5
"""Variance of noise in such a distance: that of the point and that of the means around it."""


def missing_variance(flat: FloatArray, heights: FloatArray, noise: float) -> float:
    """Estimate the variance of heights that a surface interpolated between points lacks.

    Parameters
    ----------
    flat : (n, 2) ndarray
        Positions in the plane, m.
    heights : (n,) ndarray
        Heights over the plane, m.
    noise : float
        Standard deviation of the model's noise, m.

    Returns
    -------
    float
        Variance, m2; 0 for too few points.
    """
    from scipy.interpolate import LinearNDInterpolator
    from scipy.spatial import QhullError

    if len(flat) > MAX_POINTS:
        # A part of the surface with the full density of points.
        squared_distances = ((flat - np.median(flat, axis=0)) ** 2).sum(axis=1)
        nearest = np.argpartition(squared_distances, MAX_POINTS)[:MAX_POINTS]
        flat, heights = flat[nearest], heights[nearest]
    is_held_out = np.zeros(len(flat), np.bool_)
    is_held_out[np.random.default_rng(0).permutation(len(flat))[: len(flat) // HOLDOUT_STEP]] = True
    if is_held_out.sum() < MIN_POINTS:
        return 0.0
    try:
        interpolated = LinearNDInterpolator(flat[~is_held_out], heights[~is_held_out])(
            flat[is_held_out]
        )
    except QhullError:
        return 0.0
    residuals = (heights[is_held_out] - interpolated)[np.isfinite(interpolated)]
    if len(residuals) < MIN_POINTS:
        return 0.0
    # Exclude outliers at the border or at a step.
    is_used = np.abs(residuals) <= 6.0 * float(np.median(np.abs(residuals)))
    return max(float(np.mean(residuals[is_used] ** 2)) - NOISE_VARIANCE_RATIO * noise**2, 0.0)
