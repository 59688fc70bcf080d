"""Sets of poles, modelled as a mixture of clusters on the sphere and a uniform background.

Each cluster is a Bingham (1974) distribution, which may be elongated. Its density is the same for a
pole and its opposite, so sets of steep planes, whose poles lie on both sides of the net, need no
special treatment. The background is uniform. The mixture is fitted by expectation maximisation, one
cluster after another: a new cluster starts where unassigned poles are densest, or as half of an
existing cluster. The number of clusters minimises BIC plus a penalty on overlap, a quarter of the
penalty of the integrated completed likelihood (Biernacki, Celeux & Govaert 2000, IEEE Transactions
PAMI 22, 719-725): the full penalty merges wide sets that are forty degrees apart, whereas a quarter
does not split sets that deviate from a Bingham distribution. The result is deterministic.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray

MIN_MEMBERS, MIN_CERTAIN_MEMBERS = 3, 5
"""Minimum number of members of a proposed set. A set with fewer members than the second number must
also be significantly clustered.
"""
MAX_RANDOM_GROUPS, ANGULAR_RESOLUTION_DEG = 0.05, 2.0
"""Maximum expected number of random groups of the same size and width, and the angle below which
differences between planes are measurement errors.
"""
MUTUAL_PROBABILITY = {3: 0.5865, 4: 0.2745}
"""Probability that poles of a random group that are all within an angle of one of them are also
within this angle of each other, by group size: 1 - 3 sqrt(3) / 4 pi, and from simulations.
"""
MIN_CONCENTRATION, MAX_CONCENTRATION = 4.0, 5000.0
"""Limits of the concentration: the maximum scatter of a set is 20 degrees, and a scatter of 0.6
degrees corresponds to the accuracy of planes.
"""
SEED_CONCENTRATION = 25.0
MAX_ITERATIONS, LIKELIHOOD_TOLERANCE = 200, 1e-6
MAX_COMPARED_POLES, MAX_SEEDED_POLES = 2000, 3000
N_STARTS = 3
OVERLAP_WEIGHT = 0.25
PARAMETERS_PER_CLUSTER, ELONGATION_PARAMETERS = 4, 2
"""Number of parameters of a round cluster (two for the axis, scatter and weight), and of additional
parameters of an elongated cluster.
"""


@dataclass(frozen=True, eq=False)
class Mixture:
    """Mixture of k clusters and a uniform background.

    Attributes
    ----------
    axes : (k, 3, 3) ndarray
        The rows are the mean axis and the directions of larger and smaller scatter.
    concentrations : (k, 2) ndarray
        Concentrations along the two directions of scatter.
    weights : (k + 1,) ndarray
        Weights of the clusters, followed by the weight of the background.
    posterior : (n, k + 1) ndarray
        Membership probabilities of each pole.
    log_likelihood : float
        Log-likelihood relative to the background.
    icl : float
        Criterion for the number of clusters; lower is better.
    """

    axes: FloatArray
    concentrations: FloatArray
    weights: FloatArray
    posterior: FloatArray
    log_likelihood: float
    icl: float

    @property
    def k(self) -> int:
        return len(self.axes)

    def most_probable_clusters(self) -> IntArray:
        """Return the most probable cluster (n,) of each pole; -1 for the background."""
        best_cluster = np.argmax(self.posterior, axis=1)
        return np.where(best_cluster == self.k, -1, best_cluster)


def cones95_deg(poles: FloatArray, mixture: Mixture) -> FloatArray:
    """Compute the 95 % confidence cone of the mean axis of each cluster.

    Poles that may belong to another cluster or to the background contribute less information, and
    their contribution decreases with the distance from the axis (Louis 1982, J. R. Statist. Soc. B
    44, 226). The scatter of the assigned poles alone lacks the tails of the distribution and would
    be too optimistic.

    Returns
    -------
    (k,) ndarray
        Half-angles in degrees; NaN if undetermined.
    """
    from scipy.stats import f

    result = np.full(mixture.k, np.nan)
    for j in range(mixture.k):
        membership = mixture.posterior[:, j]
        size = float(membership.sum())
        projections, cross_axes = poles @ mixture.axes[j, 0], poles @ mixture.axes[j, 1:].T
        variances = np.maximum(membership @ cross_axes**2 / max(size, 1e-9), 1e-16)
        # At the maximum concentration, the scatter itself is used.
        concentrations = mixture.concentrations[j] * max(1.0 - 1.0 / max(size, 1.0), 0.1)
        weight = np.where(
            mixture.concentrations[j] >= 0.99 * MAX_CONCENTRATION, 0.5 / variances, concentrations
        )
        score = 2.0 * weight * cross_axes
        information = np.diag(
            2.0 * weight * (membership @ (projections[:, None] ** 2 - cross_axes**2))
        )
        missing_information = (score * (membership * (1.0 - membership))[:, None]).T @ score
        values = np.linalg.eigvalsh(information - missing_information)
        if size <= 2.0 or values[0] <= 0.05 * np.diag(information).min():
            continue
        sigma, ratio = 1.0 / math.sqrt(values[0]), math.sqrt(values[0] / values[1])
        # Quantile of a two-dimensional normal distribution, one dimension of which may be narrow.
        quantile = 1.96 + (math.sqrt(-2.0 * math.log(0.05)) - 1.96) * ratio
        # Certain members contribute two degrees of freedom each, uncertain members empirically one.
        correction = math.sqrt(float(f.ppf(0.95, 2, size - 1.0)) / -math.log(0.05))
        result[j] = math.degrees(math.asin(min(1.0, quantile * correction * sigma)))
    return result


def propose_clusters(
    poles: FloatArray, max_clusters: int, *, is_exact_count: bool = False
) -> tuple[Mixture, list[float]]:
    """Fit the best mixture with up to `max_clusters` clusters.

    Parameters
    ----------
    poles : (n, 3) ndarray
        Unit vectors.
    max_clusters : int
    is_exact_count : bool
        If True, fit exactly `max_clusters` clusters, or fewer if fewer are distinct.

    Returns
    -------
    mixture : Mixture
    criteria : list of float
        Criterion for each tested number of clusters.
    """
    sample = poles
    if len(poles) > MAX_SEEDED_POLES:
        rows = np.random.default_rng(0).permutation(len(poles))[:MAX_SEEDED_POLES]
        sample = poles[np.sort(rows)]
    best_mixture = candidate = _empty_mixture(len(sample))
    criteria = [candidate.icl]
    n_worse = 0
    for _ in range(max_clusters):
        mixtures = [
            _maximize(sample, *start) for start in _starts_with_added_cluster(sample, candidate)
        ]
        valid_mixtures = [mixture for mixture in mixtures if _is_valid(mixture)]
        if not valid_mixtures:
            break
        candidate = min(valid_mixtures, key=lambda mixture: mixture.icl)
        criteria.append(candidate.icl)
        if is_exact_count or (
            candidate.icl < best_mixture.icl and _is_significant(sample, candidate)
        ):
            best_mixture, n_worse = candidate, 0
        else:
            n_worse += 1
            if n_worse > 2:
                break
    if sample is not poles:
        best_mixture = _maximize(
            poles, best_mixture.axes, best_mixture.concentrations, best_mixture.weights
        )
    return best_mixture, criteria


def clusters_from_seeds(poles: FloatArray, seeds: FloatArray) -> Mixture:
    """Fit the mixture with one cluster per seed, in the order of the seeds.

    Parameters
    ----------
    poles : (n, 3) ndarray
    seeds : (k, 3) ndarray

    Returns
    -------
    Mixture
    """
    k = len(seeds)
    weights = np.append(np.full(k, 0.9 / k), 0.1)
    axes = np.array([_frame(seed) for seed in seeds])
    return _maximize(poles, axes, np.full((k, 2), SEED_CONCENTRATION), weights)


def _empty_mixture(n: int) -> Mixture:
    return Mixture(np.zeros((0, 3, 3)), np.zeros((0, 2)), np.ones(1), np.ones((n, 1)), 0.0, 0.0)


def _frame(axis: FloatArray) -> FloatArray:
    """Return the axis and two directions perpendicular to it as rows."""
    _, _, rows = np.linalg.svd(axis[None])
    return np.vstack([axis, rows[1:]])


def _starts_with_added_cluster(
    poles: FloatArray, mixture: Mixture
) -> Iterator[tuple[FloatArray, FloatArray, FloatArray]]:
    """Yield start values with one more cluster, from the background or from a wide cluster."""
    half_weight = 0.5 * mixture.weights[-1]
    for axis in _densest_poles(poles, mixture.posterior):
        yield (
            np.concatenate([mixture.axes, _frame(axis)[None]]),
            np.concatenate([mixture.concentrations, [[SEED_CONCENTRATION, SEED_CONCENTRATION]]]),
            np.concatenate([mixture.weights[:-1], [half_weight, half_weight]]),
        )
    for j in np.argsort(mixture.concentrations[:, 0], kind="stable")[:N_STARTS]:
        mean, major_axis, _ = mixture.axes[j]
        spread = 1.0 / math.sqrt(2.0 * mixture.concentrations[j, 0])
        first_frame, second_frame = (
            _frame(mean + sign * spread * major_axis) for sign in (1.0, -1.0)
        )
        axes, weights = mixture.axes.copy(), mixture.weights.copy()
        concentrations = mixture.concentrations.copy()
        axes[j], weights[j] = (
            first_frame / np.linalg.norm(first_frame, axis=1)[:, None],
            0.5 * weights[j],
        )
        concentrations[j] = concentrations[j, 1]
        yield (
            np.concatenate(
                [axes, (second_frame / np.linalg.norm(second_frame, axis=1)[:, None])[None]]
            ),
            np.concatenate([concentrations, concentrations[j : j + 1]]),
            np.concatenate([weights[:-1], [weights[j], weights[-1]]]),
        )


def _densest_poles(poles: FloatArray, posterior: FloatArray) -> list[FloatArray]:
    """Return up to three separate poles where the density of unassigned poles is highest."""
    step = max(1, -(-len(poles) // MAX_COMPARED_POLES))
    sample, unassigned_shares = poles[::step], posterior[::step, -1]
    density = np.exp(SEED_CONCENTRATION * ((sample @ sample.T) ** 2 - 1.0)) @ unassigned_shares
    positions: list[FloatArray] = []
    for i in np.argsort(-density, kind="stable"):
        if all(
            abs(float(sample[i] @ position)) < math.cos(math.radians(25)) for position in positions
        ):
            positions.append(sample[i])
        if len(positions) == N_STARTS:
            break
    return positions


def _maximize(
    poles: FloatArray, axes: FloatArray, concentrations: FloatArray, weights: FloatArray
) -> Mixture:
    """Maximize the likelihood; clusters without significant elongation are made round."""
    is_round_start = np.zeros(len(axes), np.bool_)
    mixture = _run_em(poles, axes, concentrations, weights, is_round_start)
    is_round = _is_round(poles, mixture)
    if not is_round.any():
        return mixture
    return _run_em(poles, mixture.axes, mixture.concentrations, mixture.weights, is_round)


def _is_round(poles: FloatArray, mixture: Mixture) -> BoolArray:
    """Return for each cluster (k,) whether its elongation does not justify its parameters."""
    result = np.zeros(mixture.k, np.bool_)
    for j in range(mixture.k):
        offsets, membership = poles @ mixture.axes[j, 1:].T, mixture.posterior[:, j]
        size = max(float(membership.sum()), 1e-9)
        round_concentrations = np.full(
            2, _concentration(np.array([membership @ (offsets**2).mean(axis=1) / size]))[0]
        )
        log_likelihood_gain = _log_density(offsets, mixture.concentrations[j]) - _log_density(
            offsets, round_concentrations
        )
        result[j] = 2.0 * float(
            membership @ log_likelihood_gain
        ) < ELONGATION_PARAMETERS * math.log(max(len(poles), 2))
    return result


def _run_em(
    poles: FloatArray,
    axes: FloatArray,
    concentrations: FloatArray,
    weights: FloatArray,
    is_round: BoolArray,
) -> Mixture:
    """Run expectation maximisation until convergence; `is_round` (k,) marks round clusters."""
    n, previous_log_likelihood = len(poles), -math.inf
    axes, concentrations = axes.copy(), concentrations.copy()
    for _ in range(MAX_ITERATIONS):
        log_densities = np.zeros((n, len(axes) + 1))
        for j in range(len(axes)):
            log_densities[:, j] = _log_density(poles @ axes[j, 1:].T, concentrations[j])
        log_densities += np.log(weights)
        max_log = log_densities.max(axis=1, keepdims=True)
        posterior = np.exp(log_densities - max_log)
        totals = posterior.sum(axis=1, keepdims=True)
        posterior /= totals
        log_likelihood = float(np.sum(max_log + np.log(totals)))
        if log_likelihood - previous_log_likelihood < LIKELIHOOD_TOLERANCE * n:
            break
        previous_log_likelihood = log_likelihood
        size = posterior.sum(axis=0)
        # Preserve the background for outliers.
        size[-1] = max(float(size[-1]), 0.5)
        size[:-1] = np.maximum(size[:-1], 1e-9)
        weights = size / size.sum()
        for j in range(len(axes)):
            tensor = (poles * posterior[:, j, None]).T @ poles / size[j]
            values, vectors = np.linalg.eigh(tensor)
            axes[j] = vectors[:, ::-1].T
            variances = values[1::-1]
            concentrations[j] = _concentration(
                np.full(2, variances.mean()) if is_round[j] else variances
            )
    memberships = posterior[:, :-1]
    shares = memberships / np.maximum(memberships.sum(axis=1, keepdims=True), 1e-300)
    overlap = -float(np.sum(memberships * np.log(np.maximum(shares, 1e-300))))
    dof = PARAMETERS_PER_CLUSTER * len(axes) + ELONGATION_PARAMETERS * int((~is_round).sum())
    icl = dof * math.log(max(n, 2)) - 2.0 * log_likelihood + 2.0 * OVERLAP_WEIGHT * overlap
    return Mixture(axes, concentrations, weights, posterior, log_likelihood, icl)


def _log_density(axis_cosines: FloatArray, concentrations: FloatArray) -> FloatArray:
    """Return the log density (n,) of Bingham's distribution relative to the background.

    The density is exp(-k1 a^2 - k2 b^2) / N for poles with components a, b (n, 2) perpendicular to
    the mean axis. N is the square root of the product of the normalizing constants of Watson's
    distribution, D(sqrt k) / sqrt k, where D is Dawson's integral: exact for k1 = k2 and in the
    limit of narrow clusters.
    """
    from scipy.special import dawsn

    root = np.sqrt(concentrations)
    return np.asarray(-(axis_cosines**2) @ concentrations - 0.5 * np.log(dawsn(root) / root).sum())


@functools.cache
def _concentration_table() -> tuple[FloatArray, FloatArray]:
    """Tabulate the one-dimensional variances and log concentrations of Watson's distribution.

    The variances are in ascending order.
    Each variance is half of 1 - (1 / (2 sqrt k D(sqrt k)) - 1 / 2k).
    """
    from scipy.special import dawsn

    k = np.geomspace(MAX_CONCENTRATION, MIN_CONCENTRATION, 4000)
    root = np.sqrt(k)
    return 0.5 * (1.0 - 1.0 / (2.0 * root * dawsn(root)) + 1.0 / (2.0 * k)), np.log(k)


def _concentration(variance: FloatArray) -> FloatArray:
    """Return the maximum-likelihood concentrations of Watson's distribution for variances."""
    return np.asarray(np.exp(np.interp(variance, *_concentration_table())))


