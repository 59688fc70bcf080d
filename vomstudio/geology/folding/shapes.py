"""Shapes of sets of poles: great circle, small circle, two great circles or cluster.

Residuals are angles from the curve. The great circle is that of the orientation tensor. The small
circle (for a conical fold) is an axial least-squares fit of the angles (Gray, Geiser & Geiser 1980,
Mathematical Geology 12, 173-184): a pole may represent its opposite. As in this reference, both are
compared by an F test with 1 and n - 3 degrees of freedom. Two great circles are fitted as a mixture
(expectation maximisation) and compared by Schwarz's (1978) criterion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.geology.folding.arcs import arc_deg, flip_into_arc, rms
from vomstudio.geology.folding.limbs import MIN_SCATTER_DEG, Limbs, find_limbs
from vomstudio.geology.orientation import Line
from vomstudio.geology.populations.probabilities import f_tail, t95
from vomstudio.geology.statistics import flip_to_hemisphere, orientation_tensor, vollmer

MIN_POLES_FOR_NEARER_ENDS, MIN_LIKELIHOOD_GAIN = 10, 5.0
"""Minimum number of poles and minimum gain in log likelihood for a circle through the nearer ends
of poles. At this gain, simulated cylinders are classified as cones no more often than without it.
"""
MAX_SECOND_GAP_DEG = 60.0
"""Maximum second gap around the axis. Poles with two wider gaps form two groups, such as those of
two folds, whose ends do not belong to a single cone.
"""
MIN_CONE_SEPARATION = 8.0
"""Minimum distance of an obvious wide cone from the great circle, in units of its scatter. Two
folds whose axes are 30 degrees apart are also close to a cone, at five times its scatter.
"""

MAX_SEARCHED_POLES, MAX_ITERATIONS = 500, 20

MIN_OUTLIER_RATIO, MIN_OUTLIER_DEG, MIN_POLES_PER_OUTLIER = 4.0, 15.0, 7
"""Thresholds for planes that do not belong to the fold of the other planes."""


@dataclass(frozen=True)
class SmallCircle:
    """Small circle: axis, angle between axis and poles (90 for a great circle), and RMS angle."""

    axis: Line
    half_angle_deg: float
    rms_deg: float


@dataclass(frozen=True)
class Cone:
    """Best-fit small circle of poles.

    Attributes
    ----------
    p : float
        p-value of the great circle tested against the small circle.
    half_width_deg : float
        Half-width of the 95 % interval of the half-angle, degrees; infinite if the poles cannot
        distinguish a cone from a cylinder.
    log_likelihood : float
        Log likelihood of `_log_likelihood`, or of a mixture if the ends of the poles are unknown.
    nearer_ends_circle : SmallCircle or None
        Least-squares circle if either end of a pole may be used. It is stored only if it is
        closer to the poles but not clearly more likely.
    """

    axis: Line
    half_angle_deg: float
    rms_deg: float
    p: float
    half_width_deg: float
    log_likelihood: float
    nearer_ends_circle: SmallCircle | None = None

    @property
    def deviation_deg(self) -> float:
        """Difference between the half-angle and that of a great circle, degrees."""
        return abs(90.0 - self.half_angle_deg)

    def with_count(self, n: int, n_expected: int) -> Cone:
        """Return the cone with the interval width expected for another number of planes.

        `n` is the number of planes of this cone.
        """
        if not math.isfinite(self.half_width_deg):
            return self
        width = t95(n - 3) / math.sqrt(n - 3)
        return replace(
            self,
            half_width_deg=self.half_width_deg
            * t95(n_expected - 3)
            / math.sqrt(n_expected - 3)
            / width,
        )


@dataclass(frozen=True)
class TwoCircles:
    """Two great circles fitted to poles.

    Attributes
    ----------
    first, second : Line
        Axes of the circles.
    counts : (int, int)
        Number of poles nearer to each circle.
    angle_deg : float
        Angle between the axes, degrees.
    rms_deg : float
        RMS angle between the poles and the nearer circle, degrees.
    gain : float
        Improvement over one curve by Schwarz's criterion; above 10 it is very strong (Kass &
        Raftery 1995).
    """

    first: Line
    second: Line
    counts: tuple[int, int]
    angle_deg: float
    rms_deg: float
    gain: float
    arcs_deg: tuple[float, float]


@dataclass(frozen=True, eq=False)
class PoleShape:
    """Shape of poles (n, 3), with the axes of their orientation tensor.

    Attributes
    ----------
    within90_deg : float
        Angle from the great circle within which 90 % of the poles lie, degrees.
    spread_deg : float
        RMS angle between the poles and their axial mean, degrees.
    is_cluster : bool
        True if Vollmer's P is the largest of the three indices.
    cone, two_circles, limbs
        None if there are too few poles, or if the fit was not successful.
    """

    poles: FloatArray
    axes: FloatArray
    rms_deg: float
    within90_deg: float
    spread_deg: float
    arc_deg: float
    indexes: tuple[float, float, float]
    cone: Cone | None
    limbs: Limbs | None

    @property
    def n(self) -> int:
        return len(self.poles)

    @cached_property
    def two_circles(self) -> TwoCircles | None:
        """Two great circles through the poles, or None if they do not fit much better than one.

        They are computed on first use because this is slow.
        """
        return two_great_circles(self.poles, self.axes, self.cone)

    @property
    def is_cluster(self) -> bool:
        return self.indexes[0] >= max(self.indexes[1:])


def describe_shape(
    poles: FloatArray,
    eigenvalues: FloatArray,
    axes: FloatArray,
    overturned: BoolArray | None = None,
) -> PoleShape:
    """Describe the shape of poles, given the eigenvalues and axes of their tensor.

    Parameters
    ----------
    poles : (n, 3) ndarray
        Unit vectors.
    eigenvalues : (3,) ndarray
        Eigenvalues of the orientation tensor.
    axes : (3, 3) ndarray
        Eigenvectors of the orientation tensor as rows.
    overturned : (n,) ndarray of bool, optional
        Overturned flags; None if unknown.

    Returns
    -------
    PoleShape
    """
    deviations_deg = np.degrees(np.abs(np.arcsin(np.clip(poles @ axes[2], -1.0, 1.0))))
    angles_deg = np.degrees(np.arccos(np.minimum(np.abs(poles @ axes[0]), 1.0)))
    return PoleShape(
        poles,
        axes,
        rms(deviations_deg),
        float(np.quantile(deviations_deg, 0.9)),
        rms(angles_deg),
        arc_deg(poles, axes),
        vollmer(eigenvalues),
        fit_small_circle(poles, axes),
        find_limbs(poles, axes, overturned),
    )


def find_outliers(poles: FloatArray, axes: FloatArray) -> BoolArray:
    """Find a few poles that are far from the great circle of the others.

    Returns
    -------
    (n,) ndarray of bool
        Poles farther from the circle than `MIN_OUTLIER_DEG` and than `MIN_OUTLIER_RATIO` times the
        scatter, which is estimated from the median deviation. All values are False if more than
        one in `MIN_POLES_PER_OUTLIER` poles is an outlier, or if fewer than eight others remain.
    """
    n, sample = len(poles), poles
    rng = np.random.default_rng(2)
    if n > 500:
        sample = poles[rng.choice(n, 500, replace=False)]
    pairs = rng.integers(0, len(sample), (500, 2))
    normals = np.vstack([np.cross(sample[pairs[:, 0]], sample[pairs[:, 1]]), axes[2]])
    length = np.linalg.norm(normals, axis=1)
    normals = normals[length > 0.1] / length[length > 0.1, None]
    # Least absolute distances are robust against outliers; the tensor of the others is exact.
    normal = normals[
        int(np.argmin(np.abs(np.arcsin(np.clip(sample @ normals.T, -1, 1))).sum(axis=0)))
    ]
    is_outlier = np.zeros(n, dtype=bool)
    for _ in range(3):
        deviations_deg = np.degrees(np.abs(np.arcsin(np.clip(poles @ normal, -1.0, 1.0))))
        is_outlier = deviations_deg > max(
            MIN_OUTLIER_RATIO * 1.4826 * float(np.median(deviations_deg)), MIN_OUTLIER_DEG
        )
        if n - int(is_outlier.sum()) < 8 or int(is_outlier.sum()) * MIN_POLES_PER_OUTLIER > n:
            return np.zeros(n, dtype=bool)
        normal = orientation_tensor(poles[~is_outlier])[1][2]
    return is_outlier


# A small circle ---------------------------------------------------------------------------------


def fit_small_circle(poles: FloatArray, axes: FloatArray) -> Cone | None:
    """Fit the best small circle to poles, or return None for fewer than four poles.

    A pole has two ends. If the poles lie within an arc, the circle is fitted to the ends within the
    arc. Around the axis of a cone, as in a dome, the ends on the side of the axis are used.
    However, poles scattered about a great circle also fit two small circles beside it if either end
    of each pole may be used. The second fit is therefore evaluated as a mixture of both ends, and
    used only if its likelihood is clearly higher.

    Parameters
    ----------
    poles : (n, 3) ndarray
    axes : (3, 3) ndarray
        Eigenvectors of the orientation tensor.

    Returns
    -------
    Cone or None
    """
    n = len(poles)
    if n < 4:
        return None
    axis, half_angle, residuals = _fit_circle(flip_into_arc(poles, axes))
    p, width = _test_cone(poles, axes, residuals)
    nearer_ends_fit = _fit_nearer_ends(poles, axes) if n >= MIN_POLES_FOR_NEARER_ENDS else None
    log_likelihood = _log_likelihood(n, rms(residuals))
    nearer_ends_circle = None
    if (
        nearer_ends_fit is not None
        and nearer_ends_fit.log_likelihood > log_likelihood + MIN_LIKELIHOOD_GAIN
    ):
        log_likelihood = nearer_ends_fit.log_likelihood
        axis, half_angle, residuals = (
            nearer_ends_fit.axis,
            nearer_ends_fit.half_angle,
            nearer_ends_fit.residuals,
        )
        p, width = _test_mixture(poles, axes, nearer_ends_fit)
    elif nearer_ends_fit is not None and rms(nearer_ends_fit.residuals) < rms(residuals) - 1e-6:
        nearer_ends_circle = _build_circle(
            nearer_ends_fit.axis, nearer_ends_fit.half_angle, nearer_ends_fit.residuals
        )
    circle = _build_circle(axis, half_angle, residuals)
    return Cone(
        circle.axis,
        circle.half_angle_deg,
        circle.rms_deg,
        p,
        width,
        log_likelihood,
        nearer_ends_circle,
    )


def _build_circle(axis: FloatArray, half_angle: float, residuals: FloatArray) -> SmallCircle:
    half_angle_deg = math.degrees(half_angle)
    return SmallCircle(
        Line.from_vector(axis),
        min(half_angle_deg, 180.0 - half_angle_deg),
        rms(np.degrees(residuals)),
    )


def _fit_circle(
    x: FloatArray, start_axis: FloatArray | None = None
) -> tuple[FloatArray, float, FloatArray]:
    """Return the axis (3,), half-angle and residuals (n,) of directions (n, 3), radians.

    If no start axis is given, the search begins at the normal of the plane through the directions.
    """
    mean = x.mean(axis=0)
    axis = np.linalg.svd(x - mean, full_matrices=False)[2][2] if start_axis is None else start_axis
    half_angle = math.acos(min(max(float(mean @ axis), -1.0), 1.0))
    for _ in range(50):
        residuals = np.arccos(np.clip(x @ axis, -1.0, 1.0)) - half_angle
        design, cross_axes = _design_matrix(x, axis)
        # For many poles, the normal equations are much faster than lstsq (rcond is squared).
        step = np.linalg.pinv(design.T @ design, 1e-12, hermitian=True) @ (design.T @ residuals)
        max_step = float(np.abs(step).max())
        step *= min(1.0, 0.3 / max(max_step, 1e-300))
        half_angle += float(step[0])
        axis = axis + cross_axes.T @ step[1:]
        axis = axis / np.linalg.norm(axis)
        if max_step < 1e-9:
            break
    return axis, half_angle, np.arccos(np.clip(x @ axis, -1.0, 1.0)) - half_angle


@dataclass(frozen=True, eq=False)
class _NearerEndsFit:
    """Small circle through the nearer ends of poles.

    Attributes
    ----------
    axis : (3,) ndarray
    half_angle : float
        Half-angle in radians.
    residuals : (n,) ndarray
        Residuals in radians.
    offset, sigma : float
        Maximum-likelihood estimates with unknown ends: distance of the circle from the plane normal
        to the axis, and scatter about the circle, radians.
    """

    axis: FloatArray
    half_angle: float
    residuals: FloatArray
    poles: FloatArray
    offset: float
    sigma: float
    log_likelihood: float


def _fit_nearer_ends(poles: FloatArray, axes: FloatArray) -> _NearerEndsFit | None:
    """Find the least-squares small circle through the nearer ends of the poles.

    From each start, the selection of ends and the fit of a plane to them alternate; the angles are
    fitted for the best result only. Returns None if the
    ends form two groups around the axis.
    """
    sample = poles[:: max(1, len(poles) // MAX_SEARCHED_POLES)]
    candidates = np.concatenate([START_DIRECTIONS, axes])
    for _ in range(MAX_ITERATIONS):
        ends = sample * np.where(candidates @ sample.T < 0.0, -1.0, 1.0)[..., None]
        centred_ends = ends - ends.mean(axis=1, keepdims=True)
        updated_axes = np.linalg.eigh(centred_ends.transpose(0, 2, 1) @ centred_ends)[1][..., 0]
        has_converged = np.abs(np.sum(updated_axes * candidates, axis=1)) > 1.0 - 1e-12
        candidates = updated_axes
        if has_converged.all():
            break
    angles = np.arccos(np.abs(np.clip(candidates @ sample.T, -1.0, 1.0)))
    axis_estimate = candidates[np.argmin(np.var(angles, axis=1))]
    if len(sample) < len(poles):
        axis_estimate = _alternate_ends(sample, axis_estimate)[1]
    ends, axis, half_angle, residuals = _alternate_ends(poles, axis_estimate)
    is_obvious_cone = MIN_CONE_SEPARATION * rms(residuals) <= abs(math.pi / 2.0 - half_angle)
    if not is_obvious_cone and _second_gap_deg(ends, axis) > MAX_SECOND_GAP_DEG:
        return None
    offset, sigma, log_likelihood = _fit_unknown_ends(np.arcsin(np.clip(poles @ axis, -1.0, 1.0)))
    return _NearerEndsFit(axis, half_angle, residuals, ends, offset, sigma, log_likelihood)


def _alternate_ends(
    poles: FloatArray, axis_estimate: FloatArray
) -> tuple[FloatArray, FloatArray, float, FloatArray]:
    """Alternate the selection of ends and the fit until the ends no longer change.

    Returns
    -------
    ends : (n, 3) ndarray
    axis : (3,) ndarray
    half_angle : float
        In radians.
    residuals : (n,) ndarray
        In radians.
    """
    for _ in range(MAX_ITERATIONS):
        ends = flip_to_hemisphere(poles, axis_estimate)
        axis, half_angle, residuals = _fit_circle(ends, axis_estimate)
        if bool(((ends @ axis > 0) == (ends @ axis_estimate > 0)).all()):
            break
        axis_estimate = axis
    return ends, axis, half_angle, residuals


def _second_gap_deg(ends: FloatArray, axis: FloatArray) -> float:
    """Return the second widest gap between directions (n, 3) around an axis, degrees."""
    cross_axes = np.linalg.svd(axis[None])[2][1:]
    x, y = (ends @ cross_axes.T).T
    sorted_angles = np.sort(np.degrees(np.arctan2(y, x)))
    gaps = np.diff(np.append(sorted_angles, sorted_angles[0] + 360.0))
    return float(np.sort(gaps)[-2])


def _hemisphere_directions(n: int) -> FloatArray:
    """Return n directions distributed over a hemisphere."""
    index = np.arange(n) + 0.5
    z = index / n
    angle = math.pi * (1.0 + math.sqrt(5.0)) * index
    radius = np.sqrt(1.0 - z * z)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])


START_DIRECTIONS = _hemisphere_directions(24)


def _fit_unknown_ends(elevations: FloatArray) -> tuple[float, float, float]:
    """Fit a normal mixture with the means +offset and -offset to elevations (n,), radians.

    Return the offset, the standard deviation and the log likelihood (expectation maximisation).
    """
    min_sigma = math.radians(MIN_SCATTER_DEG)
    square = float(np.mean(elevations**2))
    offset = float(np.mean(np.abs(elevations)))
    sigma = max(math.sqrt(max(square - offset**2, 0.0)), min_sigma)
    for _ in range(200):
        expected_signs = np.tanh(elevations * offset / sigma**2)
        updated_offset = float(np.mean(expected_signs * elevations))
        sigma = max(math.sqrt(max(square - updated_offset**2, 0.0)), min_sigma)
        if abs(updated_offset - offset) < 1e-7:
            break
        offset = updated_offset
    first_log_terms = -0.5 * ((elevations - offset) / sigma) ** 2
    second_log_terms = -0.5 * ((elevations + offset) / sigma) ** 2
    log_likelihood = float(np.sum(np.logaddexp(first_log_terms, second_log_terms))) - len(
        elevations
    ) * math.log(2.0 * sigma)
    return offset, sigma, log_likelihood


def _log_likelihood(n: int, sigma: float) -> float:
    """Return the log likelihood of n normal residuals, without terms common to all models."""
    return -n * math.log(max(sigma, math.radians(MIN_SCATTER_DEG))) - 0.5 * n


def _test_mixture(
    poles: FloatArray, axes: FloatArray, nearer_ends_fit: _NearerEndsFit
) -> tuple[float, float]:
    """Test the great circle against the small circle with unknown ends.

    Returns
    -------
    p : float
    half_width_deg : float
        Half-width of the 95 % interval of the half-angle.
    """
    n = len(poles)
    great_circle_angles = np.arcsin(np.clip(poles @ axes[2], -1.0, 1.0))
    log_likelihood_gain = nearer_ends_fit.log_likelihood - _log_likelihood(
        n, rms(great_circle_angles)
    )
    dof = n - 3
    # For normal residuals with known ends, this is the ratio of the sums of squares.
    p = f_tail(1, dof, max(math.expm1(min(2.0 * log_likelihood_gain / n, 700.0)), 0.0) * dof)
    design, _ = _design_matrix(nearer_ends_fit.poles, nearer_ends_fit.axis)
    singular_values = np.linalg.svd(design, compute_uv=False)
    if singular_values[-1] <= 1e-6 * singular_values[0]:
        return p, math.inf
    variance = float(np.linalg.inv(design.T @ design)[0, 0])
    return p, math.degrees(t95(dof) * nearer_ends_fit.sigma * math.sqrt(n / dof * variance))


def _design_matrix(x: FloatArray, axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the derivatives (n, 3) of the angles with respect to half-angle and axis tilts.

    The directions (2, 3) of the tilts are also returned.
    """
    cross_axes = np.linalg.svd(axis[None])[2][1:]
    plane_components = x @ cross_axes.T
    length = np.maximum(np.linalg.norm(plane_components, axis=1, keepdims=True), 1e-12)
    return np.column_stack([np.ones(len(x)), plane_components / length]), cross_axes


