"""Weights of orientations by their own errors.

Planes with smaller errors have larger weights, within limits: planes of one set differ by nature,
too, and the most accurate one does not represent all. The weight of a plane is 1 / (s^2 + w^2) with
its own standard deviation s and that of the natural scatter w, which is estimated as the one that
explains what the errors do not (Paule & Mandel 1982, Journal of Research of the National Bureau of
Standards 87, 377-385).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.statistics import effective_number, orientation_tensor, vollmer

ERROR_COLUMNS = ("total95_deg", "max_confidence95_deg", "max_angular_error_deg")
JOINT_QUANTILE95 = 2.447746830680816
"""Radius of the joint 95 % region of two tilts in standard deviations."""


@dataclass(frozen=True)
class WeightFigures:
    """Weights of a set.

    Attributes
    ----------
    by : {"error"}
    column : str
        Column of the errors.
    natural_scatter_deg : float
        Standard deviation that the errors do not explain, degrees.
    effective_n : float
        Equivalent number of equal weights.
    without_error : int
        Number of rows that took the median error because they have none.
    """

    by: str
    column: str
    natural_scatter_deg: float
    effective_n: float
    without_error: int


@dataclass(frozen=True, eq=False)
class OrientationErrors:
    """Joint 95 % error (n,) of each row, degrees, NaN if unknown, with its column."""

    error95_deg: FloatArray
    column: str


def read_errors(table: OrientationRows) -> OrientationErrors:
    """Read the errors of a table's rows.

    Raises
    ------
    UsageError
        If the table has no column of errors, or an empty one.
    """
    for column in ERROR_COLUMNS:
        try:
            cells = table.column(column)
        except UsageError:
            continue
        values = np.array([_number(cell) for cell in cells])
        if np.isfinite(values).any():
            return OrientationErrors(values, column)
    raise UsageError(
        Finding("table.no-errors", columns=ERROR_COLUMNS),
        file=table.path,
        field="--weights",
    )


def _number(cell: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        return float("nan")
    return value if value >= 0.0 else float("nan")


def weights_by_error(v: FloatArray, errors: OrientationErrors) -> tuple[FloatArray, WeightFigures]:
    """Return weights of unit vectors by their errors, and the figures of the weights.

    Parameters
    ----------
    v : (n, 3) ndarray
        Unit vectors.
    errors : OrientationErrors

    Returns
    -------
    weights : (n,) ndarray
        Their mean is 1.
    figures : WeightFigures
    """
    is_known = np.isfinite(errors.error95_deg)
    error95_deg = (
        np.where(is_known, errors.error95_deg, np.median(errors.error95_deg[is_known]))
        if is_known.any()
        else np.ones(len(v))
    )
    variance = np.radians(error95_deg / JOINT_QUANTILE95) ** 2
    natural = 0.0
    weights = np.ones(len(v))
    for _ in range(50):
        squares, free = _residuals(v, weights)
        estimate = _natural_variance(squares, free, variance)
        weights = 1.0 / np.maximum(variance + estimate, 1e-16)
        weights /= weights.mean()
        if abs(estimate - natural) <= 1e-9 * max(estimate, 1e-12):
            break
        natural = estimate
    scatter = float(np.degrees(np.sqrt(natural)))
    figures = WeightFigures(
        "error", errors.column, scatter, effective_number(weights), int((~is_known).sum())
    )
    return weights, figures


def _residuals(v: FloatArray, weights: FloatArray) -> tuple[FloatArray, float]:
    """Return squared angles from the mean of a cluster, or from the great circle.

    The second value is their degrees of freedom.
    """
    values, axes = orientation_tensor(v, weights)
    point, girdle, _ = vollmer(values)
    n = len(v)
    if point >= girdle:
        along = np.abs(v @ axes[0])
        return np.arccos(np.minimum(along, 1.0)) ** 2, 2.0 * (n - 1.0)
    return np.arcsin(np.clip(v @ axes[2], -1.0, 1.0)) ** 2, n - 2.0


def _natural_variance(squares: FloatArray, free: float, variance: FloatArray) -> float:
    """Return the variance at which the weighted squares equal their degrees of freedom."""
    if free <= 0.0:
        return 0.0

    def excess(natural: float) -> float:
        return float(np.sum(squares / np.maximum(variance + natural, 1e-16))) - free

    if excess(0.0) <= 0.0:
        return 0.0
    low, high = 0.0, float(squares.sum() / free) + 1e-12
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) > 0.0 else (low, middle)
    return 0.5 * (low + high)
