"""Figures of many fitted planes at once, as defined in `geometry.planes`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from vomstudio.core.arrays import AnyArray, BoolArray, FloatArray, IntArray
from vomstudio.core.findings import Finding
from vomstudio.geometry import plane_errors
from vomstudio.geometry.plane_limits import (
    MAX_COORDINATE,
    MAX_POINTS_COUNTING_REPEATS,
    MIN_EXTENT_ROUNDINGS,
    degenerate_points_finding,
)
from vomstudio.geometry.vectors import MIN_TILT, dips_from_normals, flip_upward

Method = Literal["pca", "regression"]


def figures(
    xyz: FloatArray, counts: IntArray, method: Method, axis: int, is_ordered: bool
) -> tuple[dict[str, AnyArray], list[Finding | None]]:
    """Compute the figures of groups with at least 3 points each.

    Parameters
    ----------
    xyz : (n, 3) ndarray
        Points, group after group.
    counts : (m,) ndarray of int
        Number of points of each group.
    method : Method
    axis : int
        Index of the coordinate that a regression minimises.
    is_ordered : bool
        Whether the points of each group follow a trace.

    Returns
    -------
    figures : dict
        Arrays, keyed by the attribute names of `PlaneFits`.
    reasons : list of Finding or None
        Reason why the plane of each group is missing, or None.
    """
    m = len(counts)
    starts = np.cumsum(counts) - counts
    n = counts.astype(np.float64)
    local_points, scale = _centre_and_scale(xyz, starts, counts, n)
    unit, rounding = scale.unit, scale.rounding

    covariance = np.empty((m, 3, 3))
    for i in range(3):
        for j in range(i, 3):
            product = np.add.reduceat(local_points[i] * local_points[j], starts) / n
            covariance[:, i, j] = covariance[:, j, i] = product
    axes = np.linalg.eigh(covariance)[1].transpose(0, 2, 1)[:, ::-1]  # rows, descending
    axes, (u, v, r), values = _refine_axes(axes, local_points, starts, counts, n)

    low, high = np.minimum.reduceat(u, starts), np.maximum.reduceat(u, starts)
    values[:, 2] = np.where(np.sqrt(values[:, 2]) <= rounding, 0.0, values[:, 2])
    errors: list[Finding | None] = [None] * m
    is_identical = (np.sqrt(values[:, 0]) <= rounding) | (scale.size <= 1.0 / MAX_COORDINATE)
    is_collinear = ~is_identical & (np.sqrt(values[:, 1]) <= rounding)
    for i in np.flatnonzero(is_identical | is_collinear).tolist():
        errors[i] = degenerate_points_finding(int(counts[i]), is_coincident=bool(is_identical[i]))

    trace = values.sum(axis=1)
    trace = np.where(trace > 0.0, trace, 1.0)
    axes = axes.copy()
    axes[:, 2] = flip_upward(axes[:, 2])
    normal = axes[:, 2]
    rms = np.sqrt(values[:, 2])
    residual = rms
    leverage = None
    if method == "regression":
        normal, residual, is_parallel, leverage = _fit_regressions(covariance, axis, rounding)
        is_parallel |= _is_parallel_within_scatter(axes[:, 2, axis], values)
        rms = residual * np.abs(normal[:, axis])
        for i in np.flatnonzero(is_parallel & ~is_identical & ~is_collinear).tolist():
            errors[i] = Finding("plane.parallel-to-axis", axis="xyz"[axis])

    with np.errstate(divide="ignore", invalid="ignore"):
        min_tilt = np.maximum(MIN_TILT, rounding / np.sqrt(values[:, 1]))
        min_tilt = np.where(np.isfinite(min_tilt), np.minimum(min_tilt, 1e-3), MIN_TILT)
    dip_direction, dip, is_horizontal = dips_from_normals(normal, min_tilt)
    error_figures = _errors(
        (u, v, r),
        starts,
        counts,
        values,
        axes,
        (normal, dip_direction, dip, is_horizontal),
        _count_distinct(xyz, starts, counts),
        is_ordered,
        None if leverage is None else leverage * (residual**2)[:, None, None],
    )
    bow_tilt_rad = (
        plane_errors.bow_tilt_rad((u, v, r), starts, counts, values) if is_ordered else 0.0
    )
    return {
        "centroid": scale.centroid,
        "normal": normal,
        "eigenvalues": values / trace[:, None],
        "axes": axes,
        "trace": trace * unit**2,
        "rms": rms * unit,
        "residual": residual * unit,
        "extent": (high - low) * unit,
        "bow_tilt_deg": np.degrees(bow_tilt_rad)
        * np.where(np.isnan(error_figures["n_effective"]), np.nan, 1.0),
        "max_coordinate": scale.max_coordinate,
        **_shape_indices(values.T / trace),
        "dip_direction_deg": dip_direction,
        "dip_deg": dip,
        "undefined": is_horizontal,
        **error_figures,
    }, errors


@dataclass(frozen=True, eq=False)
class _GroupScale:
    """Scale of the coordinates of each group.

    Attributes
    ----------
    centroid : (m, 3) ndarray
    size : (m,) ndarray
    unit : (m,) ndarray
        Divisor of the coordinates.
    max_coordinate : (m,) ndarray
    rounding : (m,) ndarray
        Rounding error of the coordinates, in multiples of `unit`.
    """

    centroid: FloatArray
    size: FloatArray
    unit: FloatArray
    max_coordinate: FloatArray
    rounding: FloatArray


def _centre_and_scale(
    xyz: FloatArray, starts: IntArray, counts: IntArray, n: FloatArray
) -> tuple[list[FloatArray], _GroupScale]:
    """Return x, y and z relative to the centroid of each group, divided by its size."""

    def spread(x: FloatArray) -> FloatArray:
        return np.repeat(x, counts)

    # Subtract the first point first: this difference is exact or nearly so, and the mean of the
    # differences is small.
    first_points = xyz[starts]
    local_points = [xyz[:, i] - spread(first_points[:, i]) for i in range(3)]
    mean = [np.add.reduceat(x, starts) / n for x in local_points]
    local_points = [x - spread(c) for x, c in zip(local_points, mean, strict=True)]
    centroid = first_points + np.stack(mean, axis=1)
    max_coordinate = np.maximum.reduceat(np.abs(xyz).max(axis=1), starts)

    # Divide by a common length, so that squares of tiny and huge coordinates do not overflow.
    size = np.maximum.reduceat(np.maximum.reduce([np.abs(x) for x in local_points]), starts)
    unit = np.where(size > 1.0 / MAX_COORDINATE, size, 1.0)
    inverse_units = spread(1.0 / unit)
    local_points = [x * inverse_units for x in local_points]
    rounding = MIN_EXTENT_ROUNDINGS * np.finfo(np.float64).eps * max_coordinate / unit
    return local_points, _GroupScale(centroid, size, unit, max_coordinate, rounding)


def _shape_indices(parts: FloatArray) -> dict[str, FloatArray]:
    """Compute the shape indices from the normalised eigenvalues (3, m)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        l1, l2, l3 = parts
        collinearity = l1 / l2
        return {
            "coplanarity": 1.0 / l3,
            "collinearity": collinearity,
            "M": np.log(l1 / l3),
            "K": np.log(collinearity) / np.log(l2 / l3),
        }


