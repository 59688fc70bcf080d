"""Statistics of sets of orientations.

Axial data (poles, lineations, fold axes: a vector and its opposite are equivalent) are described by
the orientation tensor (1/n) sum x x^T with the eigenvalues S1 >= S2 >= S3, whose sum is 1
(Scheidegger 1965; Woodcock 1977, GSA Bulletin 88, 1231-1236). Directed data are described by
Fisher's (1953) resultant. Axial data are never averaged as vectors without flipping.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Line

ZERO_EIGENVALUE = 1e-20
"""Minimum S3; below it, the set lies exactly in a plane (to within 1e-10 rad)."""

WEIGHT_FREEDOM_LOSS = 0.25
MIN_EFFECTIVE_COUNT, MIN_EFFECTIVE_SHARE = 3.0, 2.0 / 3.0
"""Minimum effective number of weighted orientations, and minimum ratio of it to their count, for
determining the natural scatter (Roever, Knapp & Friede 2015, BMC Medical Research Methodology
15, 99, on meta-analyses of a few studies of unequal precision). Below them, the confidence region
would depend on one or two orientations and be unreliable.
"""


def unit_vectors(vectors: npt.ArrayLike) -> FloatArray:
    """Normalize vectors (n, 3).

    Raises
    ------
    GeometryError
        If the array is empty, or if a vector is zero or not finite.
    """
    v = np.atleast_2d(np.asarray(vectors, dtype=np.float64))
    if v.ndim != 2 or v.shape[1] != 3 or len(v) == 0:
        raise GeometryError(Finding("sets.no-orientations"))
    length = np.linalg.norm(v, axis=1)
    is_invalid = ~np.isfinite(length) | (length == 0)
    if is_invalid.any():
        raise GeometryError(
            Finding("orientation.not-a-direction", number=int(np.argmax(is_invalid)) + 1, n=len(v))
        )
    return np.asarray(v / length[:, None])


def orientation_tensor(
    vectors: npt.ArrayLike, weights: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Compute the eigenvalues and eigenvectors of the orientation tensor.

    The singular values of the vectors keep digits that squaring loses: S3 of a set in a plane is
    1e-32 instead of 1e-17.

    Parameters
    ----------
    vectors : (n, 3) array_like
    weights : (n,) ndarray, optional

    Returns
    -------
    eigenvalues : (3,) ndarray
        S1 >= S2 >= S3 with sum 1.
    axes : (3, 3) ndarray
        Unit eigenvectors as rows. They point down, or toward a trend in [0, 180) if horizontal.
    """
    v = unit_vectors(vectors)
    if weights is not None:
        v = v * np.sqrt(weights)[:, None]
    rows = v if len(v) >= 3 else np.vstack([v, np.zeros((3 - len(v), 3))])
    _, singular_values, axes = np.linalg.svd(rows, full_matrices=False)
    eigenvalues = singular_values**2
    eigenvalues = eigenvalues / eigenvalues.sum()
    downward_axes = np.array([Line.from_vector(axis).vector() for axis in axes])
    signs = np.sign(np.sum(downward_axes * axes, axis=1))
    return eigenvalues, axes * signs[:, None]


def woodcock(eigenvalues: npt.ArrayLike) -> tuple[float | None, float | None]:
    """Return the shape and strength of an orientation tensor (Woodcock 1977).

    Parameters
    ----------
    eigenvalues : (3,) array_like
        S1, S2 and S3.

    Returns
    -------
    shape : float or None
        K = ln(S1/S2) / ln(S2/S3); None if S2 = S3, and the limit 0 if S3 = 0.
    strength : float or None
        C = ln(S1/S3); None (infinite) if S3 = 0.
    """
    s1, s2, s3 = (float(s) for s in np.asarray(eigenvalues, dtype=np.float64))
    if s3 < ZERO_EIGENVALUE:
        return (0.0 if s2 >= ZERO_EIGENVALUE else None), None
    girdle_log_ratio = math.log(s2 / s3)
    shape = math.log(s1 / s2) / girdle_log_ratio if girdle_log_ratio > 1e-9 else None
    return shape, math.log(s1 / s3)


def vollmer(eigenvalues: npt.ArrayLike) -> tuple[float, float, float]:
    """Return Vollmer's point, girdle and random indices, whose sum is 1.

    P = S1 - S2, G = 2 (S2 - S3), R = 3 S3 (Vollmer 1990, GSA Bulletin 102, 786-791).

    Parameters
    ----------
    eigenvalues : (3,) array_like
        S1, S2 and S3.

    Returns
    -------
    tuple of float
        P, G and R.
    """
    s1, s2, s3 = (float(s) for s in np.asarray(eigenvalues, dtype=np.float64))
    return s1 - s2, 2.0 * (s2 - s3), 3.0 * s3


def axial_mean(vectors: npt.ArrayLike) -> Line:
    """Return the mean of axial data, the first eigenvector of the orientation tensor.

    Raises
    ------
    GeometryError
        If S1 = S2, so that the data have no preferred axis.
    """
    eigenvalues, axes = orientation_tensor(vectors)
    if eigenvalues[0] - eigenvalues[1] < 1e-12:
        raise GeometryError(Finding("orientation.no-mean"))
    return Line.from_vector(axes[0])