def _test_cone(poles: FloatArray, axes: FloatArray, residuals: FloatArray) -> tuple[float, float]:
    """Return the p-value of the great circle against the cone, and the half-angle error.

    The 95 % error assumes that the poles lie on the great circle.
    """
    n = len(poles)
    design, _ = _design_matrix(flip_into_arc(poles, axes), axes[2])
    singular_values = np.linalg.svd(design, compute_uv=False)
    is_determined = bool(singular_values[-1] > 1e-6 * singular_values[0])
    great_circle_angles = np.arcsin(np.clip(poles @ axes[2], -1.0, 1.0))
    cone_squares, cylinder_squares = (
        float(np.sum(residuals**2)),
        float(np.sum(great_circle_angles**2)),
    )
    is_exact = math.degrees(math.sqrt(cylinder_squares / n)) < MIN_SCATTER_DEG
    if is_exact or not is_determined:
        return 1.0, 0.0 if is_exact and is_determined else math.inf
    dof = n - 3
    variance = cone_squares / dof
    if math.degrees(math.sqrt(variance)) < MIN_SCATTER_DEG:
        return 0.0, 0.0
    p = f_tail(1, dof, max(cylinder_squares - cone_squares, 0.0) / variance)
    spread = float(np.linalg.inv(design.T @ design)[0, 0])
    return p, math.degrees(t95(dof) * math.sqrt(variance * spread))


