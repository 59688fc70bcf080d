"""Sets of planes found among poles: a mixture of clusters on the sphere and of an even scatter.

Each cluster is a Bingham (1974) distribution, which may be longer than wide and has the same
density for a pole and its opposite, so that sets of steep planes, whose poles lie on both sides of
the net, need no care of their own; what belongs to none is spread evenly. The mixture is fitted
by expectation and maximisation, cluster after cluster: each new one begins where poles are densest
among those that no cluster holds, or as half of one that is there. How many there are is chosen by
BIC with a price on clusters that overlap each other, a quarter of that of the integrated completed
likelihood (Biernacki, Celeux & Govaert 2000, IEEE Transactions PAMI 22, 719-725): the whole price
joins wide sets that are forty degrees apart, and a quarter splits none that is no Bingham
distribution. The same poles always give the same sets.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray

LEAST_MEMBERS, SURE_MEMBERS = 3, 5
"""Of a set that is proposed. With fewer than the second it must also be closer than chance."""
_BY_CHANCE, _SAME_DEG = 0.05, 2.0
"""Expected number of groups as small and as close among evenly scattered poles, and the angle below
which planes are not measured differently."""
_ALL_NEAR = {3: 0.5865, 4: 0.2745}
"""Chance that the poles of a group that are within an angle of one of them are within it of each
other, by number: 1 - 3 sqrt(3) / 4 pi, and by simulation."""
_WIDEST, _NARROWEST = 4.0, 5000.0
"""Concentrations: a spread of 20 degrees, beyond which a set is no set, and of 0.6, below which
planes are not measured."""
_SEED = 25.0
_ROUNDS, _SETTLED = 200, 1e-6
_MOST_COMPARED, _MOST_SEARCHED = 2000, 3000
_TRIED = 3
_OVERLAP = 0.25
_PARAMETERS, _OF_LENGTH = 4, 2
"""Of a cluster as long as wide: two of its axis, its spread and its weight; and of one that is
longer."""


@dataclass(frozen=True, eq=False)
class Mixture:
    """axes (k, 3, 3) of the clusters, rows the mean axis, the direction of the wider and that of
    the narrower spread; concentrations (k, 2) along the two; weights (k + 1,), the last that of the
    even scatter; posterior (n, k + 1) probability of each pole to be of each; log_likelihood
    against an even scatter; icl : by which their number is chosen, the less the better"""

    axes: FloatArray
    concentrations: FloatArray
    weights: FloatArray
    posterior: FloatArray
    log_likelihood: float
    icl: float

    @property
    def k(self) -> int:
        return len(self.axes)

    def assigned(self) -> IntArray:
        """(n,) the most probable cluster of each pole, -1 where it is the even scatter."""
        best = np.argmax(self.posterior, axis=1)
        return np.where(best == self.k, -1, best)


def cones95_deg(poles: FloatArray, mixture: Mixture) -> FloatArray:
    """(k,) half-angle of the cone about each cluster's mean axis that holds the true one with 95 %;
    NaN where it cannot be told. Poles that may be of another cluster or of the scatter tell the
    less of the axis the farther they are from it (Louis 1982, J. R. Statist. Soc. B 44, 226): the
    scatter of those assigned to it, which misses its tails, would promise too much."""
    from scipy.stats import f

    result = np.full(mixture.k, np.nan)
    for j in range(mixture.k):
        own = mixture.posterior[:, j]
        size = float(own.sum())
        along, across = poles @ mixture.axes[j, 0], poles @ mixture.axes[j, 1:].T
        spread = np.maximum(own @ across**2 / max(size, 1e-9), 1e-16)
        # The narrowest that there are may be narrower in truth.
        known = mixture.concentrations[j] * max(1.0 - 1.0 / max(size, 1.0), 0.1)
        pull = np.where(mixture.concentrations[j] >= 0.99 * _NARROWEST, 0.5 / spread, known)
        score = 2.0 * pull * across
        told = np.diag(2.0 * pull * (own @ (along[:, None] ** 2 - across**2)))
        missing = (score * (own * (1.0 - own))[:, None]).T @ score
        values = np.linalg.eigvalsh(told - missing)
        if size <= 2.0 or values[0] <= 0.05 * np.diag(told).min():
            continue
        wide, ratio = 1.0 / math.sqrt(values[0]), math.sqrt(values[0] / values[1])
        # 95 % of a normal distribution in two dimensions, of which one may be narrow.
        many = 1.96 + (math.sqrt(-2.0 * math.log(0.05)) - 1.96) * ratio
        # Of members that are certain there are two free numbers each; of these, by trial, one.
        few = math.sqrt(float(f.ppf(0.95, 2, size - 1.0)) / -math.log(0.05))
        result[j] = math.degrees(math.asin(min(1.0, many * few * wide)))
    return result


def propose_clusters(
    poles: FloatArray, most: int, *, exactly: bool = False
) -> tuple[Mixture, list[float]]:
    """The best mixture of unit vectors (n, 3) with 0 to `most` clusters, and the criterion of each
    number that was tried. exactly : the one with `most` clusters, or with as many as can be told
    apart where these are fewer"""
    some = poles
    if len(poles) > _MOST_SEARCHED:
        rows = np.random.default_rng(0).permutation(len(poles))[:_MOST_SEARCHED]
        some = poles[np.sort(rows)]
    best = tried = _none(len(some))
    criteria = [tried.icl]
    worse = 0
    for _ in range(most):
        found = [_settled(some, *start) for start in _one_more(some, tried)]
        sound = [m for m in found if _is_sound(m)]
        if not sound:
            break
        tried = min(sound, key=lambda m: m.icl)
        criteria.append(tried.icl)
        if exactly or (tried.icl < best.icl and _is_beyond_chance(some, tried)):
            best, worse = tried, 0
        else:
            worse += 1
            if worse > 2:
                break
    if some is not poles:
        best = _settled(poles, best.axes, best.concentrations, best.weights)
    return best, criteria


def clusters_from_seeds(poles: FloatArray, seeds: FloatArray) -> Mixture:
    """The mixture with one cluster for each seed (k, 3), in their order."""
    k = len(seeds)
    weights = np.append(np.full(k, 0.9 / k), 0.1)
    axes = np.array([_frame(seed) for seed in seeds])
    return _settled(poles, axes, np.full((k, 2), _SEED), weights)


def _none(n: int) -> Mixture:
    return Mixture(np.zeros((0, 3, 3)), np.zeros((0, 2)), np.ones(1), np.ones((n, 1)), 0.0, 0.0)


def _frame(axis: FloatArray) -> FloatArray:
    """Rows: the axis, and two directions at right angles to it."""
    _, _, rows = np.linalg.svd(axis[None])
    return np.vstack([axis, rows[1:]])


def _one_more(
    poles: FloatArray, mixture: Mixture
) -> Iterator[tuple[FloatArray, FloatArray, FloatArray]]:
    """Start values with one cluster more: out of the even scatter, or out of a wide cluster."""
    half = 0.5 * mixture.weights[-1]
    for axis in _dense_places(poles, mixture.posterior):
        yield (
            np.concatenate([mixture.axes, _frame(axis)[None]]),
            np.concatenate([mixture.concentrations, [[_SEED, _SEED]]]),
            np.concatenate([mixture.weights[:-1], [half, half]]),
        )
    for j in np.argsort(mixture.concentrations[:, 0], kind="stable")[:_TRIED]:
        mean, wide, _ = mixture.axes[j]
        spread = 1.0 / math.sqrt(2.0 * mixture.concentrations[j, 0])
        one, other = (_frame(mean + side * spread * wide) for side in (1.0, -1.0))
        axes, weights = mixture.axes.copy(), mixture.weights.copy()
        concentrations = mixture.concentrations.copy()
        axes[j], weights[j] = one / np.linalg.norm(one, axis=1)[:, None], 0.5 * weights[j]
        concentrations[j] = concentrations[j, 1]
        yield (
            np.concatenate([axes, (other / np.linalg.norm(other, axis=1)[:, None])[None]]),
            np.concatenate([concentrations, concentrations[j : j + 1]]),
            np.concatenate([weights[:-1], [weights[j], weights[-1]]]),
        )


def _dense_places(poles: FloatArray, posterior: FloatArray) -> list[FloatArray]:
    """Up to three poles, far from each other, around which the unassigned are densest."""
    step = max(1, -(-len(poles) // _MOST_COMPARED))
    some, loose = poles[::step], posterior[::step, -1]
    density = np.exp(_SEED * ((some @ some.T) ** 2 - 1.0)) @ loose
    found: list[FloatArray] = []
    for i in np.argsort(-density, kind="stable"):
        if all(abs(float(some[i] @ other)) < math.cos(math.radians(25)) for other in found):
            found.append(some[i])
        if len(found) == _TRIED:
            break
    return found


def _settled(
    poles: FloatArray, axes: FloatArray, concentrations: FloatArray, weights: FloatArray
) -> Mixture:
    """The mixture at the next summit of the likelihood; clusters whose length is not borne out by
    their poles are as long as wide, and have that many parameters less."""
    free = np.zeros(len(axes), np.bool_)
    found = _climbed(poles, axes, concentrations, weights, free)
    round_ = _not_longer(poles, found)
    if not round_.any():
        return found
    return _climbed(poles, found.axes, found.concentrations, found.weights, round_)


def _not_longer(poles: FloatArray, mixture: Mixture) -> BoolArray:
    """(k,) whether a cluster's length beyond its width gains less than it costs."""
    result = np.zeros(mixture.k, np.bool_)
    for j in range(mixture.k):
        across, own = poles @ mixture.axes[j, 1:].T, mixture.posterior[:, j]
        size = max(float(own.sum()), 1e-9)
        even = np.full(2, _concentration(np.array([own @ (across**2).mean(axis=1) / size]))[0])
        gain = _log_density(across, mixture.concentrations[j]) - _log_density(across, even)
        result[j] = 2.0 * float(own @ gain) < _OF_LENGTH * math.log(max(len(poles), 2))
    return result


