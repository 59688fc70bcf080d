"""What a set of poles could be: on a great circle, a small circle, two great circles, in a cluster.

Residuals are angles from the curve. The great circle is that of the orientation tensor; the small
one (of a conical fold) is fitted by least squares of the angles (Gray, Geiser & Geiser 1980,
Mathematical Geology 12, 173-184), axially: a pole may stand for its opposite. That the small circle
is better is tested by F with 1 and n - 3 degrees of freedom, as there. Two great circles are a
mixture (expectation and maximisation), compared by Schwarz's (1978) criterion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.geology.folding.arcs import arc_deg, one_sided, rms
from vomstudio.geology.folding.limbs import NO_SCATTER_DEG, Limbs, limbs_of
from vomstudio.geology.orientation import Line
from vomstudio.geology.populations.probabilities import f_tail, t95
from vomstudio.geology.statistics import flip_to, orientation_tensor, vollmer

MIN_AROUND, MIN_GAIN = 10, 5.0
"""Number of poles, and gain in log likelihood, from which a circle by the nearer ends is used. At
this gain simulated cylinders are called cones as often as without it."""
MAX_SECOND_GAP_DEG = 60.0
"""Poles with two wider gaps around the axis are two groups, whose ends are not those of one cone:
those of two folds lie so."""
CONE_APART = 8.0
"""A wide cone shows at a glance if it is so many times its scatter away from the great circle: two
folds whose axes are 30 degrees apart lie near a cone too, at five times."""

MAX_SEARCHED, MAX_SWAPS = 500, 20

STRAY, STRAY_LEAST_DEG, STRAYS_ONE_IN = 4.0, 15.0, 7
"""Of planes that do not belong to a fold which the others show."""


@dataclass(frozen=True)
class SmallCircle:
    """A small circle: axis, angle between axis and poles (90 is a great circle), and RMS of the
    angles from it."""

    axis: Line
    half_angle_deg: float
    rms_deg: float


@dataclass(frozen=True)
class Cone:
    """The best small circle of poles.

    p : chance of so much better a fit than the great circle's where that is true
    half_width_deg : 95 % of the angle, infinite if the poles do not tell a cone from a cylinder
    log_likelihood : as `_log_likelihood`, of a mixture if the ends of the poles are not known
    by_nearer_ends : the circle of the least squares if each pole may be used by either end, where
        it is another one and closer to the poles, but not more likely
    """

    axis: Line
    half_angle_deg: float
    rms_deg: float
    p: float
    half_width_deg: float
    log_likelihood: float
    by_nearer_ends: SmallCircle | None = None

    @property
    def off_deg(self) -> float:
        """By how much it is no great circle."""
        return abs(90.0 - self.half_angle_deg)

    def of_more(self, n: int, more: int) -> Cone:
        """With the width that it would have, did so many planes show it instead of n."""
        if not math.isfinite(self.half_width_deg):
            return self
        wide = t95(n - 3) / math.sqrt(n - 3)
        return replace(
            self, half_width_deg=self.half_width_deg * t95(more - 3) / math.sqrt(more - 3) / wide
        )


@dataclass(frozen=True)
class TwoCircles:
    """Two great circles: their axes, how many poles are nearer to each, RMS of the angles from the
    nearer one; gain: by how much Schwarz's criterion prefers them to one curve (over 10 is very
    strong, Kass & Raftery 1995)."""

    first: Line
    second: Line
    counts: tuple[int, int]
    angle_deg: float
    rms_deg: float
    gain: float
    arcs_deg: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Shape:
    """What the poles (n, 3) look like, with the axes of their tensor.

    within90_deg: nine tenths of the poles lie closer to the great circle. spread_deg: RMS angle
    from their axial mean. cluster: Vollmer's P is the largest of his three indexes. cone,
    two_circles, limbs: None where there are too few, or none.
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
        """Looked for only where it is asked for: it takes the longest."""
        return two_great_circles(self.poles, self.axes, self.cone)

    @property
    def cluster(self) -> bool:
        return self.indexes[0] >= max(self.indexes[1:])


