"""Similarity transforms between points in two frames, without mirroring."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding

# Ratio of the second to the first axis below which points are collinear.
_COLLINEAR_RATIO = 1e-6
# Ratio below which measured points do not determine the rotation about their line.
_NEARLY_COLLINEAR_RATIO = 0.02
# Minimum number of points from which outliers can be recognised.
_MIN_POINTS_ROBUST = 6
_MAX_TRIPLES = 300
_CONFIDENCE = 0.9999
# If there are many points, several are added at once: a share of the points used so far, provided
# that they fit far below the limit.
_STEP_DIVISOR, _GOOD_FIT_SHARE = 20, 0.5


@dataclass(frozen=True, eq=False)
class Similarity:
    """Similarity transform x' = scale * rotation @ x + translation."""

    scale: float
    rotation: FloatArray
    translation: FloatArray

    def __call__(self, points: npt.ArrayLike) -> FloatArray:
        """Transform points (n, 3)."""
        positions = np.asarray(points, np.float64).reshape(-1, 3)
        return self.scale * (positions @ self.rotation.T) + self.translation

    @property
    def inverse(self) -> Similarity:
        """Similarity from the target back to the source."""
        inverse_rotation = self.rotation.T
        return Similarity(
            1 / self.scale, inverse_rotation, -(inverse_rotation @ self.translation) / self.scale
        )


def fit_similarity(
    source: npt.ArrayLike,
    target: npt.ArrayLike,
    weights: npt.ArrayLike | None = None,
    *,
    scale: float | None = None,
) -> Similarity:
    """Fit a similarity by weighted least squares.

    The method is that of Umeyama 1991 (IEEE PAMI 13, 376), with the sign that excludes mirror
    images. The best rotation does not depend on the scale.

    Parameters
    ----------
    source, target : (n, 3) array
    weights : (n,) array, optional
    scale : float, optional
        Fixed scale; by default, the scale is estimated.

    Raises
    ------
    GeometryError
        If there are fewer than three points, or they are collinear in either frame.
    """
    source_points = np.asarray(source, np.float64).reshape(-1, 3)
    target_points = np.asarray(target, np.float64).reshape(-1, 3)
    point_weights = (
        np.ones(len(source_points)) if weights is None else np.asarray(weights, np.float64)
    )
    source_points, target_points, point_weights = (
        source_points[point_weights > 0],
        target_points[point_weights > 0],
        point_weights[point_weights > 0],
    )
    if len(source_points) < 3:
        raise GeometryError(
            Finding("registration.too-few-points", count=len(source_points), least=3)
        )
    point_weights = point_weights / point_weights.sum()
    ca, cb = point_weights @ source_points, point_weights @ target_points
    da, db = source_points - ca, target_points - cb
    for offsets in (da, db):
        axes = np.linalg.svd(offsets * np.sqrt(point_weights)[:, None], compute_uv=False)
        if not axes[1] > _COLLINEAR_RATIO * axes[0]:
            raise GeometryError(Finding("control.collinear"))
    u, s, vt = np.linalg.svd((db * point_weights[:, None]).T @ da)
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(u) * np.linalg.det(vt))])
    rotation = (u * sign) @ vt
    if scale is None:
        scale = float((s * sign).sum() / (point_weights @ (da**2).sum(1)))
    return Similarity(scale, rotation, cb - scale * rotation @ ca)