def members(starts: IntArray, counts: IntArray) -> IntArray:
    """Return the indices of all points of groups, group after group.

    Parameters
    ----------
    starts, counts : (m,) ndarray of int
        First point and number of points of each group.

    Returns
    -------
    (n,) ndarray of int
    """
    shift = np.repeat(starts - (np.cumsum(counts) - counts), counts)
    return np.asarray(np.arange(len(shift)) + shift)


def _refine_axes(
    axes: FloatArray,
    local_points: list[FloatArray],
    starts: IntArray,
    counts: IntArray,
    n: FloatArray,
) -> tuple[FloatArray, tuple[FloatArray, FloatArray, FloatArray], FloatArray]:
    """Return axes, coordinates and variances, free of the rounding errors of the covariance.

    The covariance resolves the thickness of a long straight trace only to 1e-8 of its length.
    Therefore e2 and e3 are separated a second time, in the frame of the eigenvectors.
    """
    frame = axes
    u, v, r = _coordinates_along(frame, local_points, counts)
    b22 = np.add.reduceat(v * v, starts) / n
    b33 = np.add.reduceat(r * r, starts) / n
    b23 = np.add.reduceat(v * r, starts) / n
    angle = 0.5 * np.arctan2(2.0 * b23, b22 - b33)
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    frame = np.stack(
        [frame[:, 0], c * frame[:, 1] + s * frame[:, 2], c * frame[:, 2] - s * frame[:, 1]], axis=1
    )
    u, v, r = _coordinates_along(frame, local_points, counts)
    values = np.stack([np.add.reduceat(x * x, starts) / n for x in (u, v, r)], axis=1)
    return frame, (u, v, r), values


