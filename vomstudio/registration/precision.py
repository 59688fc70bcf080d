"""Precision of given coordinates, for the errors of points that fit exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.registration.adjustment import Adjustment, adjust
from vomstudio.registration.observations import ObservationKind, Points

# Arrays lose trailing zeros, so coordinates are assumed to be written to at least a centimetre.
_MIN_DECIMALS, _MAX_DECIMALS = 2, 9
_MIN_SPACING_RATIO = 100.0
_ROUNDING = np.sqrt(1.0 / 12.0)
"""Standard deviation of a rounded number, as a share of its last digit."""


def rounding_step(values: npt.ArrayLike) -> float:
    """Return the step to which coordinates were rounded when written.

    Parameters
    ----------
    values : array
        Finite numbers.

    Returns
    -------
    float
        The last decimal if all numbers have at most 9 decimals, otherwise the spacing of float64 at
        the largest number. If float32 stores all numbers without loss and its spacing is larger,
        the spacing of float32.
    """
    x = np.asarray(values, np.float64)
    largest_value = float(np.abs(x).max(initial=0.0))
    float_spacing = float(np.spacing(largest_value))
    if (x == np.round(x)).all():
        return max(10.0**-_MIN_DECIMALS, float_spacing)
    step = float_spacing
    for decimals in range(_MIN_DECIMALS, _MAX_DECIMALS + 1):
        # Any number is close to a decimal that is only slightly coarser than its spacing.
        is_near = np.abs(x - np.round(x, decimals)).max(initial=0.0) <= float_spacing
        if is_near and 10.0**-decimals > _MIN_SPACING_RATIO * float_spacing:
            step = 10.0**-decimals
            break
    if (x.astype(np.float32) == x).all():
        step = max(step, float(np.spacing(np.float32(largest_value))))
    return max(step, float_spacing)


def add_rounding(
    kinds: Sequence[ObservationKind], result: Adjustment, centre: FloatArray, size: float
) -> Adjustment:
    """Widen the errors of a fit whose residuals are smaller than the rounding of coordinates.

    Parameters
    ----------
    kinds : sequence of ObservationKind
        Inputs of the fit.
    result : Adjustment
    centre, size
        See `adjust`.

    Returns
    -------
    Adjustment
        Result with the errors of points that are as accurate as their coordinates.
    """
    groups = np.array(result.rows.groups)
    rounded_kinds: list[ObservationKind] = []
    for kind in kinds:
        if isinstance(kind, Points) and not np.isfinite(kind.sigma).all():
            step = np.hypot(rounding_step(kind.world), result.fit.scale * rounding_step(kind.model))
            sigma = _ROUNDING * float(step)
            estimated_errors = result.error[(groups == kind.name) & ~np.isfinite(result.rows.sigma)]
            if len(estimated_errors) and float(estimated_errors.max()) < sigma:
                stated_sigmas = np.where(np.isfinite(kind.sigma), kind.sigma, sigma)
                kind = replace(kind, sigma=stated_sigmas)
        rounded_kinds.append(kind)
    if all(new_kind is old_kind for new_kind, old_kind in zip(rounded_kinds, kinds, strict=True)):
        return result
    try:
        rounded_result = adjust(rounded_kinds, centre, size)
    except GeometryError:
        return result
    if _worst_error(rounded_result) < _worst_error(result):
        # With few points, the widening by Student's t is larger.
        return result
    return replace(
        result,
        covariance=rounded_result.covariance,
        plain_covariance=rounded_result.plain_covariance,
        error=rounded_result.error,
        sigma=rounded_result.sigma,
    )


def _worst_error(result: Adjustment) -> float:
    return float(np.linalg.eigvalsh(result.rotation)[-1])
