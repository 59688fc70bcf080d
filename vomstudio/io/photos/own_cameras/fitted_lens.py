"""Fit of a supported lens model to the lenses of other programs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry.cameras import Intrinsics

MAX_ERROR_PX = 0.5
"""Maximum error of a fitted lens in pixels; features are located to about this accuracy."""
_GRID_SIZE = 25
_MIN_POINTS = 50
"""Minimum number of points in the photo to which a lens is fitted."""


def fit_lens(
    width: int, height: int, focal: float, project: Callable[[FloatArray], FloatArray]
) -> tuple[Intrinsics, float]:
    """Fit a lens of the model FULL_OPENCV to a projection.

    Parameters
    ----------
    width, height : int
        Size of the photos in pixels.
    focal : float
        Approximate focal length in pixels.
    project : callable
        Function that converts ideal image coordinates (n, 2), x to the right and y down in units of
        the focal length, to pixels (n, 2).

    Returns
    -------
    lens : Intrinsics
    error_px : float
        Largest difference within the photo in pixels; infinite if no lens can be fitted.
    """
    from scipy.optimize import least_squares

    half_extent = np.array([width, height]) / focal / 2.0
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, _GRID_SIZE), np.linspace(-1.0, 1.0, _GRID_SIZE))
    # Distortion may move points beyond the ideal edge into the photo.
    ideal_points = 1.2 * half_extent * np.column_stack([x.ravel(), y.ravel()])
    distorted_pixels = project(ideal_points)
    is_inside = ((distorted_pixels >= 0.0) & (distorted_pixels <= (width, height))).all(axis=1)
    ideal_points, distorted_pixels = ideal_points[is_inside], distorted_pixels[is_inside]
    if len(ideal_points) < _MIN_POINTS:
        return Intrinsics.pinhole(width, height, focal, width / 2.0, height / 2.0), np.inf
    rays = np.column_stack([ideal_points, np.ones(len(ideal_points))])

    def build_lens(lens_parameters: FloatArray) -> Intrinsics:
        fx, fy, cx, cy = lens_parameters[:4] * focal
        params = (fx, fy, cx, cy, *lens_parameters[4:8], lens_parameters[8], 0.0, 0.0, 0.0)
        return Intrinsics("FULL_OPENCV", width, height, tuple(float(value) for value in params))

    def residuals(parameters: FloatArray) -> FloatArray:
        pixels = build_lens(parameters).project(rays)
        return np.nan_to_num(pixels - distorted_pixels, nan=float(width)).ravel()

    start = np.array([1.0, 1.0, width / 2 / focal, height / 2 / focal, *np.zeros(5)])
    solution = least_squares(residuals, start, x_scale="jac", method="lm")
    return build_lens(solution.x), float(np.abs(residuals(solution.x)).max())
