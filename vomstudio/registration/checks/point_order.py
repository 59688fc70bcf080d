"""Check for points whose coordinates are in another row order than their labels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vomstudio.core.arrays import FloatArray, IndexArray
from vomstudio.core.findings import Finding
from vomstudio.registration.checks.comparison import Misfit, is_far_better_fit, residual_misfit

_MIN_POINTS, _MAX_POINTS = 5, 60
_SIGNIFICANCE = 0.001


class RowOrder(NamedTuple):
    """Row order that fits: the points `rows` have the coordinates of `coordinate_rows`."""

    rows: IndexArray
    coordinate_rows: IndexArray
    misfit: Misfit


def find_row_order(model: FloatArray, world: FloatArray) -> RowOrder | None:
    """Find the shifted or reversed row order of coordinates that fits the points best.

    Parameters
    ----------
    model, world : (n, 3) ndarray

    Returns
    -------
    RowOrder or None
        Row order, or None if no order fits far better than that of the table.
    """
    n = len(model)
    original_misfit = residual_misfit(model, world)
    if not _MIN_POINTS <= n <= _MAX_POINTS or original_misfit is None:
        return None
    rows = np.arange(n)
    orders = [(rows, np.roll(rows, -k)) for k in range(1, n)]
    orders += [(rows, np.roll(rows[::-1], k)) for k in range(n)]
    # Assume that a row was added to one of the lists, so that the last row has no partner.
    for k in range(1, min(n // 3, n - _MIN_POINTS) + 1):
        orders += [(rows[:-k], rows[k:]), (rows[k:], rows[:-k])]
    best_order: RowOrder | None = None
    for model_rows, world_rows in orders:
        misfit = residual_misfit(model[model_rows], world[world_rows])
        if misfit is not None and (
            best_order is None or misfit.variance < best_order.misfit.variance
        ):
            best_order = RowOrder(model_rows, world_rows, misfit)
    if best_order is None or not is_far_better_fit(
        best_order.misfit, original_misfit, _SIGNIFICANCE / len(orders)
    ):
        return None
    return best_order


def row_order_findings(
    labels: Sequence[str], model: FloatArray, world: FloatArray, *, is_photo_table: bool = False
) -> list[Finding]:
    """Return a finding if the coordinates of points or photos belong to other rows.

    Parameters
    ----------
    labels : sequence of str
    model, world : (n, 3) ndarray
    is_photo_table : bool, optional
        Whether the rows are photos, not points.

    Returns
    -------
    list of Finding
    """
    order, misfit = find_row_order(model, world), residual_misfit(model, world)
    if order is None or misfit is None:
        return []
    values = {
        "after_m": float(np.sqrt(3.0 * order.misfit.variance)),
        "before_m": float(np.sqrt(3.0 * misfit.variance)),
        "first": labels[int(order.rows[0])],
        "second": labels[int(order.coordinate_rows[0])],
    }
    if is_photo_table:
        return [Finding("control.other-order", **values, photos=True)]
    return [Finding("control.other-order", **values)]