def _coordinates_along(
    frame: FloatArray, local_points: list[FloatArray], counts: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    def component(k: int) -> FloatArray:
        return sum(
            (np.repeat(frame[:, k, i], counts) * local_points[i] for i in range(1, 3)),
            start=np.repeat(frame[:, k, 0], counts) * local_points[0],
        )

    return component(0), component(1), component(2)


def _count_distinct(xyz: FloatArray, starts: IntArray, counts: IntArray) -> IntArray:
    """Count the distinct points of each group; repeated clicks are not independent."""
    distinct_counts = counts.copy()
    has_few_points = counts <= MAX_POINTS_COUNTING_REPEATS
    if not has_few_points.any():
        return distinct_counts
    group = np.repeat(np.flatnonzero(has_few_points), counts[has_few_points])
    group_points = xyz[members(starts[has_few_points], counts[has_few_points])]
    order = np.lexsort((group_points[:, 2], group_points[:, 1], group_points[:, 0], group))
    is_equal = (np.diff(group_points[order], axis=0) == 0.0).all(axis=1) & (
        np.diff(group[order]) == 0
    )
    np.subtract.at(distinct_counts, group[order][1:][is_equal], 1)
    return distinct_counts


MAX_SCATTER_RATIO = 3.0
MAX_SINE = 0.5
"""Maximum sine of the angle between the axis and a plane that is treated as parallel to it. This is
our own choice: a regression overestimates the angle between its axis and the plane by about a tenth
if the points scatter by a third of that angle. Planes at more than 30 degrees to the axis are never
treated as parallel, regardless of their scatter.
"""


def _is_parallel_within_scatter(sine: FloatArray, values: FloatArray) -> BoolArray:
    """Return whether the scatter of the points explains the angle of the plane to the axis.

    `sine` (m,) is the sine of the angle; `values` (m, 3) are the variances.
    """
    scatter = MAX_SCATTER_RATIO * np.sqrt(values[:, 2])
    return (np.abs(sine) < MAX_SINE) & (np.abs(sine) * np.sqrt(values[:, 1]) < scatter)


def _fit_regressions(
    covariance: FloatArray, axis: int, rounding: FloatArray
) -> tuple[FloatArray, FloatArray, BoolArray, FloatArray]:
    """Fit regressions that minimise the residuals of one coordinate.

    Return the upward normals, the residuals, whether the plane is parallel to the axis, and the
    covariance (m, 3, 3) of the tip of the normal for residuals of variance n.
    """
    a, b = (i for i in range(3) if i != axis)
    saa, sbb, sab = covariance[:, a, a], covariance[:, b, b], covariance[:, a, b]
    sac, sbc = covariance[:, a, axis], covariance[:, b, axis]
    determinant = saa * sbb - sab * sab
    # Smaller spread of the two other coordinates, which is zero for a plane parallel to the axis.
    slope_variance = determinant / np.maximum(saa + sbb, np.finfo(np.float64).tiny)
    is_parallel = np.sqrt(np.maximum(slope_variance, 0.0)) <= np.maximum(rounding, 1e-7)
    divisors = np.where(is_parallel, 1.0, determinant)
    pa = (sbb * sac - sab * sbc) / divisors
    pb = (saa * sbc - sab * sac) / divisors
    normal = np.empty((len(pa), 3))
    normal[:, a], normal[:, b], normal[:, axis] = -pa, -pb, 1.0
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    square = covariance[:, axis, axis] - pa * sac - pb * sbc
    # Inverse covariance (S^-1) of the slopes, propagated to the normal, whose component ratios are
    # the slopes.
    inverse = np.zeros((len(pa), 3, 3))
    inverse[:, a, a], inverse[:, b, b] = sbb / divisors, saa / divisors
    inverse[:, a, b] = inverse[:, b, a] = -sab / divisors
    projector = np.eye(3) - normal[:, :, None] * normal[:, None, :]
    leverage = projector @ inverse @ projector * (normal[:, axis] ** 2)[:, None, None]
    return flip_upward(normal), np.sqrt(np.maximum(square, 0.0)), is_parallel, leverage


def _errors(
    coordinates: tuple[FloatArray, FloatArray, FloatArray],
    starts: IntArray,
    counts: IntArray,
    values: FloatArray,
    axes: FloatArray,
    attitude: tuple[FloatArray, FloatArray, FloatArray, BoolArray],
    distinct_counts: IntArray,
    is_ordered: bool,
    regression_leverage: FloatArray | None,
) -> dict[str, AnyArray]:
    """Compute both angular errors and their components, NaN below 4 distinct points.

    `coordinates` contains the coordinates along the axes. `attitude` contains the normal, the
    dip direction, the dip and whether the plane is horizontal.
    """
    normal, dip_direction, dip, is_horizontal = attitude
    is_known = distinct_counts > 3
    n = np.where(is_known, counts, 4)
    dof = np.where(is_known, distinct_counts - 3.0, 1.0)
    q1, q2, n_effective, is_long = plane_errors.quantiles(
        *coordinates, starts, counts, dof, is_ordered
    )
    # Residuals of points that lie exactly in a plane are rounding errors, not roughness.
    is_exact = values[:, 2] == 0.0
    n_effective, is_long = np.where(is_exact, dof + 3.0, n_effective), is_long & ~is_exact
    max_error_deg, min_error_deg, overflow = plane_errors.hyperbolic_errors_deg(n, values)
    if regression_leverage is None:
        e1, e2 = axes[:, 0], axes[:, 1]
        major_rad, minor_rad = plane_errors.confidence_axes_rad(values, q1, q2)
    else:
        e1, e2, major_rad, minor_rad = plane_errors.regression_axes_rad(
            regression_leverage, normal, np.maximum(q1, q2)
        )
    dip_error, azimuth_error, rake = plane_errors.component_errors_rad(
        e1, e2, dip_direction, dip, is_horizontal, major_rad, minor_rad
    )
    nan_factors = np.where(is_known, 1.0, np.nan)
    return {
        "max_angular_error_deg": max_error_deg * nan_factors,
        "min_angular_error_deg": min_error_deg * nan_factors,
        "hyperbolic_overflow": overflow & is_known,
        "max_confidence95_deg": np.degrees(major_rad) * nan_factors,
        "min_confidence95_deg": np.degrees(minor_rad) * nan_factors,
        "error_rake_deg": np.degrees(rake) * nan_factors,
        "dip_error_deg": np.degrees(dip_error) * nan_factors,
        "dip_direction_error_deg": np.degrees(azimuth_error) * nan_factors,
        "n_effective": n_effective * nan_factors,
        "long_roughness": is_long & is_known,
    }