def expected_random_groups(n: int, members: FloatArray) -> float:
    """Return the expected number of random groups that are as close as the members of a set.

    A group consists of k poles whose pairwise angles do not exceed the widest angle between the
    members. The share of uniform poles within an angle of a given pole is 1 - cos(angle).

    Parameters
    ----------
    n : int
        Number of poles.
    members : (k, 3) ndarray

    Returns
    -------
    float
    """
    k = len(members)
    min_cosine = float(np.abs(members @ members.T).min())
    fraction = 1.0 - min(min_cosine, math.cos(math.radians(ANGULAR_RESOLUTION_DEG)))
    return math.comb(n, k) * fraction ** (k - 1) * MUTUAL_PROBABILITY[k]


def _is_significant(poles: FloatArray, mixture: Mixture) -> bool:
    """Return whether the small clusters together are closer than random poles."""
    labels = mixture.most_probable_clusters()
    sizes = np.bincount(labels[labels >= 0], minlength=mixture.k)
    small_clusters = [poles[labels == j] for j in np.flatnonzero(sizes < MIN_CERTAIN_MEMBERS)]
    return (
        not small_clusters
        or math.prod(
            expected_random_groups(len(poles), small_cluster) for small_cluster in small_clusters
        )
        < MAX_RANDOM_GROUPS
    )


def _is_valid(mixture: Mixture) -> bool:
    """Return whether all clusters have enough members and distinct axes."""
    labels = mixture.most_probable_clusters()
    if (np.bincount(labels[labels >= 0], minlength=mixture.k) < MIN_MEMBERS).any():
        return False
    mean = mixture.axes[:, 0]
    is_near = np.abs(mean @ mean.T) > math.cos(math.radians(3.0))
    return not (is_near & ~np.eye(mixture.k, dtype=bool)).any()
