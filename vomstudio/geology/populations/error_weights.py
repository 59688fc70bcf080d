"""Weights of orientations by their own errors.

A plane that is known better counts more, but not without bound: planes of one set differ by nature
too, and the best measured one does not speak for all. So a plane's weight is 1 / (s^2 + w^2), s its
own standard deviation and w that of the natural scatter, which is found as the one that explains
what the errors leave over (Paule & Mandel 1982, Journal of Research of the National Bureau of
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
JOINT_95 = 2.447746830680816
"""Standard deviations that a joint region of two tilts reaches to, 95 %."""


@dataclass(frozen=True)
class WeightFigures:
    """by : "error". column : where the errors stand. natural_scatter_deg : standard deviation of
    what the errors leave unexplained. effective_n : of how many equal ones they are worth.
    without_error : how many took the median error, having none."""

    by: str
    column: str
    natural_scatter_deg: float
    effective_n: float
    without_error: int


@dataclass(frozen=True, eq=False)
class Errors:
    """error95_deg (n,): joint 95 % error of each, NaN where it is not known; of the column."""

    error95_deg: FloatArray
    column: str


def errors_of(table: OrientationRows) -> Errors:
    """Of a table's rows. Raises UsageError where it has no column of errors, or nothing in it."""
    for column in ERROR_COLUMNS:
        try:
            cells = table.column(column)
        except UsageError:
            continue
        found = np.array([_number(cell) for cell in cells])
        if np.isfinite(found).any():
            return Errors(found, column)
    raise UsageError(
        Finding("table.no-errors", columns=ERROR_COLUMNS),
        file=table.path,
        field="--weights",
    )


def _number(cell: str) -> float:
    try:
        found = float(cell)
    except ValueError:
        return float("nan")
    return found if found >= 0.0 else float("nan")


def weights_of(v: FloatArray, errors: Errors) -> tuple[FloatArray, WeightFigures]:
    """Weights (n,), mean 1, of unit vectors (n, 3), and what is to be said of them."""
    known = np.isfinite(errors.error95_deg)
    given = (
        np.where(known, errors.error95_deg, np.median(errors.error95_deg[known]))
        if known.any()
        else np.ones(len(v))
    )
    variance = np.radians(given / JOINT_95) ** 2
    natural = 0.0
    weights = np.ones(len(v))
    for _ in range(50):
        squares, free = _residuals(v, weights)
        found = _natural_variance(squares, free, variance)
        weights = 1.0 / np.maximum(variance + found, 1e-16)
        weights /= weights.mean()
        if abs(found - natural) <= 1e-9 * max(found, 1e-12):
            break
        natural = found
    scatter = float(np.degrees(np.sqrt(natural)))
    said = WeightFigures(
        "error", errors.column, scatter, effective_number(weights), int((~known).sum())
    )
    return weights, said


def _residuals(v: FloatArray, weights: FloatArray) -> tuple[FloatArray, float]:
    """Squared angles from the mean of a cluster, else from the great circle, and their degrees of
    freedom a plane."""
    values, axes = orientation_tensor(v, weights)
    point, girdle, _ = vollmer(values)
    n = len(v)
    if point >= girdle:
        along = np.abs(v @ axes[0])
        return np.arccos(np.minimum(along, 1.0)) ** 2, 2.0 * (n - 1.0)
    return np.arcsin(np.clip(v @ axes[2], -1.0, 1.0)) ** 2, n - 2.0


def _natural_variance(squares: FloatArray, free: float, variance: FloatArray) -> float:
    """The variance with which the weighted squares are as large as their degrees of freedom."""
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
