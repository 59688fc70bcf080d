"""Plane of a patch from the moments of its points."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geometry import plane_errors
from vomstudio.geometry.plane_limits import (
    MAX_COORDINATE,
    MIN_EXTENT_ROUNDINGS,
    degenerate_points_finding,
    too_few_points_finding,
)
from vomstudio.geometry.planes import FittedPlane
from vomstudio.geometry.vectors import MIN_TILT, dips_from_normals, flip_upward


def fit_moments(
    n: int, mean: npt.ArrayLike, scatter: npt.ArrayLike, n_effective: float | None = None
) -> FittedPlane:
    """Fit the moment-of-inertia plane of points, given their moments.

    The figures equal the results of `fit_plane(points, is_ordered=False)` except for rounding: the
    thickness of a patch is known to 1e-8 of its width. The `extent` is the diameter of the disc
    with the same spread.

    Parameters
    ----------
    n : int
        Number of distinct points.
    mean : (3,) array_like
        Mean of the points in the World frame, m.
    scatter : (3, 3) array_like
        Scatter about the mean, m2.
    n_effective : float, optional
        Number of independent points for the confidence region (see geometry/patches.py); by default
        `n`.

    Returns
    -------
    FittedPlane

    Raises
    ------
    GeometryError
        If the points do not determine a plane.
    """
    centroid = np.asarray(mean, dtype=np.float64)
    matrix = np.asarray(scatter, dtype=np.float64)
    if n < 3:
        raise GeometryError(too_few_points_finding(n))
    if not (np.isfinite(matrix).all() and (np.abs(centroid) < MAX_COORDINATE).all()):
        raise GeometryError(Finding("points.not-finite"))
    matrix = matrix / n
    size = float(np.trace(matrix))
    rounding = (
        MIN_EXTENT_ROUNDINGS * float(np.finfo(np.float64).eps) * float(np.abs(centroid).max())
    )
    if size <= max(rounding**2, np.finfo(np.float64).tiny):
        raise GeometryError(degenerate_points_finding(n, is_coincident=True))
    values, vectors = np.linalg.eigh(matrix / size)
    values, axes = np.maximum(values[::-1], 0.0), vectors.T[::-1].copy()
    rounding_error = 64.0 * float(np.finfo(np.float64).eps)
    if values[1] <= max(rounding_error, (rounding**2) / size):
        raise GeometryError(degenerate_points_finding(n, is_coincident=False))
    values = np.where(values <= rounding_error, 0.0, values)
    values /= values.sum()
    axes[2] = flip_upward(axes[None, 2])[0]
    min_tilt = max(MIN_TILT, rounding / float(np.sqrt(size * values[1])))
    azimuth, dip, is_horizontal = dips_from_normals(axes[None, 2], np.array([min(min_tilt, 1e-3)]))

    is_known = n > 3
    rows = values[None]
    dof = max(min(float(n_effective or n), float(n)) - 3.0, 1.0)
    q = plane_errors.joint_quantile(np.array([dof]))
    max_error_deg, min_error_deg, is_overflow = plane_errors.hyperbolic_errors_deg(
        np.array([max(n, 4)]), rows
    )
    major_rad, minor_rad = plane_errors.confidence_axes_rad(rows, q, q)
    dip_error, azimuth_error, rake = plane_errors.component_errors_rad(
        axes[None, 0], axes[None, 1], azimuth, dip, is_horizontal, major_rad, minor_rad
    )
    l1, l2, l3 = (float(x) for x in values)
    return FittedPlane(
        n=n,
        centroid=centroid,
        normal=axes[2],
        eigenvalues=values,
        axes=axes,
        trace=size,
        rms=float(np.sqrt(l3 * size)),
        residual=float(np.sqrt(l3 * size)),
        # A uniform disc of radius R has a variance of R^2 / 4 along each diameter.
        extent=4.0 * float(np.sqrt(size * np.sqrt(l1 * l2))),
        max_coordinate=float(np.abs(centroid).max()),
        coplanarity=1.0 / l3 if l3 > 0.0 else None,
        collinearity=l1 / l2,
        M=float(np.log(l1 / l3)) if l3 > 0.0 else None,
        K=float(np.log(l1 / l2) / np.log(l2 / l3)) if l3 > 0.0 and l2 > l3 else None,
        max_angular_error_deg=_value_if_known(max_error_deg, is_known),
        min_angular_error_deg=_value_if_known(min_error_deg, is_known),
        hyperbolic_overflow=bool(is_overflow[0]) and is_known,
        max_confidence95_deg=_value_if_known(np.degrees(major_rad), is_known),
        min_confidence95_deg=_value_if_known(np.degrees(minor_rad), is_known),
        error_rake_deg=_value_if_known(np.degrees(rake), is_known),
        dip_error_deg=_value_if_known(np.degrees(dip_error), is_known),
        dip_direction_error_deg=_value_if_known(np.degrees(azimuth_error), is_known),
        n_effective=dof + 3.0 if is_known else None,
        long_roughness=False,
        bow_tilt_deg=0.0 if is_known else None,
        dip_direction_deg=float(azimuth[0]),
        dip_deg=float(dip[0]),
        undefined=bool(is_horizontal[0]),
        error=None,
        method="pca",
        ordered=False,
    )


def _value_if_known(value: FloatArray, is_known: bool) -> float | None:
    return float(value[0]) if is_known and np.isfinite(value[0]) else None
