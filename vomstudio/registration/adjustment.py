"""A similarity by everything that is known of it at once, and how well it then is known.

Weighted least squares over the seven numbers of `observations`, from several starts (Gauss-Newton).
Where accuracies are not stated, those of each group of rows are estimated together with the
similarity (iterated variance components; Foerstner 1979, Z. f. Vermessungswesen 104, 149), and what
is stated from few of them is widened as Student's t asks, with Satterthwaite's degrees of freedom.
What fits well by itself is not made out to be bad because something else contradicts it: a group's
error is that of the group alone where it would be larger by more than chance.
What nothing determines stays as it is in the model's file, tilts before turns about the vertical.
The covariance is that of linear least squares: good for rotations known to some 20 degrees.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.registration.combined import Combined
from vomstudio.registration.compass_checks import rotations_by_pairs
from vomstudio.registration.observations import (
    Attitudes,
    Directions,
    KeptScale,
    Observed,
    Points,
    Rows,
    all_rows,
)
from vomstudio.registration.row_errors import (
    METRES,
    drift_of,
    estimated,
    inverse_of,
    left_over,
    most_times,
    spread_of,
    system_of,
)
from vomstudio.registration.similarity import Similarity, fit_similarity, nearly_on_a_line

_STARTS = 400
_FOLLOWED = 6
_STEPS = 60
_SMALL = 1e-11
# Starts are only compared with each other: the one that is chosen is followed to the end.
_SMALL_START = 1e-6
_SURE = 0.99
# Free misses that say something of an error.
_FEWEST_ALONE = 1.5
# What rows without a stated error are taken to be as good as, where nothing is left over to judge
# them by: metres as a share of the model's size, radians.
_USUAL_SHARE = 0.01
_USUAL_RAD = np.radians(3.0)
# Starts that end with this much more than the least sum of squares fit as well by chance.
AS_GOOD = 9.0
# Of its error: what misses by more counts less and less.
_CAUCHY = 3.0
_BESIDE = 0.3
# Rotations that differ by more than this (rad) are not the same one.
_APART = 0.2


@dataclass(frozen=True, eq=False)
class Adjusted:
    """fit : model to World; centre : (3,) World, what it turns and grows about
    covariance : (7, 7) of a turn about east, north, up (rad), a relative change of scale and a
        shift (metres), one sigma of a normal distribution with the same 95 % as Student's; only
        what is determined counts, see `free`
    plain : (7, 7) the same without Student's widening
    free : (7, k) directions of the seven numbers that nothing determines, orthonormal in units of
        the model's size
    rows, sigma, error : of all observations, the errors by which they entered the fit, and those
        that their misses show, one sigma
    begins : (kinds + 1,) where the rows of each kind begin
    assumed : names of groups whose error could not be judged and was taken as usual
    overdrawn : how many times larger the misses are than what was stated; 1 where they agree
    ambiguous : a quite different rotation fits as well
    free_of : of each group whose error is not stated, how many free misses it rests on
    drift : correlation of the errors of neighbours in a table, by group ("points", "cameras");
        without the groups whose errors are independent
    common, common_covariance : (k,) and (k, k) of the errors that rows share, in the order of
        `rows.shared_names`
    """

    fit: Similarity
    centre: FloatArray
    covariance: FloatArray
    plain: FloatArray
    free: FloatArray
    rows: Rows
    sigma: FloatArray
    error: FloatArray
    begins: tuple[int, ...]
    assumed: tuple[str, ...]
    overdrawn: float
    ambiguous: bool
    size: float
    redundancy: float
    information: FloatArray
    common: FloatArray
    common_covariance: FloatArray
    free_of: Mapping[str, float]
    drift: Mapping[str, float]

    @property
    def rotation(self) -> FloatArray:
        """(3, 3) radians squared, about east, north, up."""
        return self.covariance[:3, :3]


@dataclass(frozen=True, eq=False)
class _Problem:
    """kinds, centre, size : as of `adjust`; alone : as of `_alone`"""

    kinds: Sequence[Observed]
    centre: FloatArray
    size: float
    alone: Mapping[str, tuple[float, float]]

    def at(self, fit: Similarity) -> tuple[Rows, list[int], FloatArray]:
        """The rows there, where those of each kind begin, and (3,) what they turn about."""
        place = fit(self.centre)[0]
        return (*all_rows(self.kinds, fit, place), place)


def adjust(kinds: Sequence[Observed], centre: FloatArray, size: float) -> Adjusted:
    """The similarity from the model to World.

    centre : (1, 3) model, what it turns about where nothing places it; size : of the model, in its
    unit (a typical distance from the centre)
    Raises GeometryError where nothing at all is given.
    """
    if not any(len(kind.labels) for kind in kinds):
        raise GeometryError(Finding("registration.no-observations"))
    offset = _offset(kinds)
    kinds = [_shifted(kind, offset) for kind in kinds]
    alone = _alone(kinds, centre, size)
    problem = _Problem(kinds, centre, size, alone)
    ended = [_followed(problem, start) for start in _agreed_by_most(problem, _starts(problem))]
    least = min(cost for _, cost in ended)
    good = [fit for fit, cost in ended if cost <= least + AS_GOOD]
    # Of those that fit alike the one that tilts the model least, then the one that turns it least.
    good.sort(key=lambda fit: (round(_tilt_of(fit.rotation), 3), _angle_of(fit.rotation)))
    found = _judged(problem, good[0])
    # Where turns are free, others fit as well by themselves.
    held = not found.free.shape[1] or np.abs(found.free[:3]).max() < 1e-6
    apart = any(_angle_of(good[0].rotation.T @ fit.rotation) > _APART for fit in good)
    found = replace(_add_scale_error(kinds, found), ambiguous=bool(held and apart))
    fit = replace(found.fit, translation=found.fit.translation + offset)
    return replace(found, fit=fit, centre=found.centre + offset)


def _add_scale_error(kinds: Sequence[Observed], result: Adjusted) -> Adjusted:
    """Add the error of a fixed scale to the covariance of a fit.

    The fit is unchanged. The covariance of its seven parameters grows by their response to the
    error of the scale, which no observation determines.
    """
    change, error = np.zeros(len(result.rows.misses)), 0.0
    kinds = [kind for kind in kinds if len(kind.labels)]
    for kind, first, end in zip(kinds, result.begins, result.begins[1:], strict=False):
        if isinstance(kind, Combined | KeptScale) and kind.scale_error > 0:
            # All these observations share one scale error.
            change[first:end] = kind.scale_change
            error = max(error, kind.scale_error)
    if not error > 0:
        return result
    moves, _, units = system_of(result.rows, result.sigma, result.size)
    inverse, _ = inverse_of(moves.T @ moves)
    step = -inverse @ (moves[: len(change)].T @ (change / result.sigma))
    response = error * (step * units)[:7]
    added = np.outer(response, response)
    return replace(result, covariance=result.covariance + added, plain=result.plain + added)


def _alone(
    kinds: Sequence[Observed], centre: FloatArray, size: float
) -> dict[str, tuple[float, float]]:
    """Of each group of points and attitudes without a stated error the variance by the misses of
    its kind alone, and how many free ones there are; of kinds that stand beside others only."""
    kinds = [kind for kind in kinds if len(kind.labels)]
    # A scale that is kept stands for every one of them.
    kept = [kind for kind in kinds if isinstance(kind, KeptScale)]
    kinds = [kind for kind in kinds if not isinstance(kind, KeptScale)]
    found: dict[str, tuple[float, float]] = {}
    for kind in kinds if len(kinds) > 1 else ():
        # Planes have many starts, which would take longer than all else.
        if not isinstance(kind, Points | Attitudes) or np.isfinite(kind.sigma).all():
            continue
        one = adjust([kind, *kept], centre, size)
        groups = np.array(one.rows.groups)
        unknown = ~np.isfinite(one.rows.sigma)
        for name, free in one.free_of.items():
            if free >= _FEWEST_ALONE:
                sigma = one.sigma[unknown & (groups == name)]
                found[name] = float(sigma[0] ** 2), free
    return found


def _shifted(kind: Observed, offset: FloatArray) -> Observed:
    if isinstance(kind, Points):
        return replace(kind, world=kind.world - offset)
    if isinstance(kind, Combined):
        start = replace(kind.start, translation=kind.start.translation - offset)
        return replace(kind, start=start, about=kind.about - offset)
    return kind


def _offset(kinds: Sequence[Observed]) -> FloatArray:
    """(3,) where the points are in World: near them, no digits are lost to large coordinates."""
    points = [kind.world for kind in kinds if isinstance(kind, Points)]
    points += [kind.about[None] for kind in kinds if isinstance(kind, Combined)]
    return np.round(np.concatenate(points).mean(axis=0)) if points else np.zeros(3)


# --- starts -----------------------------------------------------------------------------------
def _starts(problem: _Problem) -> list[Similarity]:
    from scipy.spatial.transform import Rotation

    kinds, centre = problem.kinds, problem.centre
    for kind in kinds:
        if isinstance(kind, Combined):
            return [kind.start]
    points = [k for k in kinds if isinstance(k, Points) and len(k.labels)]
    model = np.concatenate([k.model for k in points]) if points else np.zeros((0, 3))
    world = np.concatenate([k.world for k in points]) if points else np.zeros((0, 3))
    kept = _kept_scale(kinds)
    alone = sum(not isinstance(kind, KeptScale) for kind in kinds) == 1
    if len(model) >= 3 and (alone or not (nearly_on_a_line(model) or nearly_on_a_line(world))):
        with suppress(GeometryError):
            return [fit_similarity(model, world, scale=kept)]
    scale = _first_scale(kinds, model, world) if kept is None else kept
    turns = [np.eye(3), *(t for kind in kinds for t in _own_starts(kind))]
    if len(turns) == 1:
        turns += [*Rotation.random(_STARTS, random_state=0).as_matrix()]
    found = []
    for turn in turns:
        if len(model):
            shift = world.mean(axis=0) - scale * turn @ model.mean(axis=0)
        else:
            shift = centre.ravel() - scale * turn @ centre.ravel()
        start = Similarity(scale, turn, shift)
        found.append((_cost(problem, start, robust=True), start))
    followed = [found[0][1]]
    for _, start in sorted(found[1:], key=lambda pair: pair[0]):
        # Many that lie side by side lead to one and the same.
        if all(_angle_of(start.rotation.T @ f.rotation) > _BESIDE for f in followed):
            followed.append(start)
        if len(followed) > _FOLLOWED:
            break
    return followed


def _agreed_by_most(problem: _Problem, starts: Sequence[Similarity]) -> list[Similarity]:
    """Where starts lead to if gross mistakes count little; those that most observations bear out.
    By squares alone one strike that was read as dip direction can turn a model upside down."""
    if len(starts) < 2:
        return list(starts)
    ended = [_followed(problem, start, robust=True) for start in starts]
    least = min(cost for _, cost in ended)
    return [fit for fit, cost in ended if cost <= least + AS_GOOD]


def _own_starts(kind: Observed) -> list[FloatArray]:
    """The mean rotation that the attitudes of cameras tell; those that pairs of directions do."""
    if isinstance(kind, Directions):
        return rotations_by_pairs(kind.model, kind.world, axial=kind.axial)
    model, world = getattr(kind, "model", None), getattr(kind, "world", None)
    if model is None or world is None or model.ndim != 3 or not len(model):
        return []
    u, _, vt = np.linalg.svd((world @ np.swapaxes(model, 1, 2)).sum(axis=0))
    return [u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt]


def _kept_scale(kinds: Sequence[Observed]) -> float | None:
    """Metres per unit of the model if the scale is fixed."""
    for kind in kinds:
        if isinstance(kind, KeptScale):
            return float(kind.length[0] / np.linalg.norm(kind.second[0] - kind.first[0]))
    return None


def _first_scale(kinds: Sequence[Observed], model: FloatArray, world: FloatArray) -> float:
    if len(model) >= 2:
        spread = np.linalg.norm(model - model.mean(axis=0))
        if spread > 0:
            return float(np.linalg.norm(world - world.mean(axis=0)) / spread)
    for kind in kinds:
        length = getattr(kind, "length", None)
        if length is not None and len(length):
            return float(np.median(length / np.linalg.norm(kind.second - kind.first, axis=1)))  # type: ignore[attr-defined]
    return 1.0


def _usual(rows: Rows, size: float, alone: Mapping[str, tuple[float, float]]) -> FloatArray:
    """(m,) what errors begin with: stated, or usual for their kind, or what is the most that they
    may be by what they show alone."""
    metres = np.array([g in METRES for g in rows.groups])
    usual = np.where(metres, _USUAL_SHARE * size, _USUAL_RAD)
    for name, (variance, free) in alone.items():
        which = np.array(rows.groups) == name
        most = float(np.sqrt(variance * most_times(free, free)))
        usual[which] = np.minimum(usual[which], max(most, 1e-12 * size))
    return np.where(np.isfinite(rows.sigma), rows.sigma, usual)


def _cost(problem: _Problem, fit: Similarity, *, robust: bool = False) -> float:
    """The sum of squares, each by its usual error; robust : by Cauchy's function of them."""
    rows, _, _ = problem.at(fit)
    squares = (rows.misses / _usual(rows, problem.size * fit.scale, problem.alone)) ** 2
    return float((_CAUCHY**2 * np.log1p(squares / _CAUCHY**2) if robust else squares).sum())