def shape_of(
    poles: FloatArray, values: FloatArray, axes: FloatArray, overturned: BoolArray | None = None
) -> Shape:
    """Of unit poles (n, 3) with their tensor; overturned : (n,), None where nothing is known."""
    off = np.degrees(np.abs(np.arcsin(np.clip(poles @ axes[2], -1.0, 1.0))))
    spread = np.degrees(np.arccos(np.minimum(np.abs(poles @ axes[0]), 1.0)))
    return Shape(
        poles,
        axes,
        rms(off),
        float(np.quantile(off, 0.9)),
        rms(spread),
        arc_deg(poles, axes),
        vollmer(values),
        small_circle(poles, axes),
        limbs_of(poles, axes, overturned),
    )


def strays_of(poles: FloatArray, axes: FloatArray) -> BoolArray:
    """(n,) which few poles lie far from the great circle on which the others lie: over `STRAY`
    times the others' scatter (by the median), and `STRAY_LEAST_DEG`. None where they are more than
    one in `STRAYS_ONE_IN`, or leave fewer than eight."""
    n, few = len(poles), poles
    rng = np.random.default_rng(2)
    if n > 500:
        few = poles[rng.choice(n, 500, replace=False)]
    pairs = rng.integers(0, len(few), (500, 2))
    normals = np.vstack([np.cross(few[pairs[:, 0]], few[pairs[:, 1]]), axes[2]])
    length = np.linalg.norm(normals, axis=1)
    normals = normals[length > 0.1] / length[length > 0.1, None]
    # Least absolute distances do not follow the strays; the tensor of the rest is exact.
    best = normals[int(np.argmin(np.abs(np.arcsin(np.clip(few @ normals.T, -1, 1))).sum(axis=0)))]
    stray = np.zeros(n, dtype=bool)
    for _ in range(3):
        off = np.degrees(np.abs(np.arcsin(np.clip(poles @ best, -1.0, 1.0))))
        stray = off > max(STRAY * 1.4826 * float(np.median(off)), STRAY_LEAST_DEG)
        if n - int(stray.sum()) < 8 or int(stray.sum()) * STRAYS_ONE_IN > n:
            return np.zeros(n, dtype=bool)
        best = orientation_tensor(poles[~stray])[1][2]
    return stray


# A small circle ---------------------------------------------------------------------------------


def small_circle(poles: FloatArray, axes: FloatArray) -> Cone | None:
    """Fit the best small circle; None for fewer than four poles.

    A pole has two ends. If the poles lie within an arc, their ends are those in the arc, and the
    circle is fitted to them. Around the axis of a cone, as in a dome, the ends are those on its
    side; but a scatter about a great circle also fits two small circles beside it, if each pole may
    choose its end. The second fit is therefore judged as a mixture of both ends, and is used only
    if its likelihood is clearly higher.
    """
    n = len(poles)
    if n < 4:
        return None
    axis, half_angle, residuals = _fitted_circle(one_sided(poles, axes))
    p, width = _cone_test(poles, axes, residuals)
    around = _fit_around_axis(poles, axes) if n >= MIN_AROUND else None
    likelihood = _log_likelihood(n, rms(residuals))
    nearer = None
    if around is not None and around.log_likelihood > likelihood + MIN_GAIN:
        likelihood = around.log_likelihood
        axis, half_angle, residuals = around.axis, around.half_angle, around.residuals
        p, width = _mixture_test(poles, axes, around)
    elif around is not None and rms(around.residuals) < rms(residuals) - 1e-6:
        nearer = _circle(around.axis, around.half_angle, around.residuals)
    circle = _circle(axis, half_angle, residuals)
    return Cone(circle.axis, circle.half_angle_deg, circle.rms_deg, p, width, likelihood, nearer)


def _circle(axis: FloatArray, half_angle: float, residuals: FloatArray) -> SmallCircle:
    half = math.degrees(half_angle)
    return SmallCircle(Line.from_vector(axis), min(half, 180.0 - half), rms(np.degrees(residuals)))