def _climbed(
    poles: FloatArray,
    axes: FloatArray,
    concentrations: FloatArray,
    weights: FloatArray,
    round_: BoolArray,
) -> Mixture:
    """Expectation and maximisation until the likelihood stands still; round_ (k,) : clusters that
    are as long as wide."""
    n, last = len(poles), -math.inf
    axes, concentrations = axes.copy(), concentrations.copy()
    for _ in range(_ROUNDS):
        logs = np.zeros((n, len(axes) + 1))
        for j in range(len(axes)):
            logs[:, j] = _log_density(poles @ axes[j, 1:].T, concentrations[j])
        logs += np.log(weights)
        top = logs.max(axis=1, keepdims=True)
        posterior = np.exp(logs - top)
        total = posterior.sum(axis=1, keepdims=True)
        posterior /= total
        likelihood = float(np.sum(top + np.log(total)))
        if likelihood - last < _SETTLED * n:
            break
        last = likelihood
        size = posterior.sum(axis=0)
        # The scatter never dies out: an outlier must find it.
        size[-1] = max(float(size[-1]), 0.5)
        size[:-1] = np.maximum(size[:-1], 1e-9)
        weights = size / size.sum()
        for j in range(len(axes)):
            tensor = (poles * posterior[:, j, None]).T @ poles / size[j]
            values, vectors = np.linalg.eigh(tensor)
            axes[j] = vectors[:, ::-1].T
            spread = values[1::-1]
            concentrations[j] = _concentration(np.full(2, spread.mean()) if round_[j] else spread)
    inside = posterior[:, :-1]
    share = inside / np.maximum(inside.sum(axis=1, keepdims=True), 1e-300)
    overlap = -float(np.sum(inside * np.log(np.maximum(share, 1e-300))))
    free = _PARAMETERS * len(axes) + _OF_LENGTH * int((~round_).sum())
    icl = free * math.log(max(n, 2)) - 2.0 * likelihood + 2.0 * _OVERLAP * overlap
    return Mixture(axes, concentrations, weights, posterior, likelihood, icl)


