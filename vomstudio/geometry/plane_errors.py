"""Two error measures of the orientation of a fitted plane.

All functions are batched over m planes and use the normalised eigenvalues l1 >= l2 >= l3 of the
covariance of the points. Angles are the half-angles of an ellipse of normals around the fitted
normal: the largest is along e2 (the plane tilts about e1), and the smallest along e1.
"""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.geometry import residual_correlation
from vomstudio.geometry.vectors import strike_and_dip_lines

SIGNIFICANCE = 0.05


def joint_quantile(degrees_of_freedom: FloatArray) -> FloatArray:
    """Return 2 F / dof, where F is the 95 % quantile of Fisher's F distribution.

    The distribution has 2 and `degrees_of_freedom` degrees of freedom, for which the closed form is
    P(F > f) = (1 + 2 f / dof)^(-dof / 2).

    Parameters
    ----------
    degrees_of_freedom : (m,) ndarray

    Returns
    -------
    (m,) ndarray
    """
    with np.errstate(over="ignore"):
        return np.asarray(np.expm1(-2.0 / degrees_of_freedom * np.log(SIGNIFICANCE)))


def hyperbolic_errors_deg(
    n: IntArray, values: FloatArray
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Compute the largest and the smallest angular error of Quinn & Ehlmann (2019).

    If the hyperbola opens along the normal instead (h2 <= 0), the error is 90 degrees and
    `overflow` is set. Source: Earth and Space Science 6, doi 10.1029/2018EA000416.

    Parameters
    ----------
    n : (m,) ndarray of int
        Number of points, at least 4.
    values : (m, 3) ndarray
        Eigenvalues of the covariance, in any unit.

    Returns
    -------
    largest, smallest : (m,) ndarray
        Angular errors, degrees.
    overflow : (m,) ndarray of bool
    """
    scaled_variances = (
        values * (n / (n - 1.0))[:, None]
    )  # the source divides the covariance by n - 1
    dof = (n - 2.0).astype(np.float64)
    c = joint_quantile(dof) * np.sqrt(dof)
    l3 = scaled_variances[:, 2]
    h3 = l3 * (1.0 + c)
    result = []
    for i in (1, 0):
        h = scaled_variances[:, i] - c * np.sqrt(scaled_variances[:, i] * l3)
        positive_h = np.where(h > 0.0, h, 1.0)
        result.append(np.where(h > 0.0, np.degrees(np.arctan(np.sqrt(h3 / positive_h))), 90.0))
        if i == 1:
            is_overflow = h <= 0.0
    return result[0], result[1], is_overflow


def confidence_axes_rad(
    values: FloatArray, q1: FloatArray, q2: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Compute the semi-axes of the joint 95 % region of the normal.

    A normal m is rejected if the residuals of its plane correlate with the in-plane coordinates.
    The F test of that regression is (m'Cm)(m'C^-1 m) <= 1 + q. It is exact for white Gaussian
    noise, either normal to the plane or isotropic, for every n >= 4 and every shape. Its boundary
    crosses the principal directions at sin(2 t)^2 = 4 q l_i l3 / (l_i - l3)^2 (Creasy 1956, for a
    line). If this exceeds 1, no tilt can be rejected, and t is 90 degrees.

    Parameters
    ----------
    values : (m, 3) ndarray
        Eigenvalues of the covariance, descending.
    q1, q2 : (m,) ndarray
        Quantiles q along both principal directions.

    Returns
    -------
    largest, smallest : (m,) ndarray
        Semi-axes, radians.
    """
    axes = []
    l3 = values[:, 2]
    for i, q in ((1, q2), (0, q1)):
        gap = values[:, i] - l3
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            s = 2.0 * np.sqrt(q * values[:, i] * l3) / gap
        is_bounded = s < 1.0  # also false for NaN, which results from l3 = l_i
        axes.append(np.where(is_bounded, 0.5 * np.arcsin(np.where(is_bounded, s, 0.0)), np.pi / 2))
    return np.maximum(axes[0], axes[1]), axes[1]


def quantiles(
    u: FloatArray,
    v: FloatArray,
    r: FloatArray,
    starts: IntArray,
    counts: IntArray,
    degrees_of_freedom: FloatArray,
    is_ordered: bool,
) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
    """Compute the quantiles q along e1 and e2, allowing for correlated residuals of traces.

    Parameters
    ----------
    u, v, r : (N,) ndarray
        Coordinates of all points along e1, e2 and e3, group after group.
    starts, counts : (m,) ndarray of int
        First point and number of points of each group.
    degrees_of_freedom : (m,) ndarray
        Degrees of freedom of each group.
    is_ordered : bool
        Whether the points follow a trace.

    Returns
    -------
    q1, q2 : (m,) ndarray
        Quantiles along e1 and e2.
    effective : (m,) ndarray
        Effective number of points.
    long : (m,) ndarray of bool
        Whether the roughness is as long as the trace.
    """
    white_quantiles = joint_quantile(degrees_of_freedom)
    if not is_ordered:
        return (
            white_quantiles,
            white_quantiles.copy(),
            degrees_of_freedom + 3.0,
            np.zeros(len(degrees_of_freedom), bool),
        )
    return residual_correlation.inflate(
        u, v, r, starts, counts, degrees_of_freedom, white_quantiles
    )


def regression_axes_rad(
    leverage: FloatArray, normal: FloatArray, q: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Compute the axes and semi-axes of the confidence region of a regression.

    The ellipse of both slopes, which is exact for white noise along the coordinate, is projected
    onto the tangent plane to first order.

    Parameters
    ----------
    leverage : (m, 3, 3) ndarray
        Covariance of the tip of the normal per unit of q.
    normal : (m, 3) ndarray
    q : (m,) ndarray

    Returns
    -------
    e1, e2 : (m, 3) ndarray
        Directions of the smallest and of the largest semi-axis.
    largest, smallest : (m,) ndarray
        Semi-axes, radians.
    """
    values, vectors = np.linalg.eigh(leverage)
    # The variance along the normal itself is zero.
    tangent = np.sqrt(np.maximum(values[:, 1:], 0.0) * q[:, None])
    e2 = vectors[:, :, 2]
    return np.cross(e2, normal), e2, np.arctan(tangent[:, 1]), np.arctan(tangent[:, 0])


def component_errors_rad(
    e1: FloatArray,
    e2: FloatArray,
    dip_direction_deg: FloatArray,
    dip_deg: FloatArray,
    is_flat: BoolArray,
    major_rad: FloatArray,
    minor_rad: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Compute the errors of dip and dip direction, and the rake of the largest tilt.

    All results are in radians.

    The region is a cone of normals with an elliptical cross-section. In the tangent plane of the
    unit sphere at the fitted normal, it is an ellipse with semi-axes tan(`major_rad`) along e2 and
    tan(`minor_rad`) along e1. The dip error is the half-width of the cone along the dip. The error
    of the dip direction is the larger of the two azimuth differences at which a vertical plane
    touches the cone. For a small tilt a of the normal across the dip, it is a / sin(dip), or
    t / tan(dip)
    with the tilt t = a / cos(dip) of the strike line. If the ellipse contains the vertical, every
    dip direction is possible, and the error is NaN.

    Parameters
    ----------
    e1, e2 : (m, 3) ndarray
        Directions of the smallest and of the largest semi-axis.
    dip_direction_deg, dip_deg : (m,) ndarray
    is_flat : (m,) ndarray of bool
        Whether the plane has no dip direction.
    major_rad, minor_rad : (m,) ndarray
        Semi-axes, radians.

    Returns
    -------
    dip, dip_direction : (m,) ndarray
        Errors of the dip and of the dip direction.
    rake : (m,) ndarray
        Rake of the direction of the largest tilt.
    """
    strike, down = strike_and_dip_lines(dip_direction_deg, dip_deg)
    t1 = np.minimum(np.tan(minor_rad), 1e8)
    t2 = np.minimum(np.tan(major_rad), 1e8)
    a1, a2 = t1 * (e1 * down).sum(axis=1), t2 * (e2 * down).sum(axis=1)
    b1, b2 = t1 * (e1 * strike).sum(axis=1), t2 * (e2 * strike).sum(axis=1)
    square_along, square_across, cross_term = (
        a1 * a1 + a2 * a2,
        b1 * b1 + b2 * b2,
        a1 * b1 + a2 * b2,
    )
    dip_error = np.arctan(np.sqrt(square_along))

    # Consider the lines through the horizontal point of the tangent plane that touch the ellipse.
    # Their slope k is the tangent of the azimuth difference:
    # k^2 open + 2 k cos mixed - across = 0.
    dip = np.radians(dip_deg)
    cosine = np.cos(dip)
    quadratic_term = np.sin(dip) ** 2 - cosine**2 * square_along
    is_bounded = (quadratic_term > 0.0) & ~is_flat
    divisors = np.where(is_bounded, quadratic_term, 1.0)
    root = np.sqrt(np.maximum((cosine * cross_term) ** 2 + divisors * square_across, 0.0))
    slope = (np.abs(cosine * cross_term) + root) / divisors
    azimuth_error = np.where(is_bounded, np.arctan(slope), np.nan)

    rake = np.arctan2((e2 * down).sum(axis=1), (e2 * strike).sum(axis=1)) % np.pi
    rake = np.where(rake >= np.pi, 0.0, rake)
    return dip_error, azimuth_error, rake


MAX_BOW_OVER_EXTENT = 0.001
"""Ratio of sagitta to length of the bow of a trace that is assumed possible unless the points of
the trace exclude it. This is our own choice, from tests/benchmarks/bench_conditional.py.
"""
# 97.5 % quantile of Student's t distribution, tabulated over the inverse degrees of freedom.
INVERSE_DEGREES_OF_FREEDOM = np.array([0.0, 1 / 30, 1 / 8, 1 / 4, 1 / 3, 1 / 2, 1.0])
STUDENT_QUANTILES = np.array([1.960, 2.042, 2.306, 2.776, 3.182, 4.303, 12.706])


def bow_tilt_rad(
    coordinates: tuple[FloatArray, FloatArray, FloatArray],
    starts: IntArray,
    counts: IntArray,
    values: FloatArray,
) -> FloatArray:
    """Compute the 95 % limit of the tilt of each plane caused by a bow of its trace.

    A bow is a parabola along e1. If the trace itself curves in this way, the fit mistakes the bow
    for a tilt without residuals. The other points give an upper bound. Angles are in radians.

    Parameters
    ----------
    coordinates : three (N,) ndarray
        Coordinates of the points along e1, e2 and e3, group after group, relative to their mean.
    starts, counts : (m,) ndarray of int
        First point and number of points of each group.
    values : (m, 3) ndarray
        Variances along the axes, in squared units of the coordinates.
    """
    u, v, r = coordinates
    n = counts.astype(np.float64)

    def total(x: FloatArray) -> FloatArray:
        return np.asarray(np.add.reduceat(x, starts))

    low, high = np.minimum.reduceat(u, starts), np.maximum.reduceat(u, starts)
    length = np.where(high > low, high - low, 1.0)
    s = (u - np.repeat(low, counts)) / np.repeat(length, counts)
    bow_shape = 4.0 * s * (1.0 - s)
    bow_shape -= np.repeat(total(bow_shape) / n, counts)
    # Groups without a plane have zero variances.
    with np.errstate(all="ignore"):
        first_mean, second_mean = (
            total(bow_shape * u) / (n * values[:, 0]),
            total(bow_shape * v) / (n * values[:, 1]),
        )
        first_mean, second_mean = (
            np.nan_to_num(x, posinf=0.0, neginf=0.0) for x in (first_mean, second_mean)
        )
        bow_squares = total(bow_shape * bow_shape) - n * (
            first_mean**2 * values[:, 0] + second_mean**2 * values[:, 1]
        )
        fitted_bow = total(bow_shape * r) / bow_squares
        residual_squares = np.maximum(n * values[:, 2] - fitted_bow**2 * bow_squares, 0.0)
        dof = np.maximum(n - 4.0, 1.0)
        student_quantile = np.interp(1.0 / dof, INVERSE_DEGREES_OF_FREEDOM, STUDENT_QUANTILES)
        max_bow = np.abs(fitted_bow) + student_quantile * np.sqrt(
            residual_squares / dof / bow_squares
        )
    bow_size = MAX_BOW_OVER_EXTENT * length
    is_determined = (counts > 4) & (bow_squares > 1e-6 * n)
    bow_size = np.where(is_determined, np.fmin(bow_size, max_bow), bow_size)
    # Points that lie exactly in a plane were computed, not measured.
    bow_size = np.where(values[:, 2] == 0.0, 0.0, bow_size)
    return np.asarray(np.arctan(bow_size * np.hypot(first_mean, second_mean)))
