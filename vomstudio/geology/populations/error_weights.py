"""Weights of orientations according to their individual errors.

Planes with smaller errors have larger weights, but within limits: planes of one set also differ by
nature, and the most accurate plane does not represent all of them. The weight of a plane is 1 /
(s^2 + w^2), where s is its standard deviation and w that of the natural scatter. The latter is
estimated as the scatter that the errors do not explain (Paule & Mandel 1982, Journal of Research of
the National Bureau of Standards 87, 377-385).
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
    """Summary of the weights of a set.

    Attributes
    ----------
    by : {"error"}
    column : str
        Table column that contains the errors.
    natural_scatter_deg : float
        Standard deviation of the scatter that the errors do not explain, degrees.
    effective_n : float
        Number of orientations of equal weight that would be equally informative.
    without_error : int
        Number of rows without an error, to which the median error was assigned.
    """

    by: str
    column: str
    natural_scatter_deg: float
    effective_n: float
    without_error: int


@dataclass(frozen=True, eq=False)
class OrientationErrors:
    """Joint 95 % error (n,) of each row in degrees (NaN if unknown), and its table column."""

    error95_deg: FloatArray
    column: str


def read_errors(table: OrientationRows) -> OrientationErrors:
    """Read the errors of the rows of a table.

    Raises
    ------
    UsageError
        If the table has no column of errors, or if all of these columns are empty.
    """
    for column in ERROR_COLUMNS:
        try:
            cells = table.column(column)
        except UsageError:
            continue
        values = np.array([_parse_error(cell) for cell in cells])
        if np.isfinite(values).any():
            return OrientationErrors(values, column)
    raise UsageError(
        Finding("table.no-errors", columns=ERROR_COLUMNS),
        file=table.path,
        field="--weights",
    )


def _parse_error(cell: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        return float("nan")
    return value if value >= 0.0 else float("nan")


def weights_by_error(v: FloatArray, errors: OrientationErrors) -> tuple[FloatArray, WeightFigures]:
    """Compute weights of unit vectors from their errors.

    Parameters
    ----------
    v : (n, 3) ndarray
        Unit vectors.
    errors : OrientationErrors

    Returns
    -------
    weights : (n,) ndarray
        Weights, scaled to a mean of 1.
    figures : WeightFigures
    """
    is_known = np.isfinite(errors.error95_deg)
    error95_deg = (
        np.where(is_known, errors.error95_deg, np.median(errors.error95_deg[is_known]))
        if is_known.any()
        else np.ones(len(v))
    )
    variance = np.radians(error95_deg / JOINT_QUANTILE95) ** 2
    natural_variance = 0.0
    weights = np.ones(len(v))
    for _ in range(50):
        squares, degrees_of_freedom = _squared_residuals(v, weights)
        updated_variance = _natural_variance(squares, degrees_of_freedom, variance)
        weights = 1.0 / np.maximum(variance + updated_variance, 1e-16)
        weights /= weights.mean()
        if abs(updated_variance - natural_variance) <= 1e-9 * max(updated_variance, 1e-12):
            break
        natural_variance = updated_variance
    scatter = float(np.degrees(np.sqrt(natural_variance)))
    figures = WeightFigures(
        "error", errors.column, scatter, effective_number(weights), int((~is_known).sum())
    )
    return weights, figures


def _squared_residuals(v: FloatArray, weights: FloatArray) -> tuple[FloatArray, float]:
    """Return the squared angles from the mean of a cluster, or from the circle of a girdle.

    The second value is the number of degrees of freedom.
    """
    eigenvalues, axes = orientation_tensor(v, weights)
    point, girdle, _ = vollmer(eigenvalues)
    n = len(v)
    if point >= girdle:
        projections = np.abs(v @ axes[0])
        return np.arccos(np.minimum(projections, 1.0)) ** 2, 2.0 * (n - 1.0)
    return np.arcsin(np.clip(v @ axes[2], -1.0, 1.0)) ** 2, n - 2.0


def _natural_variance(
    squares: FloatArray, degrees_of_freedom: float, variance: FloatArray
) -> float:
    """Return the variance for which the weighted squares equal their degrees of freedom."""
    if degrees_of_freedom <= 0.0:
        return 0.0

    def excess_dispersion(natural_variance: float) -> float:
        return (
            float(np.sum(squares / np.maximum(variance + natural_variance, 1e-16)))
            - degrees_of_freedom
        )

    if excess_dispersion(0.0) <= 0.0:
        return 0.0
    low, high = 0.0, float(squares.sum() / degrees_of_freedom) + 1e-12
    for _ in range(100):
        centre = 0.5 * (low + high)
        low, high = (centre, high) if excess_dispersion(centre) > 0.0 else (low, centre)
    return 0.5 * (low + high)