def _fitted_circle(x: FloatArray) -> tuple[FloatArray, float, FloatArray]:
    """Axis (3,), half-angle and residuals (n,), radians, of directions (n, 3)."""
    mean = x.mean(axis=0)
    axis = np.linalg.svd(x - mean, full_matrices=False)[2][2]
    half_angle = math.acos(min(max(float(mean @ axis), -1.0), 1.0))
    for _ in range(50):
        residuals = np.arccos(np.clip(x @ axis, -1.0, 1.0)) - half_angle
        design, across = _design(x, axis)
        # Of many poles the normal equations take a fraction of what lstsq does; its rcond squared.
        step = np.linalg.pinv(design.T @ design, 1e-12, hermitian=True) @ (design.T @ residuals)
        longest = float(np.abs(step).max())
        step *= min(1.0, 0.3 / max(longest, 1e-300))
        half_angle += float(step[0])
        axis = axis + across.T @ step[1:]
        axis = axis / np.linalg.norm(axis)
        if longest < 1e-9:
            break
    return axis, half_angle, np.arccos(np.clip(x @ axis, -1.0, 1.0)) - half_angle


@dataclass(frozen=True, eq=False)
class _Around:
    """Small circle of poles by their nearer ends.

    axis : (3,); half_angle : rad; residuals : (n,) rad; offset, sigma : distance of the circle from
    the plane across the axis and scatter about it, rad, by maximum likelihood with unknown ends
    """

    axis: FloatArray
    half_angle: float
    residuals: FloatArray
    poles: FloatArray
    offset: float
    sigma: float
    log_likelihood: float


def _fit_around_axis(poles: FloatArray, axes: FloatArray) -> _Around | None:
    """Fit the small circle with the least squares among those by the nearer ends of the poles.

    Each start alternates between choosing ends and fitting a plane to them; angles are fitted for
    the best of them.
    """
    few = poles[:: max(1, len(poles) // MAX_SEARCHED)]
    tried = np.concatenate([_STARTS_ON_HEMISPHERE, axes])
    for _ in range(MAX_SWAPS):
        ends = few * np.where(tried @ few.T < 0.0, -1.0, 1.0)[..., None]
        off = ends - ends.mean(axis=1, keepdims=True)
        changed = np.linalg.eigh(off.transpose(0, 2, 1) @ off)[1][..., 0]
        kept = np.abs(np.sum(changed * tried, axis=1)) > 1.0 - 1e-12
        tried = changed
        if kept.all():
            break
    angles = np.arccos(np.abs(np.clip(tried @ few.T, -1.0, 1.0)))
    best = tried[np.argmin(np.var(angles, axis=1))]
    for _ in range(MAX_SWAPS):
        ends = flip_to(poles, best)
        axis, half_angle, residuals = _fitted_circle(ends)
        if bool(((ends @ axis > 0) == (ends @ best > 0)).all()):
            break
        best = axis
    is_close = CONE_APART * rms(residuals) <= abs(math.pi / 2.0 - half_angle)
    if not is_close and _second_gap_deg(ends, axis) > MAX_SECOND_GAP_DEG:
        return None
    offset, sigma, likelihood = _unknown_ends(np.arcsin(np.clip(poles @ axis, -1.0, 1.0)))
    return _Around(axis, half_angle, residuals, ends, offset, sigma, likelihood)


def _second_gap_deg(ends: FloatArray, axis: FloatArray) -> float:
    """Return the second widest gap between directions (n, 3) around an axis."""
    across = np.linalg.svd(axis[None])[2][1:]
    x, y = (ends @ across.T).T
    turns = np.sort(np.degrees(np.arctan2(y, x)))
    gaps = np.diff(np.append(turns, turns[0] + 360.0))
    return float(np.sort(gaps)[-2])


def _hemisphere(n: int) -> FloatArray:
    """Return n directions spread over a hemisphere."""
    number = np.arange(n) + 0.5
    z = number / n
    turn = math.pi * (1.0 + math.sqrt(5.0)) * number
    radius = np.sqrt(1.0 - z * z)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), z])


_STARTS_ON_HEMISPHERE = _hemisphere(24)