# Two great circles ------------------------------------------------------------------------------

N_STARTS = 40
MIN_POLES_FOR_TWO_CIRCLES = 12


def two_great_circles(poles: FloatArray, axes: FloatArray, cone: Cone | None) -> TwoCircles | None:
    """Fit two great circles and compare them with the best single circle and the cone.

    Returns
    -------
    TwoCircles or None
        None for fewer than twelve poles, or if no two circles are much closer to the poles.
    """
    n = len(poles)
    single_residuals = np.arcsin(np.clip(poles @ axes[2], -1.0, 1.0))
    if n < MIN_POLES_FOR_TWO_CIRCLES or math.degrees(rms(single_residuals)) < MIN_SCATTER_DEG:
        return None
    rng = np.random.default_rng(1)
    # More poles do not improve the start values.
    sample = poles if n <= 500 else poles[rng.choice(n, 500, replace=False)]
    pairs = rng.integers(0, len(sample), (N_STARTS, 2))
    normals = np.cross(sample[pairs[:, 0]], sample[pairs[:, 1]])
    length = np.linalg.norm(normals, axis=1)
    normals = normals[length > 1e-3] / length[length > 1e-3, None]
    if len(normals) < 2:
        return None
    angles = np.abs(np.arcsin(np.clip(sample @ normals.T, -1.0, 1.0)))
    first_rows, second_rows = np.triu_indices(len(normals), 1)
    # Absolute distances reduce the influence of the poles of the other circle.
    cost = np.concatenate(
        [
            np.minimum(angles[:, first_rows[k : k + 100]], angles[:, second_rows[k : k + 100]]).sum(
                axis=0
            )
            for k in range(0, len(first_rows), 100)
        ]
    )
    mixtures = []
    single_cost = float(np.sum(np.abs(np.arcsin(np.clip(sample @ axes[2], -1.0, 1.0)))))
    if float(cost.min()) > 0.8 * single_cost:
        return None
    for pair_index in np.argsort(cost)[:3]:
        start = np.array([normals[first_rows[pair_index]], normals[second_rows[pair_index]]])
        mixtures.append(_fit_mixture(sample, start, rms(single_residuals)))
    normals, log_likelihood = max(mixtures, key=lambda mixture: mixture[1])
    if len(sample) < n:
        normals, log_likelihood = _fit_mixture(poles, normals, rms(single_residuals))
    return _build_two_circles(poles, cone, normals, log_likelihood, single_residuals)


