"""How far a model may turn about its weakest axis, where that is too far for linear least squares.

Points nearly on a line, such as cameras along a flight, hold the turn about it by how far they are
off it. Once it may be ten degrees and more, the squares of the misses no longer grow as the square
of the turn, and heights that are worse than positions weigh differently after it: the linear error
is too small. So the model is turned about that axis to both sides, all else adjusted anew at every
step, until the squares have grown by what chance does in one case of twenty (the profile
likelihood; Venzon & Moolgavkar 1988, Applied Statistics 37, 87-94).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.registration.adjustment import Adjusted, moved, weighed_rows
from vomstudio.registration.observations import Observed, all_rows
from vomstudio.registration.similarity import Similarity

_Z95 = 1.959963984540054
# 95 %, up to which linear errors are as good.
_LINEAR_RAD = np.radians(5.0)
_STEP_RAD = np.radians(10.0)
_STEPS = 18
_ADJUSTED = 3


def widened(kinds: Sequence[Observed], found: Adjusted, centre: FloatArray) -> Adjusted:
    """The same with its errors about the weakest axis as the likelihood has them, where these are
    larger; as it is where something is not determined, or observations share an error.

    centre : (1, 3) model, as for `adjust`
    """
    if found.free.shape[1] or found.rows.shared.shape[1]:
        return found
    _, inverse = weighed_rows(found)
    values, axes = np.linalg.eigh(inverse[:3, :3])
    linear = _Z95 * float(np.sqrt(max(values[-1], 0.0)))
    if not linear > _LINEAR_RAD:
        return found
    axis = axes[:, -1]
    turn = max(_turn_to(kinds, found, centre, side * axis) for side in (1.0, -1.0))
    times = turn / linear
    if not times > 1.0:
        return found
    wider = np.eye(7)
    wider[:3, :3] += (times - 1.0) * np.outer(axis, axis)
    return replace(
        found,
        covariance=wider @ found.covariance @ wider.T,
        plain=wider @ found.plain @ wider.T,
    )


def _turn_to(
    kinds: Sequence[Observed], found: Adjusted, centre: FloatArray, axis: FloatArray
) -> float:
    """Radians about the axis (3,), pi where no turn is unlikely."""
    step = np.zeros(7)
    step[:3] = _STEP_RAD * axis
    fit = found.fit
    least = float(((found.rows.misses / found.sigma) ** 2).sum())
    before = 0.0
    for number in range(_STEPS):
        fit = moved(fit, step, fit(centre)[0])
        fit, squares = _adjusted(kinds, fit, found, centre, axis)
        after = float(np.sqrt(max(squares - least, 0.0)))
        if after > _Z95:
            share = (_Z95 - before) / (after - before)
            return float((number + np.clip(share, 0.0, 1.0)) * _STEP_RAD)
        before = after
    return float(np.pi)


def _adjusted(
    kinds: Sequence[Observed],
    fit: Similarity,
    found: Adjusted,
    centre: FloatArray,
    axis: FloatArray,
) -> tuple[Similarity, float]:
    """With all but the turn about an axis (3,) as the observations want it, and what is left of
    their squares."""
    basis = np.zeros((7, 6))
    basis[:3, :2] = np.linalg.svd(axis[None])[2][1:].T
    basis[3:, 2:] = np.eye(4)
    basis[4:] *= found.size
    for _ in range(_ADJUSTED):
        at = fit(centre)[0]
        rows, _ = all_rows(kinds, fit, at)
        system = rows.moves @ basis / found.sigma[:, None]
        step = -np.linalg.lstsq(system, rows.misses / found.sigma, rcond=None)[0]
        fit = moved(fit, basis @ step, at)
    rows, _ = all_rows(kinds, fit, fit(centre)[0])
    return fit, float(((rows.misses / found.sigma) ** 2).sum())