def _unknown_ends(elevations: FloatArray) -> tuple[float, float, float]:
    """Fit a normal mixture with the means +offset and -offset to elevations (n,), rad.

    Returns offset, standard deviation and log likelihood (expectation and maximisation).
    """
    floor = math.radians(NO_SCATTER_DEG)
    square = float(np.mean(elevations**2))
    offset = float(np.mean(np.abs(elevations)))
    sigma = max(math.sqrt(max(square - offset**2, 0.0)), floor)
    for _ in range(200):
        balance = np.tanh(elevations * offset / sigma**2)
        changed = float(np.mean(balance * elevations))
        sigma = max(math.sqrt(max(square - changed**2, 0.0)), floor)
        if abs(changed - offset) < 1e-9:
            break
        offset = changed
    one = -0.5 * ((elevations - offset) / sigma) ** 2
    other = -0.5 * ((elevations + offset) / sigma) ** 2
    likelihood = float(np.sum(np.logaddexp(one, other))) - len(elevations) * math.log(2.0 * sigma)
    return offset, sigma, likelihood


def _log_likelihood(n: int, sigma: float) -> float:
    """Return that of n normal residuals, as `_unknown_ends`, less what is common to both."""
    return -n * math.log(max(sigma, math.radians(NO_SCATTER_DEG))) - 0.5 * n


def _mixture_test(poles: FloatArray, axes: FloatArray, around: _Around) -> tuple[float, float]:
    """Return p of the great circle against the small circle with unknown ends, and the 95 %
    half-width of its half-angle."""
    n = len(poles)
    on_great = np.arcsin(np.clip(poles @ axes[2], -1.0, 1.0))
    gain = around.log_likelihood - _log_likelihood(n, rms(on_great))
    free = n - 3
    # Of normal residuals with known ends this is the ratio of the sums of squares.
    p = f_tail(1, free, max(math.expm1(min(2.0 * gain / n, 700.0)), 0.0) * free)
    design, _ = _design(around.poles, around.axis)
    singular = np.linalg.svd(design, compute_uv=False)
    if singular[-1] <= 1e-6 * singular[0]:
        return p, math.inf
    spread = float(np.linalg.inv(design.T @ design)[0, 0])
    return p, math.degrees(t95(free) * around.sigma * math.sqrt(n / free * spread))


def _design(x: FloatArray, axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """By how much the angles grow with the half-angle and with tilts of the axis: (n, 3), and the
    directions (2, 3) of the tilts."""
    across = np.linalg.svd(axis[None])[2][1:]
    flat = x @ across.T
    length = np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-12)
    return np.column_stack([np.ones(len(x)), flat / length]), across


def _cone_test(poles: FloatArray, axes: FloatArray, residuals: FloatArray) -> tuple[float, float]:
    """p of the great circle against the small one, and the 95 % half-width of the half-angle; by
    where the poles lie along the great circle, as its error would be if that were the truth."""
    n = len(poles)
    design, _ = _design(one_sided(poles, axes), axes[2])
    singular = np.linalg.svd(design, compute_uv=False)
    told = bool(singular[-1] > 1e-6 * singular[0])
    on_great = np.arcsin(np.clip(poles @ axes[2], -1.0, 1.0))
    better, worse = float(np.sum(residuals**2)), float(np.sum(on_great**2))
    exact = math.degrees(math.sqrt(worse / n)) < NO_SCATTER_DEG
    if exact or not told:
        return 1.0, 0.0 if exact and told else math.inf
    free = n - 3
    variance = better / free
    if math.degrees(math.sqrt(variance)) < NO_SCATTER_DEG:
        return 0.0, 0.0
    p = f_tail(1, free, max(worse - better, 0.0) / variance)
    spread = float(np.linalg.inv(design.T @ design)[0, 0])
    return p, math.degrees(t95(free) * math.sqrt(variance * spread))


# Two great circles ------------------------------------------------------------------------------

_STARTS = 40
_FEWEST_FOR_TWO = 12


