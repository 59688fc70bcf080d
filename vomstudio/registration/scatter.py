"""Errors of coordinates as a similarity's residuals show them, and what they do to its rotation.

Heights by satellite are worse than positions, heights by levelling better: an error of one size for
all coordinates states a tilt that is too small or too large. Horizontal coordinates and heights
therefore have an error each, and from `FEWEST_PER_AXIS` points on each axis has its own. They are
the unbiased quadratic estimates that leave the similarity out (Rao's MINQUE, here for equal
weights beforehand): with the projection M on the residuals, the squares of group g have the
expectation sum_k tr(M_gk M_kg) sigma_k^2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geology.serial_errors import (
    correlated,
    correlation_of,
    independent_share,
    more_taken,
)
from vomstudio.registration.similarity import jacobian

FEWEST_FOR_HEIGHTS = 5
FEWEST_PER_AXIS = 12
UNSEEN_HEIGHTS = 1.4
"""Fewer points do not show whether heights are worse than positions, as those by satellite are by
one and a half to three times: they are taken to be worse by so much, which holds in 90 % or more
of models with heights that are as good or up to two and a half times as bad."""
# An estimate may be negative by chance: by few points no coordinate is believed to be better by
# more than this share of the variance.
_LEAST_SHARE = 0.1
# Residuals are believed against what was stated where chance would make them so large this rarely.
_SURE = 0.95
_WARN_SCALE = 0.01


@dataclass(frozen=True, eq=False)
class Scatter:
    """sigma : (3,) of a coordinate, east, north, up
    covariance : (7, 7) of a small turn about east, north, up (rad), a relative change of scale and
        a shift, one sigma of a normal distribution with the same 95 % as Student's
    drift : correlation of the errors of neighbours, 0 where they are independent or unordered
    """

    sigma: FloatArray
    covariance: FloatArray
    drift: float = 0.0

    @property
    def rotation(self) -> FloatArray:
        """(3, 3) covariance of the turn, radians squared."""
        return self.covariance[:3, :3]

    @property
    def horizontal_sigma(self) -> float:
        """Standard deviation of a horizontal coordinate, m."""
        return float(np.sqrt((self.sigma[:2] ** 2).mean()))

    @property
    def worst_rotation_deg(self) -> float:
        """Standard deviation of the rotation about its least certain axis."""
        return float(np.degrees(np.sqrt(np.linalg.eigvalsh(self.rotation)[-1])))


def scatter_of(
    places: FloatArray,
    residuals: FloatArray,
    stated: float | FloatArray | None = None,
    *,
    in_order: bool = False,
) -> Scatter:
    """Of a similarity by least squares with equal weights.

    places, residuals : (n, 3) in the target frame, n of 3 or more
    stated : one-sigma error of the coordinates, a number or (3,), or covariances (n, 3, 3) of the
        points; the residuals count instead where they are significantly larger
    in_order : the places follow each other as they were taken, so that errors of a receiver that
        drifts are recognised
    """
    from scipy.stats import chi2, norm, t

    n = len(places)
    moves = np.array([jacobian(p) for p in places - places.mean(axis=0)])
    # A turn moves far points, a shift all: in units of the spread the equations stay well posed.
    size = float(np.sqrt(((places - places.mean(axis=0)) ** 2).sum(axis=1).mean()))
    units = np.array([size, size, size, size, 1.0, 1.0, 1.0])
    moves = moves / units
    inverse = np.linalg.pinv(np.einsum("nik,nil->kl", moves, moves), hermitian=True)
    own = _following(moves, 0.0)
    known = _covariances(stated, n)
    freedom = float(3 * n - 7)
    if known is not None:
        roots, weights = _roots(known)
        white = np.einsum("nij,nj->ni", weights, residuals)
        if (white**2).sum() * freedom / _expected_square(moves, inverse, known) <= chi2.ppf(
            _SURE, freedom
        ):
            rho = correlation_of(weights @ moves, white) if in_order else 0.0
            spread = roots @ moves
            middle = np.einsum("nik,nil->kl", spread, correlated(spread, rho))
            covariance = inverse @ middle @ inverse / np.outer(units, units)
            sigma = np.sqrt(np.einsum("nii->i", known) / n)
            return Scatter(sigma, covariance, rho)
    groups = _groups(n)
    variances, free = _variances(groups, n, inverse, own, (residuals**2).sum(axis=0))
    if known is not None:
        variances = np.maximum(variances, np.einsum("nii->i", known) / n)
    usable = in_order and (variances > 0.0).all()
    rho = correlation_of(moves, residuals / np.sqrt(variances)) if usable else 0.0
    following = own if rho == 0.0 else _following(moves, rho)
    for g in groups if rho > 0.0 else ():
        alone, all_ = (inverse @ each[list(g)].sum(axis=0) for each in (own, following))
        variances[list(g)] *= more_taken(alone, all_, n * len(g))
    free = free * independent_share(rho)
    shares = np.array(
        [
            np.diag(inverse @ following[list(g)].sum(axis=0) @ inverse) * variances[g[0]]
            for g in groups
        ]
    )
    # Satterthwaite: the degrees of freedom of a sum of estimated variances.
    total = shares.sum(axis=0)
    each = total**2 / np.maximum((shares**2 / np.maximum(free, 1.0)[:, None]).sum(axis=0), 1e-300)
    factor = t.ppf(0.975, np.clip(each, 1.0, None)) / norm.ppf(0.975)
    return _result(np.sqrt(variances), inverse, following, units, factor, drift=rho)


def _covariances(stated: float | FloatArray | None, n: int) -> FloatArray | None:
    """Return stated errors as covariances (n, 3, 3), None if one is not known."""
    if stated is None:
        return None
    values = np.asarray(stated, np.float64)
    if values.ndim < 3:
        values = np.tile(np.diag(np.broadcast_to(values, 3) ** 2), (n, 1, 1))
    return values if (np.einsum("nii->ni", values) > 0.0).all() else None


def _roots(covariances: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the symmetric roots (n, 3, 3) of covariances, and the inverses of these."""
    values, vectors = np.linalg.eigh(covariances)
    sizes = np.sqrt(values)[:, None, :]
    back = np.swapaxes(vectors, 1, 2)
    return (vectors * sizes) @ back, (vectors / sizes) @ back


