"""Statistics of sets of orientations.

Axial data (poles, lineations, fold axes: a vector and its opposite are the same thing) are
described by the orientation tensor (1/n) sum x x^T with eigenvalues S1 >= S2 >= S3, sum 1
(Scheidegger 1965; Woodcock 1977, GSA Bulletin 88, 1231-1236); directed data by Fisher's (1953)
resultant. Axial data are never averaged by summing vectors as they come.
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
"""S3 below this is a set that lies exactly in a plane: orientations equal to 1e-10 rad."""

_UNSURE_WEIGHTS = 0.25
_COUNT_AT_LEAST, _SHARE_AT_LEAST = 3.0, 2.0 / 3.0
"""Weighted orientations that are worth fewer equal ones than the first, and than this share of
their number, do not show how far they scatter by nature (Roever, Knapp & Friede 2015, BMC Medical
Research Methodology 15, 99, on few studies of unlike precision): what one or two of them decide has
no region that can be relied on."""


def unit_vectors(vectors: npt.ArrayLike) -> FloatArray:
    """(n, 3) unit vectors. Raises GeometryError for an empty set, zero or non-finite vectors."""
    v = np.atleast_2d(np.asarray(vectors, dtype=np.float64))
    if v.ndim != 2 or v.shape[1] != 3 or len(v) == 0:
        raise GeometryError(Finding("sets.no-orientations"))
    length = np.linalg.norm(v, axis=1)
    bad = ~np.isfinite(length) | (length == 0)
    if bad.any():
        raise GeometryError(
            Finding("orientation.not-a-direction", number=int(np.argmax(bad)) + 1, n=len(v))
        )
    return np.asarray(v / length[:, None])


def orientation_tensor(
    vectors: npt.ArrayLike, weights: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Eigenvalues (3,) S1 >= S2 >= S3 with sum 1, and axes (3, 3): row i is the unit eigenvector
    of S(i+1), pointing down (toward the trend in [0, 180) where horizontal). weights : (n,).

    Computed by singular values of the vectors, which keep the digits that squaring loses: S3 of a
    set that lies in a plane comes out as 1e-32 rather than 1e-17.
    """
    v = unit_vectors(vectors)
    if weights is not None:
        v = v * np.sqrt(weights)[:, None]
    rows = v if len(v) >= 3 else np.vstack([v, np.zeros((3 - len(v), 3))])
    _, singular, axes = np.linalg.svd(rows, full_matrices=False)
    values = singular**2
    values = values / values.sum()
    down = np.array([Line.from_vector(axis).vector() for axis in axes])
    signs = np.sign(np.sum(down * axes, axis=1))
    return values, axes * signs[:, None]


def woodcock(eigenvalues: npt.ArrayLike) -> tuple[float | None, float | None]:
    """Woodcock's (1977) shape K = ln(S1/S2) / ln(S2/S3) and strength C = ln(S1/S3).

    K is None where S2 = S3; C is None (infinite) where S3 = 0, and K is then its limit 0.
    """
    s1, s2, s3 = (float(s) for s in np.asarray(eigenvalues, dtype=np.float64))
    if s3 < ZERO_EIGENVALUE:
        return (0.0 if s2 >= ZERO_EIGENVALUE else None), None
    flat = math.log(s2 / s3)
    shape = math.log(s1 / s2) / flat if flat > 1e-9 else None
    return shape, math.log(s1 / s3)


def vollmer(eigenvalues: npt.ArrayLike) -> tuple[float, float, float]:
    """Point, girdle and random indexes P = S1 - S2, G = 2 (S2 - S3), R = 3 S3, sum 1 (Vollmer
    1990, GSA Bulletin 102, 786-791)."""
    s1, s2, s3 = (float(s) for s in np.asarray(eigenvalues, dtype=np.float64))
    return s1 - s2, 2.0 * (s2 - s3), 3.0 * s3


def axial_mean(vectors: npt.ArrayLike) -> Line:
    """Mean of axial data: the tensor's first axis. Raises GeometryError where S1 = S2, which
    leaves no preferred axis."""
    values, axes = orientation_tensor(vectors)
    if values[0] - values[1] < 1e-12:
        raise GeometryError(Finding("orientation.no-mean"))
    return Line.from_vector(axes[0])