def fit_robustly(
    source: npt.ArrayLike, target: npt.ArrayLike, *, min_sigma: float = 0.0, seed: int = 0
) -> tuple[Similarity, BoolArray]:
    """Fit a similarity if up to half of the points are wrong.

    The half that agrees best is found by least median of squares over triples (Rousseeuw 1984).
    Points are then added one by one, best first, until the next residual is significant (forward
    search: Atkinson & Riani 2000; F test at 0.01 %). If there are fewer than six points, all are
    used.

    Parameters
    ----------
    source, target : (n, 3) array
    min_sigma : float
        Residual, in units of the target, below which points are always included.
    seed : int

    Returns
    -------
    fit : Similarity
    inliers : (n,) array of bool

    Raises
    ------
    GeometryError
        If there are fewer than three points, or they are collinear in either frame.
    """
    source_points = np.asarray(source, np.float64).reshape(-1, 3)
    target_points = np.asarray(target, np.float64).reshape(-1, 3)
    n = len(source_points)
    best_fit = fit_similarity(source_points, target_points)
    if n < _MIN_POINTS_ROBUST:
        return best_fit, np.ones(n, np.bool_)
    min_median_square = float(np.median(_squared_residuals(best_fit, source_points, target_points)))
    for triple in _triples(n, seed):
        try:
            trial = fit_similarity(source_points[triple], target_points[triple])
        except GeometryError:
            continue
        median = float(np.median(_squared_residuals(trial, source_points, target_points)))
        if median < min_median_square:
            best_fit, min_median_square = trial, median
    is_used = np.zeros(n, np.bool_)
    is_used[
        np.argsort(_squared_residuals(best_fit, source_points, target_points), kind="stable")[
            : max(4, n // 2 + 1)
        ]
    ] = True
    while True:
        try:
            best_fit = fit_similarity(source_points[is_used], target_points[is_used])
        except GeometryError:  # the best half is collinear
            return fit_similarity(source_points, target_points), np.ones(n, np.bool_)
        is_near = ~is_used & (
            _squared_residuals(best_fit, source_points, target_points) <= min_sigma**2
        )
        if is_near.any():
            is_used |= is_near
            continue
        new_inliers = _next_inliers(best_fit, source_points, target_points, is_used)
        if not len(new_inliers):
            return best_fit, is_used
        is_used[new_inliers] = True


def _triples(n: int, seed: int) -> IntArray:
    """Return the indices (t, 3) of all triples, or of random triples, of n points."""
    if math.comb(n, 3) <= _MAX_TRIPLES:
        return np.array(list(itertools.combinations(range(n), 3)))
    rng = np.random.default_rng(seed)
    return np.array([rng.choice(n, 3, replace=False) for _ in range(_MAX_TRIPLES)])


def _next_inliers(
    fit: Similarity, source_points: FloatArray, target_points: FloatArray, is_used: BoolArray
) -> IntArray:
    """Return the unused point that fits best, if it fits.

    If there are many points, several that fit well are returned.
    """
    from scipy.stats import chi2, f

    unused_rows = np.flatnonzero(~is_used)
    if not len(unused_rows):
        return np.empty(0, np.int64)
    count = int(is_used.sum())
    degrees_of_freedom = 3 * count - 7
    inlier_share = count / len(source_points)
    # The used points are those with the smallest residuals, so their scatter must be corrected.
    chi2_limit = chi2.ppf(inlier_share, 3)
    variance = (
        float(_squared_residuals(fit, source_points[is_used], target_points[is_used]).sum())
        / degrees_of_freedom
    )
    variance /= float(chi2.cdf(chi2_limit, 5) / inlier_share)
    placed_points = fit(source_points)
    design = jacobians(placed_points - placed_points[is_used].mean(axis=0))
    used_design = design[is_used].reshape(-1, 7)
    inverse = np.linalg.pinv(used_design.T @ used_design)
    unused_design = design[unused_rows]
    residuals = (target_points - placed_points)[unused_rows]
    covariances = np.eye(3) + unused_design @ inverse @ unused_design.transpose(0, 2, 1)
    statistic = (residuals * np.linalg.solve(covariances, residuals[..., None])[..., 0]).sum(axis=1)
    order = np.argsort(statistic, kind="stable")[: max(1, count // _STEP_DIVISOR)]
    limit = 3 * variance * float(f.ppf(_CONFIDENCE, 3, degrees_of_freedom))
    best_rows = unused_rows[order[:1]][statistic[order[:1]] <= limit]
    well_fitting_rows = unused_rows[order][statistic[order] <= _GOOD_FIT_SHARE * limit]
    return np.asarray(well_fitting_rows if len(well_fitting_rows) > 1 else best_rows, np.int64)


def jacobian(position: FloatArray) -> FloatArray:
    """Return the derivatives of a point by a small rotation, relative scale and translation.

    Parameters
    ----------
    position : (3,) ndarray

    Returns
    -------
    (3, 7) ndarray
    """
    return np.asarray(jacobians(position[None])[0])


def jacobians(positions: FloatArray) -> FloatArray:
    """Return the derivatives of several points; see `jacobian`.

    Parameters
    ----------
    positions : (n, 3) ndarray

    Returns
    -------
    (n, 3, 7) ndarray
    """
    derivatives: FloatArray = np.zeros((len(positions), 3, 7))
    x, y, z = positions.T
    derivatives[:, 0, 1], derivatives[:, 0, 2] = z, -y
    derivatives[:, 1, 0], derivatives[:, 1, 2] = -z, x
    derivatives[:, 2, 0], derivatives[:, 2, 1] = y, -x
    derivatives[:, :, 3] = positions
    derivatives[:, :, 4:] = np.eye(3)
    return derivatives


def _squared_residuals(
    transform: Similarity, source_points: FloatArray, target_points: FloatArray
) -> FloatArray:
    return np.asarray(((transform(source_points) - target_points) ** 2).sum(1))


def is_nearly_collinear(points: FloatArray) -> bool:
    """Return whether points are too collinear to determine the rotation about their line.

    Parameters
    ----------
    points : (n, 3) ndarray

    Returns
    -------
    bool
    """
    if len(points) < 3:
        return True
    axes = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(axes[1] < _NEARLY_COLLINEAR_RATIO * axes[0])


def rotation_covariance(positions: npt.ArrayLike, sigma: float | FloatArray) -> FloatArray:
    """Return the covariance (3, 3) of the rotation of a fitted similarity, in rad².

    The linear approximation is valid for errors up to about 20 degrees. About the line of collinear
    positions, the variance is 1e6.

    Parameters
    ----------
    positions : (n, 3) array
        Positions in the target frame.
    sigma : float or (3,) array
        Errors of the positions along the axes.
    """
    points = np.asarray(positions, np.float64).reshape(-1, 3)
    points = points - points.mean(axis=0)
    weight = np.diag(1 / np.broadcast_to(np.asarray(sigma, np.float64), 3) ** 2)
    # A small rotation w moves p by w x p; a change of scale moves it by p.
    information = np.zeros((4, 4))
    for position in points:
        # The translation is that of the mean.
        derivatives = jacobian(position)[:, :4]
        information += derivatives.T @ weight @ derivatives
    values, axes = np.linalg.eigh(information)
    with np.errstate(divide="ignore"):
        inverse = np.where(values > values[-1] * 1e-12, 1 / values, 1e6)
    return np.asarray((axes * inverse) @ axes.T)[:3, :3]
