"""The linear problem of a registration, and the errors of its rows as their misses show them.

See `adjustment` for what is solved, and `observations` for what the rows are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.geology.serial_errors import (
    correlated,
    correlation_of,
    independent_share,
    more_taken,
)
from vomstudio.registration.observations import Rows
from vomstudio.registration.scatter import expected_squares, least_variance

# Of the information with its diagonal made 1: less is rounding.
_NOTHING = 1e-9
# Angles that nobody measures better: beside the doubt about a compass, errors that are much smaller
# would leave that to rounding.
_FINEST_RAD = 3e-4
# By chance the error of a group is larger beside others than alone by more than Fisher's F this
# rarely.
_RARE = 1e-3
METRES = {"points", "cameras", "lengths"}
RECEIVERS = ("points", "cameras")
"""Groups of positions in the order in which a receiver, which may drift, measured them."""


def system_of(
    rows: Rows, sigma: FloatArray, size: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(m + k, 7 + k) and (m + k,) of the rows and of what is known beforehand of shared errors,
    each divided by its error, and (7 + k,) the units of the columns."""
    k = rows.shared.shape[1]
    units = np.concatenate([np.ones(4), np.full(3, size), rows.shared_sigma])
    moves = np.vstack(
        [
            np.hstack([rows.moves, rows.shared]) / sigma[:, None] * units,
            np.hstack([np.zeros((k, 7)), np.eye(k)]),
        ]
    )
    return moves, np.concatenate([rows.misses / sigma, np.zeros(k)]), units


