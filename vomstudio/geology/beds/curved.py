"""Fit of one curved bed: a smooth surface through several traces, with local dips.

The trend surface describes heights above a mean plane as a polynomial of the position in this plane
(Krumbein 1959, Journal of Geophysical Research 64, 823-834; Davis 2002, Statistics and Data
Analysis in Geology, chapter 5). The degree is increased as long as an F test shows that higher
degrees explain more than chance. The correlation of neighbours on a trace reduces the effective
number of points (Bayley & Hammersley 1946, Supplement to the Journal of the Royal Statistical
Society 8, 184-197). The local dip is that of the tangent plane. Its error is the larger of the
regression error and the change in dip that the next degrees would cause. The surface is
interpolated between the traces, but not extrapolated beyond them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geometry.plane_errors import joint_quantile
from vomstudio.geometry.vectors import dips_from_normals

MAX_DEGREE = 4
SIGNIFICANCE = 0.05
MIN_EXCESS_POINTS = 3.0
"""Minimum number of independent points in excess of the unknowns of a degree."""
MIN_SINGULAR_RATIO = 1e-4
"""Minimum ratio of the smallest to the largest singular value to determine a polynomial."""


@dataclass(frozen=True)
class LocalDip:
    """Local dip of a curved bed at one of its traces.

    Attributes
    ----------
    id : str
        Id of the trace.
    x, y, z : float
        Point of the surface at the middle of the trace, in the World frame, m.
    dip_direction_deg, dip_deg : float
        Attitude of the tangent plane, degrees.
    error95_deg : float
        Larger half-angle of the joint 95 % region of the normal, degrees.
    """

    id: str
    x: float
    y: float
    z: float
    dip_direction_deg: float
    dip_deg: float
    error95_deg: float


@dataclass(frozen=True, eq=False)
class CurvedBed:
    """Surface fitted to the traces of one bed.

    Attributes
    ----------
    degree : int
        Degree of the polynomial; 1 is a plane.
    p : float or None
        p-value for the hypothesis that the bed is a plane; None if a plane was fitted.
    rms_m : float
        RMS distance of the points from the surface along the normal of the mean plane, m.
    n, n_effective : int, float
        Number of points, and effective number of independent points.
    dips : tuple of LocalDip
        Local dips at the middle of each trace.
    local_dips : (n, 3) ndarray
        Dip direction, dip and 95 % error at each point in degrees, in input order.
    """

    degree: int
    p: float | None
    rms_m: float
    n: int
    n_effective: float
    dips: tuple[LocalDip, ...]
    local_dips: FloatArray


@dataclass(frozen=True, eq=False)
class _PolynomialFit:
    """Least-squares fit; `shape` (k, k) is the covariance divided by the variance."""

    coefficients: FloatArray
    shape: FloatArray
    squares: float
    residuals: FloatArray
    variance_inflation: float


def curved_bed(ids: Sequence[str], points: npt.ArrayLike, offsets: npt.ArrayLike) -> CurvedBed:
    """Fit a smooth surface to the traces of one bed.

    Parameters
    ----------
    ids : sequence of str
        Ids of the g traces.
    points : (n, 3) array_like
        Points in order along each trace, in the World frame, m.
    offsets : (g + 1,) array_like of int
        Trace i is ``points[offsets[i]:offsets[i + 1]]``.

    Returns
    -------
    CurvedBed

    Raises
    ------
    GeometryError
        If the points do not determine a plane, or if they leave no degrees of freedom.
    """
    xyz = np.asarray(points, np.float64).reshape(-1, 3)
    trace_offsets = np.asarray(offsets, np.int64)
    centre = xyz.mean(axis=0)
    values, axes = np.linalg.eigh((xyz - centre).T @ (xyz - centre))
    if len(xyz) < 6 or not values[1] > 1e-8 * values[2]:
        raise GeometryError(Finding("beds.no-surface"))
    frame = axes[:, ::-1].T
    frame[2] = frame[2] if frame[2, 2] >= 0 else -frame[2]
    frame[1] = np.cross(frame[2], frame[0])
    u, v, w = ((xyz - centre) @ frame.T).T
    size = float(max(np.abs(u).max(), np.abs(v).max()))
    fits = _fit_polynomials(u / size, v / size, w, trace_offsets)
    if not fits:
        raise GeometryError(Finding("beds.too-few-points"))
    degree, p = _select_degree(fits, len(xyz))
    fit = fits[degree - 1]
    n_effective = len(xyz) / fit.variance_inflation
    dof = n_effective - len(fit.coefficients)
    variance = fit.squares / max(len(xyz) - len(fit.coefficients), 1) * fit.variance_inflation
    slopes, errors = _fit_slopes(fit, degree, u / size, v / size, size, variance, dof)
    for higher_degree in range(degree + 1, min(degree + 2, len(fits)) + 1):
        gradient = np.stack(_design_gradients(u / size, v / size, higher_degree), axis=1) / size
        angle = np.linalg.norm(gradient @ fits[higher_degree - 1].coefficients - slopes, axis=1)
        errors = np.maximum(errors, np.degrees(np.arctan(angle)))
    normals = frame[2] - slopes[:, :1] * frame[0] - slopes[:, 1:] * frame[1]
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    normals = np.where(normals[:, 2:] < 0.0, -normals, normals)
    direction, dip, _ = dips_from_normals(normals)
    local_dips = np.stack([direction, dip, errors], axis=1)
    dips = []
    for i, name in enumerate(ids):
        rows = np.arange(trace_offsets[i], trace_offsets[i + 1])
        if not len(rows):
            continue
        index = rows[np.argmin(np.linalg.norm(xyz[rows] - xyz[rows].mean(axis=0), axis=1))]
        position = xyz[index] - fit.residuals[index] * frame[2]
        dips.append(LocalDip(str(name), *map(float, position), *map(float, local_dips[index])))
    rms = float(np.sqrt(fit.squares / len(xyz)))
    return CurvedBed(degree, p, rms, len(xyz), n_effective, tuple(dips), local_dips)


def _fit_polynomials(
    u: FloatArray, v: FloatArray, w: FloatArray, trace_offsets: IntArray
) -> list[_PolynomialFit]:
    """Fit polynomials of increasing degree up to the highest that the points determine.

    The correlation of neighbours is estimated from the residuals of the highest degree, because a
    bend that a lower degree does not fit is not noise.
    """
    fits: list[_PolynomialFit] = []
    for degree in range(1, MAX_DEGREE + 1):
        columns = _design_matrix(u, v, degree)
        left_vectors, singular_values, right_vectors = np.linalg.svd(columns, full_matrices=False)
        if (
            len(u) <= columns.shape[1] + MIN_EXCESS_POINTS
            or singular_values[-1] < MIN_SINGULAR_RATIO * singular_values[0]
        ):
            break
        coefficients = right_vectors.T @ ((left_vectors.T @ w) / singular_values)
        residuals = w - columns @ coefficients
        unscaled_covariance = (right_vectors.T / singular_values**2) @ right_vectors
        sum_of_squares = float(residuals @ residuals)
        fits.append(
            _PolynomialFit(coefficients, unscaled_covariance, sum_of_squares, residuals, 1.0)
        )
    if not fits:
        return []
    variance_inflation = _neighbour_inflation(fits[-1].residuals, trace_offsets)
    n_effective = len(u) / variance_inflation
    return [
        replace(fit, variance_inflation=variance_inflation)
        for fit in fits
        if n_effective > len(fit.coefficients) + MIN_EXCESS_POINTS
    ]


def _select_degree(fits: list[_PolynomialFit], n: int) -> tuple[int, float | None]:
    """Select the degree of the polynomial, and compute the p-value of a plane.

    The lowest degree that neither of the next two degrees improves is selected. A degree that does
    not improve the fit is skipped if the next one does: a symmetric bend has no odd part. The
    p-value is None if a plane is selected.
    """
    from scipy.special import fdtrc

    def p_value(low: int, high: int) -> float:
        n_added_terms = len(fits[high].coefficients) - len(fits[low].coefficients)
        dof = n / fits[high].variance_inflation - len(fits[high].coefficients)
        residual_variance = fits[high].squares / max(n - len(fits[high].coefficients), 1)
        if residual_variance <= 0.0:
            return 1.0 if fits[low].squares <= 0.0 else 0.0
        explained_mean_square = (
            (fits[low].squares - fits[high].squares) / n_added_terms / fits[high].variance_inflation
        )
        return float(fdtrc(n_added_terms, dof, explained_mean_square / residual_variance))

    degree = 0
    while True:
        better_degrees = [
            k
            for k in (degree + 1, degree + 2)
            if k < len(fits) and p_value(degree, k) < SIGNIFICANCE / 2
        ]
        if not better_degrees:
            break
        degree = better_degrees[0]
    return degree + 1, None if degree == 0 else p_value(0, degree)


def _fit_slopes(
    fit: _PolynomialFit,
    degree: int,
    u: FloatArray,
    v: FloatArray,
    size: float,
    variance: float,
    degrees_of_freedom: float,
) -> tuple[FloatArray, FloatArray]:
    """Return the slopes (n, 2) and the larger half-angles (n,) of their 95 % regions, degrees."""
    gradient = np.stack(_design_gradients(u, v, degree), axis=1) / size
    slopes = gradient @ fit.coefficients
    covariances = variance * np.einsum("nak,kl,nbl->nab", gradient, fit.shape, gradient)
    limit = float(joint_quantile(np.array([degrees_of_freedom]))[0]) * degrees_of_freedom
    largest_variances = np.linalg.eigvalsh(covariances)[:, 1]
    return slopes, np.degrees(np.arctan(np.sqrt(np.maximum(largest_variances, 0.0) * limit)))


def _monomials(degree: int) -> list[tuple[int, int]]:
    return [(i - j, j) for i in range(degree + 1) for j in range(i + 1)]


def _design_matrix(u: FloatArray, v: FloatArray, degree: int) -> FloatArray:
    return np.stack([u**i * v**j for i, j in _monomials(degree)], axis=1)


def _design_gradients(u: FloatArray, v: FloatArray, degree: int) -> tuple[FloatArray, FloatArray]:
    """Return the gradients (n, k) of the design matrix along u and v."""
    powers = _monomials(degree)
    u_gradients = [i * u ** max(i - 1, 0) * v**j for i, j in powers]
    v_gradients = [j * u**i * v ** max(j - 1, 0) for i, j in powers]
    return np.stack(u_gradients, axis=1), np.stack(v_gradients, axis=1)


def _neighbour_inflation(residuals: FloatArray, trace_offsets: IntArray) -> float:
    """Return (1 + r) / (1 - r), at least 1, for the correlation r of neighbours on traces."""
    is_last = np.zeros(len(residuals), np.bool_)
    ends = trace_offsets[1:][trace_offsets[1:] > 0] - 1
    is_last[ends] = True
    first = np.flatnonzero(~is_last[:-1])
    sum_of_squares = float(residuals @ residuals)
    if sum_of_squares <= 0.0 or not len(first):
        return 1.0
    r = (
        float(residuals[first] @ residuals[first + 1])
        / len(first)
        / (sum_of_squares / len(residuals))
    )
    # With few residual degrees of freedom, the correlation of neighbours becomes negative.
    return max(1.0, (1.0 + min(r, 0.98)) / (1.0 - min(r, 0.98)))