def two_great_circles(poles: FloatArray, axes: FloatArray, cone: Cone | None) -> TwoCircles | None:
    """The best two great circles, compared with the best one and with the cone; None of fewer than
    twelve poles, and where no two are much nearer to the poles than the best one."""
    n = len(poles)
    single = np.arcsin(np.clip(poles @ axes[2], -1.0, 1.0))
    if n < _FEWEST_FOR_TWO or math.degrees(rms(single)) < NO_SCATTER_DEG:
        return None
    rng = np.random.default_rng(1)
    # More poles than these do not change where the circles are sought.
    few = poles if n <= 500 else poles[rng.choice(n, 500, replace=False)]
    pairs = rng.integers(0, len(few), (_STARTS, 2))
    normals = np.cross(few[pairs[:, 0]], few[pairs[:, 1]])
    length = np.linalg.norm(normals, axis=1)
    normals = normals[length > 1e-3] / length[length > 1e-3, None]
    if len(normals) < 2:
        return None
    off = np.abs(np.arcsin(np.clip(few @ normals.T, -1.0, 1.0)))
    first, second = np.triu_indices(len(normals), 1)
    # Least of absolute distances: poles of the other circle pull less.
    cost = np.concatenate(
        [
            np.minimum(off[:, first[k : k + 100]], off[:, second[k : k + 100]]).sum(axis=0)
            for k in range(0, len(first), 100)
        ]
    )
    found = []
    best_of_one = float(np.sum(np.abs(np.arcsin(np.clip(few @ axes[2], -1.0, 1.0)))))
    if float(cost.min()) > 0.8 * best_of_one:
        return None
    for best in np.argsort(cost)[:3]:
        start = np.array([normals[first[best]], normals[second[best]]])
        found.append(_mixture(few, start, rms(single)))
    normals, logs = max(found, key=lambda each: each[1])
    if len(few) < n:
        normals, logs = _mixture(poles, normals, rms(single))
    return _two_circles(poles, cone, normals, logs, single)


def _mixture(poles: FloatArray, normals: FloatArray, sigma: float) -> tuple[FloatArray, float]:
    """Normals (2, 3) and log likelihood."""
    n, share = len(poles), 0.5
    likelihood = -math.inf
    for _ in range(100):
        off = np.arcsin(np.clip(poles @ normals.T, -1.0, 1.0))
        logs = -0.5 * (off / sigma) ** 2 - math.log(sigma) + np.log([share, 1.0 - share])
        top = logs.max(axis=1, keepdims=True)
        belong = np.exp(logs - top)
        total = belong.sum(axis=1, keepdims=True)
        new = float(np.sum(top[:, 0] + np.log(total[:, 0])))
        belong /= total
        if new - likelihood < 1e-5 * n:
            break
        likelihood = new
        share = float(np.clip(belong[:, 0].mean(), 1e-3, 1.0 - 1e-3))
        tensors = np.stack([(poles * belong[:, [k]]).T @ poles for k in (0, 1)])
        normals = np.linalg.eigh(tensors)[1][:, :, 0]
        off = np.arcsin(np.clip(poles @ normals.T, -1.0, 1.0))
        sigma = max(math.sqrt(float(np.sum(belong * off**2)) / n), math.radians(NO_SCATTER_DEG))
    return normals, likelihood


def _two_circles(
    poles: FloatArray, cone: Cone | None, normals: FloatArray, likelihood: float, single: FloatArray
) -> TwoCircles:
    n = len(poles)
    off = np.abs(np.arcsin(np.clip(poles @ normals.T, -1.0, 1.0)))
    nearer = np.argmin(off, axis=1)
    counts = (int((nearer == 0).sum()), int((nearer == 1).sum()))
    arcs = []
    for k in (0, 1):
        members = poles[nearer == k]
        arcs.append(arc_deg(members, orientation_tensor(members)[1]) if len(members) > 1 else 0.0)
    one = _criterion(n, _log_likelihood(n, rms(single)), 2)
    if cone is not None:
        one = min(one, _criterion(n, cone.log_likelihood, 3))
    two = -2.0 * likelihood + 5.0 * math.log(n)
    angle = math.degrees(math.acos(min(abs(float(normals[0] @ normals[1])), 1.0)))
    return TwoCircles(
        Line.from_vector(normals[0]),
        Line.from_vector(normals[1]),
        counts,
        angle,
        math.degrees(rms(off.min(axis=1))),
        one - two,
        (arcs[0], arcs[1]),
    )


def _criterion(n: int, log_likelihood: float, parameters: int) -> float:
    """Return Schwarz's criterion of one curve, less what is common to all."""
    return -2.0 * log_likelihood + parameters * math.log(n)