def flip_to(vectors: npt.ArrayLike, axis: npt.ArrayLike) -> FloatArray:
    """(n, 3) the same axes, each pointing into the hemisphere of `axis`."""
    v = unit_vectors(vectors)
    return np.where((v @ np.asarray(axis, dtype=np.float64) < 0)[:, None], -v, v)


@dataclass(frozen=True)
class Fisher:
    """Fisher's (1953) statistics of n directions.

    R: length of the resultant. kappa = (n - 1) / (n - R), None where all directions are the same
    (infinite). alpha95_deg: half-angle of the cone that holds the true mean with 95 %
    (joint, exact: cos a = 1 - ((n - R) / R) (20^(1 / (n - 1)) - 1)), None where no cone does, and
    where weights leave the mean to a few (`few_decide`).
    """

    mean: Line
    n: int
    R: float
    kappa: float | None
    alpha95_deg: float | None


def fisher(vectors: npt.ArrayLike, directed: bool, weights: FloatArray | None = None) -> Fisher:
    """Fisher's statistics of unit vectors (n, 3); axial data are first flipped into the hemisphere
    of the tensor's first axis. Whether axial data are clustered enough for that is
    `no_fisher_reason`'s question. weights : (n,) with mean 1, as the inverse variances of the
    directions. Raises GeometryError where the resultant vanishes."""
    v = unit_vectors(vectors)
    w = np.ones(len(v)) if weights is None else weights
    if not directed:
        v = flip_to(v, orientation_tensor(v, weights)[1][0])
    n = len(v)
    total = w @ v
    resultant = float(np.linalg.norm(total))
    if resultant < 1e-9 * n:
        raise GeometryError(Finding("orientation.no-mean"))
    mean = total / resultant
    # n - R without cancellation: each term is 1 - cos of the angle to the mean.
    lack = 0.5 * float(w @ np.sum((v - mean) ** 2, axis=1))
    same = lack < n * ZERO_EIGENVALUE
    kappa = None if n < 2 or same else (n - 1) / lack
    alpha: float | None = None
    if n >= 2 and not few_decide(w):
        # Weights that are inverse variances leave as many degrees of freedom as equal ones, less
        # what is not known of them (by simulation, with the natural scatter found as well).
        free = n - 1.0 - _UNSURE_WEIGHTS * (n - effective_number(w))
        versine = lack / resultant * math.expm1(math.log(20.0) / free)
        if versine <= 2.0:
            # cos a = 1 - versine, in the form that keeps small angles exact
            alpha = math.degrees(2.0 * math.asin(math.sqrt(versine / 2.0)))
    return Fisher(Line.from_vector(mean, directed=directed), n, resultant, kappa, alpha)


def effective_number(weights: npt.ArrayLike) -> float:
    """Of how many equal ones weights (n,) are worth: (sum w)^2 / sum w^2 (Kish 1965)."""
    w = np.asarray(weights, dtype=np.float64)
    return float(w.sum() ** 2 / (w @ w))


def few_decide(weights: npt.ArrayLike) -> bool:
    """Whether so few of the weights (n,) count that the scatter by nature is not shown."""
    return effective_number(weights) < min(_COUNT_AT_LEAST, _SHARE_AT_LEAST * np.size(weights))


def no_fisher_reason(vectors: npt.ArrayLike, directed: bool) -> Finding | None:
    """Why Fisher's statistics would mislead for this set, or None where they are sound.

    A single one; axial data that are no cluster, that is whose point index P is not the largest of
    Vollmer's three (1990): flipping and averaging a girdle or a uniform scatter has no meaning.
    Woodcock's K alone would also refuse tight clusters of an elongated shape.
    """
    v = unit_vectors(vectors)
    n = len(v)
    if n < 2:
        return Finding("fisher.single")
    if directed:
        if float(np.linalg.norm(v.sum(axis=0))) < 1e-9 * n:
            return Finding("fisher.no-mean")
        return None
    point, girdle, random = vollmer(orientation_tensor(v)[0])
    if max(girdle, random) <= point:
        return None
    code = "fisher.girdle" if girdle > random else "fisher.uniform"
    return Finding(code, point=point, girdle=girdle, random=random)