def _fit_mixture(poles: FloatArray, normals: FloatArray, sigma: float) -> tuple[FloatArray, float]:
    """Return the normals (2, 3) of two circles, and the log likelihood."""
    n, fraction = len(poles), 0.5
    log_likelihood = -math.inf
    for _ in range(100):
        angles = np.arcsin(np.clip(poles @ normals.T, -1.0, 1.0))
        log_terms = (
            -0.5 * (angles / sigma) ** 2 - math.log(sigma) + np.log([fraction, 1.0 - fraction])
        )
        max_log_terms = log_terms.max(axis=1, keepdims=True)
        membership = np.exp(log_terms - max_log_terms)
        totals = membership.sum(axis=1, keepdims=True)
        updated_log_likelihood = float(np.sum(max_log_terms[:, 0] + np.log(totals[:, 0])))
        membership /= totals
        if updated_log_likelihood - log_likelihood < 1e-5 * n:
            break
        log_likelihood = updated_log_likelihood
        fraction = float(np.clip(membership[:, 0].mean(), 1e-3, 1.0 - 1e-3))
        tensors = np.stack([(poles * membership[:, [k]]).T @ poles for k in (0, 1)])
        normals = np.linalg.eigh(tensors)[1][:, :, 0]
        angles = np.arcsin(np.clip(poles @ normals.T, -1.0, 1.0))
        sigma = max(
            math.sqrt(float(np.sum(membership * angles**2)) / n), math.radians(MIN_SCATTER_DEG)
        )
    return normals, log_likelihood