def _expected_square(moves: FloatArray, inverse: FloatArray, known: FloatArray) -> float:
    """Return the expectation of the weighted sum of squares of the residuals of a fit with equal
    weights, which leaves more of well known points than their own error.

    moves : (n, 3, 7); inverse : (7, 7) of their squares; known : (n, 3, 3) covariances
    """
    weighted = np.einsum("nik,nij,njl->kl", moves, np.linalg.inv(known), moves)
    spread = np.einsum("nik,nij,njl->kl", moves, known, moves)
    through = inverse @ np.einsum("nik,nil->kl", moves, moves)
    return float(
        3 * len(moves) - 2.0 * np.trace(through) + np.trace(inverse @ spread @ inverse @ weighted)
    )


def _following(moves: FloatArray, rho: float) -> FloatArray:
    """(3, 7, 7) information of each axis with the correlations of its errors."""
    return np.asarray(np.einsum("nik,nil->ikl", moves, correlated(moves, rho)), np.float64)


def drift_findings(drift: Mapping[str, float]) -> list[Finding]:
    """Return a finding about each table of positions whose errors are correlated.

    drift : correlation of neighbours by group, "points" or "cameras"
    """
    codes = {"points": "control.drift", "cameras": "cameras.drift"}
    return [Finding(codes[group], correlation=rho) for group, rho in drift.items() if rho > 0.0]


def scale_findings(scale_error: float) -> list[Finding]:
    """Return a finding if a registration leaves lengths uncertain.

    scale_error : relative, one sigma
    """
    if not scale_error > _WARN_SCALE:
        return []
    return [Finding("registration.weak-scale", error95_percent=196.0 * scale_error)]


def _groups(n: int) -> Sequence[tuple[int, ...]]:
    if n >= FEWEST_PER_AXIS:
        return ((0,), (1,), (2,))
    return ((0, 1), (2,)) if n >= FEWEST_FOR_HEIGHTS else ((0, 1, 2),)


def expected_squares(parts: Sequence[FloatArray], counts: Sequence[int]) -> FloatArray:
    """(k, k) of which the product with the variances of k parts is the expectation of the squares
    of their residuals.

    parts : of each the covariance of the unknowns times the part's information, both by the weights
        of the fit; counts : of its residuals
    """
    system = np.array([[np.trace(a @ b) for b in parts] for a in parts])
    alone = [n - 2.0 * np.trace(a) for n, a in zip(counts, parts, strict=True)]
    return np.asarray(system + np.diag(alone), np.float64)


def least_variance(pooled: float, free: FloatArray) -> FloatArray:
    """(k,) no estimate of few free residuals is believed to be smaller."""
    return np.asarray(_LEAST_SHARE * pooled / np.maximum(free / 10.0, 1.0), np.float64)


def _expected(
    groups: Sequence[tuple[int, ...]], n: int, inverse: FloatArray, own: FloatArray
) -> FloatArray:
    """(groups, groups) of which the product with the variances is the expectation of the squares of
    the residuals."""
    parts = [inverse @ own[list(g)].sum(axis=0) for g in groups]
    return expected_squares(parts, [n * len(g) for g in groups])


def _variances(
    groups: Sequence[tuple[int, ...]],
    n: int,
    inverse: FloatArray,
    own: FloatArray,
    squares: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """(3,) of the axes, and (groups,) the degrees of freedom that each group's rests on."""
    system = _expected(groups, n, inverse, own)
    sums = np.array([squares[list(g)].sum() for g in groups])
    free = np.array([n * len(g) - np.trace(inverse @ own[list(g)].sum(axis=0)) for g in groups])
    pooled = float(squares.sum()) / (3 * n - 7)
    found = np.linalg.solve(system, sums) if len(groups) > 1 else np.array([pooled])
    found = np.maximum(found, least_variance(pooled, free))
    variances = np.empty(3)
    for group, value in zip(groups, found, strict=True):
        variances[list(group)] = value
    if n < FEWEST_FOR_HEIGHTS:
        variances[2] *= UNSEEN_HEIGHTS**2
    return variances, np.maximum(free, 1.0)


def _result(
    sigma: FloatArray,
    inverse: FloatArray,
    own: FloatArray,
    units: FloatArray,
    factor: FloatArray,
    *,
    drift: float,
) -> Scatter:
    middle = np.einsum("i,ikl->kl", sigma**2, own)
    covariance = inverse @ middle @ inverse * np.outer(factor / units, factor / units)
    return Scatter(np.array(sigma, np.float64), covariance, drift)