# --- one start --------------------------------------------------------------------------------
def _step(rows: Rows, sigma: FloatArray, size: float, turn_first: FloatArray) -> FloatArray:
    """(7,) the change that lessens the squares most; of what is free, the least one."""
    moves, misses, units = system_of(rows, sigma, size)
    inverse, null = inverse_of(moves.T @ moves)
    step = -inverse @ (moves.T @ misses)
    if null.shape[1]:
        weighed = turn_first[:, None] * null
        step = step - null @ np.linalg.lstsq(weighed, turn_first * step, rcond=None)[0]
    return np.asarray((step * units)[:7], np.float64)


def moved(fit: Similarity, step: FloatArray, centre: FloatArray) -> Similarity:
    """After a turn step[:3] (rad) about World axes, a relative scale step[3], a shift step[4:]."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_rotvec(step[:3]).as_matrix()
    grow = float(np.exp(np.clip(step[3], -1.0, 1.0)))
    rotation = turn @ fit.rotation
    translation = grow * turn @ (fit.translation - centre) + centre + step[4:]
    return Similarity(fit.scale * grow, rotation, translation)


def _followed(
    problem: _Problem, fit: Similarity, *, robust: bool = False
) -> tuple[Similarity, float]:
    """Where a start leads to with usual errors, and the cost there; robust : as in `_cost`."""
    for _ in range(_STEPS):
        rows, _, at = problem.at(fit)
        size = problem.size * fit.scale
        sigma = _usual(rows, size, problem.alone)
        if robust:
            sigma = np.hypot(sigma, rows.misses / _CAUCHY)
        step = _step(rows, sigma, size, _preference(rows))
        length = np.linalg.norm(step[:3])
        if length > 0.7:
            step = step * (0.7 / length)
        fit = moved(fit, step, at)
        if np.abs(step[:4]).max() < _SMALL_START:
            break
    return fit, _cost(problem, fit, robust=robust)


def _preference(rows: Rows) -> FloatArray:
    """How dear changes are that nothing asks for: tilts more than turns about the vertical."""
    dear = np.ones(7 + rows.shared.shape[1])
    dear[:2] = 1e3
    return dear


# --- errors -----------------------------------------------------------------------------------
def _judged(problem: _Problem, fit: Similarity) -> Adjusted:
    from scipy.stats import chi2

    size, alone = problem.size, problem.alone
    rows, begins, at = problem.at(fit)
    sigma = _usual(rows, size * fit.scale, alone)
    groups = np.array(rows.groups)
    unstated = [str(g) for g in dict.fromkeys(groups[~np.isfinite(rows.sigma)])]
    free_of: dict[str, float] = {}
    held: set[str] = set()
    for _ in range(_STEPS):
        rows, begins, at = problem.at(fit)
        before = sigma.copy()
        if unstated:
            sigma, free_of = estimated(rows, sigma, size * fit.scale, unstated, alone, held)
        step = _step(rows, sigma, size * fit.scale, _preference(rows))
        fit = moved(fit, step, at)
        if np.abs(step[:4]).max() < _SMALL and np.allclose(before, sigma, rtol=1e-6):
            break
    rows, begins, at = problem.at(fit)
    length = size * fit.scale
    moves, misses, units = system_of(rows, sigma, length)
    information = moves.T @ moves
    inverse, null = inverse_of(information)
    common = -(inverse @ (moves.T @ misses) * units)[7:]
    misses = left_over(moves, misses, inverse, len(rows.misses))
    rows = replace(rows, misses=misses[: len(rows.misses)] * sigma)
    redundancy = float(len(rows.misses) - (7 - null.shape[1]))
    drift = drift_of(rows, moves, misses)
    share, spread, factor = spread_of(rows, moves, misses, inverse, drift)
    overdrawn = 1.0
    if np.isfinite(rows.sigma).any() and redundancy > 0:
        squares = float((misses**2).sum())
        if squares > chi2.ppf(_SURE, redundancy):
            overdrawn = float(np.sqrt(squares / redundancy))
    plain = spread * np.outer(units, units) * overdrawn**2
    covariance = plain * np.outer(factor, factor)
    assumed = tuple(name for name in unstated if free_of.get(name, 0.0) < 0.5)
    return Adjusted(
        fit,
        at,
        covariance[:7, :7],
        plain[:7, :7],
        null[:7],
        rows,
        sigma,
        sigma * share,
        tuple(begins),
        assumed,
        overdrawn,
        False,
        length,
        redundancy,
        information,
        common,
        covariance[7:, 7:],
        free_of,
        drift,
    )


def weighed_rows(found: Adjusted) -> tuple[FloatArray, FloatArray]:
    """(m, 7 + k) the rows divided by their errors, with what they share, and (7 + k, 7 + k) the
    covariance by these errors as they are, without the widening for few of them; of what nothing
    determines zero."""
    moves, _, _ = system_of(found.rows, found.sigma, found.size)
    inverse, _ = inverse_of(moves.T @ moves)
    return moves[: len(found.sigma)], inverse


def _tilt_of(rotation: FloatArray) -> float:
    return float(np.arccos(np.clip(rotation[2, 2], -1.0, 1.0)))


def _angle_of(rotation: FloatArray) -> float:
    return float(np.arccos(np.clip((np.trace(rotation) - 1.0) / 2.0, -1.0, 1.0)))