def inverse_of(information: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Of what is determined, and the null space (orthonormal columns) of the rest."""
    told = np.diag(information) > 0.0
    if not told.all():
        # Of planes and lines alone nothing tells scale and place.
        n, some = len(told), np.ix_(told, told)
        inner, free = inverse_of(information[some]) if told.any() else (np.zeros((0, 0)),) * 2
        inverse, null = np.zeros((n, n)), np.zeros((n, free.shape[1] + n - int(told.sum())))
        inverse[some] = inner
        null[told, : free.shape[1]] = free
        null[~told, free.shape[1] :] = np.eye(n - int(told.sum()))
        return inverse, null
    scale = np.sqrt(np.maximum(np.diag(information), 1e-300))
    scale = np.where(scale < 1e-140, 1.0, scale)
    values, axes = np.linalg.eigh(information / np.outer(scale, scale))
    held = values > _NOTHING
    if held.all():
        return (axes / values) @ axes.T / np.outer(scale, scale), np.zeros((len(scale), 0))
    null = (axes / scale[:, None])[:, ~held]
    null, _ = np.linalg.qr(null)
    inside = np.eye(len(information)) - null @ null.T
    part = inside @ information @ inside
    # In the subspace that is determined, or numbers of others would leak in.
    basis = np.linalg.svd(inside)[0][:, : int(held.sum())]
    inverse = basis @ np.linalg.pinv(basis.T @ part @ basis, hermitian=True) @ basis.T
    return inverse, null


def most_times(free: float, free_alone: float) -> float:
    """By how much a variance of so many free misses may be larger by chance than that alone."""
    from scipy.stats import f

    return float(f.isf(_RARE, free, free_alone))


def estimated(
    rows: Rows,
    sigma: FloatArray,
    size: float,
    unstated: Sequence[str],
    alone: Mapping[str, tuple[float, float]],
    held: set[str],
) -> tuple[FloatArray, dict[str, float]]:
    """(m,) errors with those of unstated groups as the misses show them, and how many free misses
    each of these rests on. held : groups that keep the error that they have alone; those are added
    that would exceed it by more than chance"""
    moves, misses, _ = system_of(rows, sigma, size)
    inverse, _ = inverse_of(moves.T @ moves)
    misses = left_over(moves, misses, inverse, len(sigma))
    hat = np.einsum("ij,jk,ik->i", moves, inverse, moves)[: len(sigma)]
    groups = np.array(rows.groups)
    unknown = ~np.isfinite(rows.sigma)
    found, free_of = sigma.copy(), {}
    for name in unstated:
        which = unknown & (groups == name)
        free = float(which.sum() - hat[which].sum())
        free_of[name] = free
        if free >= 0.5:
            squares = float((misses[: len(sigma)][which] ** 2).sum())
            variance = float(sigma[which][0] ** 2) * squares / free
            doubted = rows.shared.shape[1] and name not in METRES
            least = _FINEST_RAD if doubted else 1e-12 * size
            own, own_free = alone.get(name, (np.inf, free))
            if variance > own * most_times(free, own_free):
                held.add(name)
            if name in held:
                variance, free_of[name] = own, own_free
            found[which] = np.sqrt(max(variance, least**2))
    return found, free_of


def left_over(moves: FloatArray, misses: FloatArray, inverse: FloatArray, m: int) -> FloatArray:
    """The misses without what the errors that rows have in common explain of them."""
    k = len(misses) - m
    if not k:
        return misses
    shared = (inverse @ (moves.T @ misses))[-k:]
    left = misses - moves[:, -k:] @ shared
    return np.asarray(left, np.float64)


def drift_of(rows: Rows, moves: FloatArray, misses: FloatArray) -> dict[str, float]:
    """Return the correlation of the errors of neighbours in each table of positions, if any.

    Points and positions of cameras are in the order of their table, in which a receiver measured
    them; correlations that chance explains are left out.
    """
    correlations = {}
    for group in RECEIVERS:
        own = np.flatnonzero(np.array(rows.groups) == group)
        if len(own):
            along = _along_axes(rows, own, moves), _along_axes(rows, own, misses)
            correlations[group] = correlation_of(*along)
    return {group: rho for group, rho in correlations.items() if rho > 0.0}


def _along_axes(rows: Rows, own: IntArray, values: FloatArray) -> FloatArray:
    """Return weighted values of the rows of points, (n, 3, ...) along east, north and up."""
    each = values[own].reshape(-1, 3, *values.shape[1:])
    if rows.axes is None:
        return each
    return np.asarray(np.einsum("nji,nj...->ni...", rows.axes[own].reshape(-1, 3, 3), each))


def _drifted(rows: Rows, moves: FloatArray, drift: Mapping[str, float]) -> FloatArray:
    """The rows of weighted derivatives times the correlations of their errors."""
    found = moves.copy()
    for group, rho in drift.items():
        own = np.flatnonzero(np.array(rows.groups) == group)
        each = correlated(_along_axes(rows, own, moves), rho)
        if rows.axes is not None:
            each = rows.axes[own].reshape(-1, 3, 3) @ each
        found[own] = each.reshape(len(own), -1)
    return found


def spread_of(
    rows: Rows,
    moves: FloatArray,
    misses: FloatArray,
    inverse: FloatArray,
    drift: Mapping[str, float],
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(m,) by how much the errors of each row differ from those that it entered the fit with,
    the covariance of the numbers by these, and what makes Student's 95 % of one sigma.

    The parts of a group have variances of their own: the unbiased quadratic estimates that leave
    the similarity out (Rao's MINQUE): with the projection M on the misses, the squares of part g
    have the expectation sum_k tr(M_gk M_kg) v_k.
    """
    from scipy.stats import norm, t

    m = len(rows.misses)
    unknown = np.concatenate([~np.isfinite(rows.sigma), np.zeros(len(misses) - m, bool)])
    names = np.array([*rows.parts, *[""] * (len(misses) - m)])
    parts = [np.flatnonzero(unknown & (names == g)) for g in dict.fromkeys(names[unknown])]
    follow = _drifted(rows, moves, drift)
    fixed = inverse @ (moves[~unknown].T @ moves[~unknown])
    own = [inverse @ (moves[g].T @ moves[g]) for g in parts]
    free = np.array([len(g) - np.trace(o) for g, o in zip(parts, own, strict=True)])
    share = np.ones(m)
    spread = inverse @ (moves[~unknown].T @ follow[~unknown]) @ inverse
    shaky = np.zeros(len(inverse))
    variances = np.ones(len(parts))
    if parts and (free > 0.1).all():
        system = expected_squares(own, [len(g) for g in parts])
        squares = np.array([float((misses[g] ** 2).sum()) for g in parts])
        squares -= [float(np.trace(o @ fixed)) for o in own]
        variances = np.linalg.lstsq(system, squares, rcond=None)[0]
        for which in _same_group(rows, parts).values():
            pooled = max(float(squares[which].sum() / free[which].sum()), 0.0)
            variances[which] = np.maximum(variances[which], least_variance(pooled, free[which]))
    doubt = np.ones(m) if rows.doubt is None else rows.doubt
    for g, o, v, f in zip(parts, own, variances, free, strict=True):
        worth = independent_share(drift.get(rows.groups[g[0]], 0.0))
        variance = v * more_taken(o, inverse @ (moves[g].T @ follow[g]), len(g))
        share[g] = np.sqrt(variance) * doubt[g]
        worse = doubt[g][:, None] ** 2
        part = variance * (inverse @ ((moves[g] * worse).T @ follow[g]) @ inverse)
        spread = spread + part
        shaky += np.diag(part) ** 2 / max(float(f) * worth, 1.0)
    # Satterthwaite: the degrees of freedom of a sum of estimated variances.
    total = np.maximum(np.diag(spread), 1e-300)
    each = np.clip(total**2 / np.maximum(shaky, 1e-300), 1.0, 1e9)
    return share, spread, t.ppf(0.975, each) / norm.ppf(0.975)


def _same_group(rows: Rows, parts: Sequence[IntArray]) -> dict[str, FloatArray]:
    """Which parts belong to a group."""
    found: dict[str, list[int]] = {}
    for number, part in enumerate(parts):
        found.setdefault(rows.groups[part[0]], []).append(number)
    return {name: np.array(numbers) for name, numbers in found.items()}
