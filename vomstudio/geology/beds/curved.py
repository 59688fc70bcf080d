"""One bed that bends: a mean surface through several traces of it, with its local dip.

A trend surface: the heights over a mean plane as a polynomial of the place in it (Krumbein 1959,
Journal of Geophysical Research 64, 823-834; Davis 2002, Statistics and Data Analysis in Geology,
chapter 5). The degree is raised as long as the next ones explain more than chance does (F test),
and what neighbours on a trace have in common lowers the number of points that count (Bayley &
Hammersley 1946, Supplement to the Journal of the Royal Statistical Society 8, 184-197). The dip at
a place is that of the surface's tangent plane; its error is that of the regression, or what the
next degrees would turn it by, whichever is more. Between the traces the surface is interpolated,
beyond them nothing is said.
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
from vomstudio.geometry.vectors import dip_of_normals

HIGHEST = 4
LEVEL = 0.05
_SPARE = 3.0
"""Independent points beyond the unknowns that a degree needs."""
_SURE = 1e-4
"""Least over largest singular value from which on places determine a polynomial."""


@dataclass(frozen=True)
class LocalDip:
    """The bed where a trace is: id of the trace; x, y, z of the place on the surface, at the middle
    of the trace; error95_deg : larger half-angle of the joint 95 % region of its normal"""

    id: str
    x: float
    y: float
    z: float
    dip_direction_deg: float
    dip_deg: float
    error95_deg: float


@dataclass(frozen=True, eq=False)
class CurvedBed:
    """degree : of the polynomial, 1 for a plane; p : of a plane that explains the points as well,
    None where it is one; rms_m : of the points about the surface; n, n_effective : points, and how
    many of them are independent
    dips : at the middle of each trace; along : (n, 3) of all points: dip direction, dip, error95,
    degrees, in the order that they were given
    """

    degree: int
    p: float | None
    rms_m: float
    n: int
    n_effective: float
    dips: tuple[LocalDip, ...]
    along: FloatArray


@dataclass(frozen=True, eq=False)
class _Fit:
    """coefficients (k,), their covariance over the variance of the points (k, k), sum of squares,
    residuals (n,), likeness : by which points count less than once"""

    coefficients: FloatArray
    shape: FloatArray
    squares: float
    residuals: FloatArray
    likeness: float


def curved_bed(ids: Sequence[str], points: npt.ArrayLike, offsets: npt.ArrayLike) -> CurvedBed:
    """Fit one surface to traces of one bed.

    ids : (g,) of the traces; points : (n, 3) World, m, in their order along each trace; offsets :
    (g + 1,), trace i is points[offsets[i]:offsets[i + 1]]
    Raises GeometryError where the points determine no plane, or leave nothing to judge it by.
    """
    xyz = np.asarray(points, np.float64).reshape(-1, 3)
    cuts = np.asarray(offsets, np.int64)
    middle = xyz.mean(axis=0)
    values, axes = np.linalg.eigh((xyz - middle).T @ (xyz - middle))
    if len(xyz) < 6 or not values[1] > 1e-8 * values[2]:
        raise GeometryError(Finding("beds.no-surface"))
    frame = axes[:, ::-1].T
    frame[2] = frame[2] if frame[2, 2] >= 0 else -frame[2]
    frame[1] = np.cross(frame[2], frame[0])
    u, v, w = ((xyz - middle) @ frame.T).T
    size = float(max(np.abs(u).max(), np.abs(v).max()))
    fits = _fits(u / size, v / size, w, cuts)
    if not fits:
        raise GeometryError(Finding("beds.too-few-points"))
    degree, p = _degree(fits, len(xyz))
    fit = fits[degree - 1]
    n_effective = len(xyz) / fit.likeness
    free = n_effective - len(fit.coefficients)
    variance = fit.squares / max(len(xyz) - len(fit.coefficients), 1) * fit.likeness
    slopes, errors = _slopes(fit, degree, u / size, v / size, size, variance, free)
    for higher in range(degree + 1, min(degree + 2, len(fits)) + 1):
        gradient = np.stack(_gradients(u / size, v / size, higher), axis=1) / size
        turn = np.linalg.norm(gradient @ fits[higher - 1].coefficients - slopes, axis=1)
        errors = np.maximum(errors, np.degrees(np.arctan(turn)))
    normals = frame[2] - slopes[:, :1] * frame[0] - slopes[:, 1:] * frame[1]
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    normals = np.where(normals[:, 2:] < 0.0, -normals, normals)
    direction, dip, _ = dip_of_normals(normals)
    along = np.stack([direction, dip, errors], axis=1)
    dips = []
    for i, name in enumerate(ids):
        rows = np.arange(cuts[i], cuts[i + 1])
        if not len(rows):
            continue
        at = rows[np.argmin(np.linalg.norm(xyz[rows] - xyz[rows].mean(axis=0), axis=1))]
        place = xyz[at] - fit.residuals[at] * frame[2]
        dips.append(LocalDip(str(name), *map(float, place), *map(float, along[at])))
    rms = float(np.sqrt(fit.squares / len(xyz)))
    return CurvedBed(degree, p, rms, len(xyz), n_effective, tuple(dips), along)


def _fits(u: FloatArray, v: FloatArray, w: FloatArray, cuts: IntArray) -> list[_Fit]:
    """Of degree 1, 2 and so on, as far as the points determine them. What neighbours have in common
    is told by the highest: a bend that a lower degree leaves is no noise."""
    found: list[_Fit] = []
    for degree in range(1, HIGHEST + 1):
        columns = _columns(u, v, degree)
        left, sizes, right = np.linalg.svd(columns, full_matrices=False)
        if len(u) <= columns.shape[1] + _SPARE or sizes[-1] < _SURE * sizes[0]:
            break
        coefficients = right.T @ ((left.T @ w) / sizes)
        residuals = w - columns @ coefficients
        shape = (right.T / sizes**2) @ right
        squares = float(residuals @ residuals)
        found.append(_Fit(coefficients, shape, squares, residuals, 1.0))
    if not found:
        return []
    likeness = _likeness(found[-1].residuals, cuts)
    counted = len(u) / likeness
    return [
        replace(fit, likeness=likeness) for fit in found if counted > len(fit.coefficients) + _SPARE
    ]


def _degree(fits: list[_Fit], n: int) -> tuple[int, float | None]:
    """The lowest beyond which nothing explains more, and the p of a plane against it. A degree is
    passed over where the one after it explains more: a symmetric bend has no odd part."""
    from scipy.special import fdtrc

    def p_of(low: int, high: int) -> float:
        more = len(fits[high].coefficients) - len(fits[low].coefficients)
        free = n / fits[high].likeness - len(fits[high].coefficients)
        scatter = fits[high].squares / max(n - len(fits[high].coefficients), 1)
        if scatter <= 0.0:
            return 1.0 if fits[low].squares <= 0.0 else 0.0
        gain = (fits[low].squares - fits[high].squares) / more / fits[high].likeness
        return float(fdtrc(more, free, gain / scatter))

    degree = 0
    while True:
        better = [
            k for k in (degree + 1, degree + 2) if k < len(fits) and p_of(degree, k) < LEVEL / 2
        ]
        if not better:
            break
        degree = better[0]
    return degree + 1, None if degree == 0 else p_of(0, degree)


def _slopes(
    fit: _Fit, degree: int, u: FloatArray, v: FloatArray, size: float, variance: float, free: float
) -> tuple[FloatArray, FloatArray]:
    """(n, 2) slopes along the axes, and (n,) larger half-angle of their joint 95 % region,
    degrees."""
    gradient = np.stack(_gradients(u, v, degree), axis=1) / size
    slopes = gradient @ fit.coefficients
    spread = variance * np.einsum("nak,kl,nbl->nab", gradient, fit.shape, gradient)
    limit = float(joint_quantile(np.array([free]))[0]) * free
    largest = np.linalg.eigvalsh(spread)[:, 1]
    return slopes, np.degrees(np.arctan(np.sqrt(np.maximum(largest, 0.0) * limit)))


def _powers(degree: int) -> list[tuple[int, int]]:
    return [(i - j, j) for i in range(degree + 1) for j in range(i + 1)]


def _columns(u: FloatArray, v: FloatArray, degree: int) -> FloatArray:
    return np.stack([u**i * v**j for i, j in _powers(degree)], axis=1)


def _gradients(u: FloatArray, v: FloatArray, degree: int) -> tuple[FloatArray, FloatArray]:
    """(n, k) along u and along v."""
    powers = _powers(degree)
    along = [i * u ** max(i - 1, 0) * v**j for i, j in powers]
    across = [j * u**i * v ** max(j - 1, 0) for i, j in powers]
    return np.stack(along, axis=1), np.stack(across, axis=1)


def _likeness(residuals: FloatArray, cuts: IntArray) -> float:
    """(1 + r) / (1 - r) with the correlation r of neighbours on the traces, at least 1."""
    last = np.zeros(len(residuals), np.bool_)
    ends = cuts[1:][cuts[1:] > 0] - 1
    last[ends] = True
    first = np.flatnonzero(~last[:-1])
    whole = float(residuals @ residuals)
    if whole <= 0.0 or not len(first):
        return 1.0
    r = float(residuals[first] @ residuals[first + 1]) / len(first) / (whole / len(residuals))
    # What the fit took from a few points makes neighbours look unlike each other.
    return max(1.0, (1.0 + min(r, 0.98)) / (1.0 - min(r, 0.98)))