def _build_two_circles(
    poles: FloatArray,
    cone: Cone | None,
    normals: FloatArray,
    log_likelihood: float,
    single_residuals: FloatArray,
) -> TwoCircles:
    n = len(poles)
    angles = np.abs(np.arcsin(np.clip(poles @ normals.T, -1.0, 1.0)))
    nearest_circles = np.argmin(angles, axis=1)
    counts = (int((nearest_circles == 0).sum()), int((nearest_circles == 1).sum()))
    arcs = []
    for k in (0, 1):
        members = poles[nearest_circles == k]
        arcs.append(arc_deg(members, orientation_tensor(members)[1]) if len(members) > 1 else 0.0)
    single_criterion = _schwarz_criterion(n, _log_likelihood(n, rms(single_residuals)), 2)
    if cone is not None:
        single_criterion = min(single_criterion, _schwarz_criterion(n, cone.log_likelihood, 3))
    criterion = -2.0 * log_likelihood + 5.0 * math.log(n)
    angle = math.degrees(math.acos(min(abs(float(normals[0] @ normals[1])), 1.0)))
    return TwoCircles(
        Line.from_vector(normals[0]),
        Line.from_vector(normals[1]),
        counts,
        angle,
        math.degrees(rms(angles.min(axis=1))),
        single_criterion - criterion,
        (arcs[0], arcs[1]),
    )


def _schwarz_criterion(n: int, log_likelihood: float, n_parameters: int) -> float:
    """Return Schwarz's criterion of a curve, without terms common to all curves."""
    return -2.0 * log_likelihood + n_parameters * math.log(n)