def _log_density(across: FloatArray, concentrations: FloatArray) -> FloatArray:
    """(n,) of Bingham's distribution over that of an even scatter, exp(-k1 a^2 - k2 b^2) / N, at
    poles with the components a, b (n, 2) across the mean axis. N is the root of the product of
    Watson's, D(sqrt k) / sqrt k with Dawson's integral D: exact where k1 = k2, and in the limit of
    narrow clusters."""
    from scipy.special import dawsn

    root = np.sqrt(concentrations)
    return np.asarray(-(across**2) @ concentrations - 0.5 * np.log(dawsn(root) / root).sum())


@functools.cache
def _spreads() -> tuple[FloatArray, FloatArray]:
    """Variances of Watson's distribution along one direction, ascending, and the logarithms of the
    concentrations: half of 1 - (1 / (2 sqrt k D(sqrt k)) - 1 / 2k)."""
    from scipy.special import dawsn

    k = np.geomspace(_NARROWEST, _WIDEST, 4000)
    root = np.sqrt(k)
    return 0.5 * (1.0 - 1.0 / (2.0 * root * dawsn(root)) + 1.0 / (2.0 * k)), np.log(k)


def _concentration(variance: FloatArray) -> FloatArray:
    """Of Watson's distribution by maximum likelihood, from variances along one direction."""
    return np.asarray(np.exp(np.interp(variance, *_spreads())))


def groups_by_chance(n: int, members: FloatArray) -> float:
    """Return how many groups as close as members (k, 3) are expected among n scattered poles.

    Groups are k poles of which no two are farther apart than the widest angle between the members.
    The share of evenly scattered poles within an angle of a pole is 1 - cos of it.
    """
    k = len(members)
    widest = float(np.abs(members @ members.T).min())
    share = 1.0 - min(widest, math.cos(math.radians(_SAME_DEG)))
    return math.comb(n, k) * share ** (k - 1) * _ALL_NEAR[k]


def _is_beyond_chance(poles: FloatArray, mixture: Mixture) -> bool:
    """Return whether the small clusters, taken together, are closer than scattered poles come."""
    assigned = mixture.assigned()
    sizes = np.bincount(assigned[assigned >= 0], minlength=mixture.k)
    small = [poles[assigned == j] for j in np.flatnonzero(sizes < SURE_MEMBERS)]
    return not small or math.prod(groups_by_chance(len(poles), m) for m in small) < _BY_CHANCE


def _is_sound(mixture: Mixture) -> bool:
    """Return whether no cluster is too small to be one, and none in the place of another."""
    assigned = mixture.assigned()
    if (np.bincount(assigned[assigned >= 0], minlength=mixture.k) < LEAST_MEMBERS).any():
        return False
    mean = mixture.axes[:, 0]
    near = np.abs(mean @ mean.T) > math.cos(math.radians(3.0))
    return not (near & ~np.eye(mixture.k, dtype=bool)).any()