def flip_to_hemisphere(vectors: npt.ArrayLike, axis: npt.ArrayLike) -> FloatArray:
    """Flip axes into the hemisphere of an axis.

    Parameters
    ----------
    vectors : (n, 3) array_like
    axis : (3,) array_like

    Returns
    -------
    (n, 3) ndarray
    """
    v = unit_vectors(vectors)
    return np.where((v @ np.asarray(axis, dtype=np.float64) < 0)[:, None], -v, v)


@dataclass(frozen=True)
class Fisher:
    """Fisher's (1953) statistics of n directions.

    Attributes
    ----------
    R : float
        Length of the resultant.
    kappa : float or None
        (n - 1) / (n - R); None for identical directions (infinite) and for a single direction.
    alpha95_deg : float or None
        Half-angle of the 95 % confidence cone of the mean, degrees (joint, exact: cos a = 1 - ((n -
        R) / R) (20^(1 / (n - 1)) - 1)); None if no such cone exists, or if a few weights dominate.
    """

    mean: Line
    n: int
    R: float
    kappa: float | None
    alpha95_deg: float | None


def fisher(vectors: npt.ArrayLike, is_directed: bool, weights: FloatArray | None = None) -> Fisher:
    """Compute Fisher's statistics of directed or axial data.

    Axial data are flipped into the hemisphere of the first eigenvector of the tensor;
    `no_fisher_reason` tests whether they are sufficiently clustered.

    Parameters
    ----------
    vectors : (n, 3) array_like
    is_directed : bool
    weights : (n,) ndarray, optional
        Inverse variances, scaled to a mean of 1.

    Returns
    -------
    Fisher

    Raises
    ------
    GeometryError
        If the resultant is zero.
    """
    v = unit_vectors(vectors)
    used_weights = np.ones(len(v)) if weights is None else weights
    if not is_directed:
        v = flip_to_hemisphere(v, orientation_tensor(v, weights)[1][0])
    n = len(v)
    resultant_vector = used_weights @ v
    resultant = float(np.linalg.norm(resultant_vector))
    if resultant < 1e-9 * n:
        raise GeometryError(Finding("orientation.no-mean"))
    mean = resultant_vector / resultant
    # Compute n - R without cancellation: each term is 1 - cos of the angle to the mean.
    shortfall = 0.5 * float(used_weights @ np.sum((v - mean) ** 2, axis=1))
    is_identical = shortfall < n * ZERO_EIGENVALUE
    kappa = None if n < 2 or is_identical else (n - 1) / shortfall
    alpha: float | None = None
    if n >= 2 and not has_dominant_weights(used_weights):
        # With inverse-variance weights, the degrees of freedom are those of equal weights minus
        # those lost to the uncertainty of the weights (from simulations with an estimated natural
        # scatter).
        dof = n - 1.0 - WEIGHT_FREEDOM_LOSS * (n - effective_number(used_weights))
        versine = shortfall / resultant * math.expm1(math.log(20.0) / dof)
        if versine <= 2.0:
            # cos a = 1 - versine, rearranged to preserve small angles
            alpha = math.degrees(2.0 * math.asin(math.sqrt(versine / 2.0)))
    return Fisher(Line.from_vector(mean, is_directed=is_directed), n, resultant, kappa, alpha)


def effective_number(weights: npt.ArrayLike) -> float:
    """Return the effective number of weighted data, (sum w)^2 / sum w^2 (Kish 1965).

    Parameters
    ----------
    weights : (n,) array_like

    Returns
    -------
    float
    """
    w = np.asarray(weights, dtype=np.float64)
    return float(w.sum() ** 2 / (w @ w))


def has_dominant_weights(weights: npt.ArrayLike) -> bool:
    """Return whether a few weights dominate so that the natural scatter is undetermined.

    Parameters
    ----------
    weights : (n,) array_like

    Returns
    -------
    bool
    """
    return effective_number(weights) < min(
        MIN_EFFECTIVE_COUNT, MIN_EFFECTIVE_SHARE * np.size(weights)
    )


def no_fisher_reason(vectors: npt.ArrayLike, is_directed: bool) -> Finding | None:
    """Return the reason why Fisher's statistics do not apply, or None if they do.

    They do not apply to single orientations, nor to axial data that do not form a cluster, that is,
    whose point index P is not the largest of Vollmer's (1990) three indices: the mean of a flipped
    girdle or of a uniform set is meaningless. Woodcock's K alone would also reject tight elongated
    clusters.

    Parameters
    ----------
    vectors : (n, 3) array_like
    is_directed : bool
        Whether the vectors are directed rather than axial.

    Returns
    -------
    Finding or None
    """
    v = unit_vectors(vectors)
    n = len(v)
    if n < 2:
        return Finding("fisher.single")
    if is_directed:
        if float(np.linalg.norm(v.sum(axis=0))) < 1e-9 * n:
            return Finding("fisher.no-mean")
        return None
    point, girdle, random_index = vollmer(orientation_tensor(v)[0])
    if max(girdle, random_index) <= point:
        return None
    code = "fisher.girdle" if girdle > random_index else "fisher.uniform"
    return Finding(code, point=point, girdle=girdle, random=random_index)
