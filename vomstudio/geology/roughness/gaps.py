"""Variance that is missing from a height map between its points.

A surface that is interpolated between points is smoother than the rock. The missing variance is
estimated from held-out points, by their distances from the surface through the other points
(cross-validation, as in geostatistics). At all distances longer than the gaps, the second
differences of the map lack 1 + 4 + 1 = six times this variance. Without a correction, they
therefore increase too fast with distance, and the exponent is too large.
"""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray

HOLDOUT_STEP = 10
"""One in this number of points is held out, so that the gaps of the others remain similar."""
MAX_POINTS = 100_000
MIN_POINTS = 200
NOISE_VARIANCE_RATIO = 1.5
"""Noise variance of a distance (point and interpolated surface), relative to that of a point."""


def missing_variance(plane_coordinates: FloatArray, heights: FloatArray, noise: float) -> float:
    """Estimate the height variance that is missing from a surface interpolated between points.

    Parameters
    ----------
    plane_coordinates : (n, 2) ndarray
        Positions in the plane, m.
    heights : (n,) ndarray
        Heights above the plane, m.
    noise : float
        Standard deviation of the noise of the model, m.

    Returns
    -------
    float
        Variance in m2; 0 if there are too few points.
    """
    from scipy.interpolate import LinearNDInterpolator
    from scipy.spatial import QhullError

    if len(plane_coordinates) > MAX_POINTS:
        # Use a part of the surface at the full point density.
        squared_distances = ((plane_coordinates - np.median(plane_coordinates, axis=0)) ** 2).sum(
            axis=1
        )
        nearest_points = np.argpartition(squared_distances, MAX_POINTS)[:MAX_POINTS]
        plane_coordinates, heights = plane_coordinates[nearest_points], heights[nearest_points]
    is_held_out = np.zeros(len(plane_coordinates), np.bool_)
    is_held_out[
        np.random.default_rng(0).permutation(len(plane_coordinates))[
            : len(plane_coordinates) // HOLDOUT_STEP
        ]
    ] = True
    if is_held_out.sum() < MIN_POINTS:
        return 0.0
    try:
        interpolated = LinearNDInterpolator(plane_coordinates[~is_held_out], heights[~is_held_out])(
            plane_coordinates[is_held_out]
        )
    except QhullError:
        return 0.0
    residuals = (heights[is_held_out] - interpolated)[np.isfinite(interpolated)]
    if len(residuals) < MIN_POINTS:
        return 0.0
    # Exclude outliers at the boundary or at a step.
    is_used = np.abs(residuals) <= 6.0 * float(np.median(np.abs(residuals)))
    return max(float(np.mean(residuals[is_used] ** 2)) - NOISE_VARIANCE_RATIO * noise**2, 0.0)
