"""Profile likelihood of the rotation about the weakest axis, beyond linear least squares.

Points that lie nearly on a line, such as cameras along a flight line, determine the rotation about
the line by their distances from it. If the error may reach ten degrees or more, the squared
residuals no longer increase with the square of the rotation, and heights with larger errors have a
different weight, so the linear error is too small. The model is therefore rotated about this axis
in both directions, with all other parameters adjusted at every step, until the squares exceed the
95 % limit (Venzon & Moolgavkar 1988, Applied Statistics 37, 87-94).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.registration.adjustment import Adjustment, apply_step, weighted_rows
from vomstudio.registration.observations import ObservationKind, all_rows
from vomstudio.registration.similarity import Similarity

_Z95 = 1.959963984540054
# 95 % error up to which the linear error is accurate.
_MAX_LINEAR_RAD = np.radians(5.0)
_STEP_RAD = np.radians(10.0)
_MAX_STEPS = 18
_ITERATIONS = 3


def widen_by_likelihood(
    kinds: Sequence[ObservationKind], result: Adjustment, centre: FloatArray
) -> Adjustment:
    """Widen the error about the weakest axis if the likelihood gives a larger error.

    The result is unchanged if a direction is undetermined or observations have a common error.

    Parameters
    ----------
    kinds : sequence of ObservationKind
    result : Adjustment
    centre : (1, 3) ndarray
        Centre in the model frame; see `adjust`.

    Returns
    -------
    Adjustment
    """
    if result.null_space.shape[1] or result.rows.shared_design.shape[1]:
        return result
    _, inverse = weighted_rows(result)
    values, axes = np.linalg.eigh(inverse[:3, :3])
    linear_half_width = _Z95 * float(np.sqrt(max(values[-1], 0.0)))
    if not linear_half_width > _MAX_LINEAR_RAD:
        return result
    axis = axes[:, -1]
    rotation = max(_rotation_limit(kinds, result, centre, sign * axis) for sign in (1.0, -1.0))
    factor = rotation / linear_half_width
    if not factor > 1.0:
        return result
    widening_matrix = np.eye(7)
    widening_matrix[:3, :3] += (factor - 1.0) * np.outer(axis, axis)
    return replace(
        result,
        covariance=widening_matrix @ result.covariance @ widening_matrix.T,
        plain_covariance=widening_matrix @ result.plain_covariance @ widening_matrix.T,
    )


def _rotation_limit(
    kinds: Sequence[ObservationKind], result: Adjustment, centre: FloatArray, axis: FloatArray
) -> float:
    """Return the 95 % limit of rotations about an axis (3,), in rad, or pi if all are likely."""
    step = np.zeros(7)
    step[:3] = _STEP_RAD * axis
    fit = result.fit
    min_squares = float(((result.rows.residuals / result.sigma) ** 2).sum())
    distance_before = 0.0
    for iteration in range(_MAX_STEPS):
        fit = apply_step(fit, step, fit(centre)[0])
        fit, squares = _adjust_other_parameters(kinds, fit, result, centre, axis)
        distance_after = float(np.sqrt(max(squares - min_squares, 0.0)))
        if distance_after > _Z95:
            fraction = (_Z95 - distance_before) / (distance_after - distance_before)
            return float((iteration + np.clip(fraction, 0.0, 1.0)) * _STEP_RAD)
        distance_before = distance_after
    return float(np.pi)


def _adjust_other_parameters(
    kinds: Sequence[ObservationKind],
    fit: Similarity,
    result: Adjustment,
    centre: FloatArray,
    axis: FloatArray,
) -> tuple[Similarity, float]:
    """Adjust all parameters but the rotation about an axis (3,); return fit and squares."""
    basis = np.zeros((7, 6))
    basis[:3, :2] = np.linalg.svd(axis[None])[2][1:].T
    basis[3:, 2:] = np.eye(4)
    basis[4:] *= result.size
    for _ in range(_ITERATIONS):
        position = fit(centre)[0]
        rows, _ = all_rows(kinds, fit, position)
        system = rows.design @ basis / result.sigma[:, None]
        step = -np.linalg.lstsq(system, rows.residuals / result.sigma, rcond=None)[0]
        fit = apply_step(fit, basis @ step, position)
    rows, _ = all_rows(kinds, fit, fit(centre)[0])
    return fit, float(((rows.residuals / result.sigma) ** 2).sum())
