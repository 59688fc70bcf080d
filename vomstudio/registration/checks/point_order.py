"""Lists of points that were numbered in another order than the coordinates beside them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vomstudio.core.arrays import FloatArray, IndexArray
from vomstudio.core.findings import Finding
from vomstudio.registration.checks.comparison import Left, far_better, left_over

_FEWEST, _MOST = 5, 60
_BY_CHANCE = 0.001


class Order(NamedTuple):
    """The points `rows` have the coordinates of those in `others`; what is left over then."""

    rows: IndexArray
    others: IndexArray
    left: Left


def other_order(model: FloatArray, world: FloatArray) -> Order | None:
    """The order of coordinates (n, 3) that fits points of the model (n, 3) best: some rows on, or
    in reverse; None where none fits far better than the one given."""
    n = len(model)
    given = left_over(model, world)
    if not _FEWEST <= n <= _MOST or given is None:
        return None
    rows = np.arange(n)
    tried = [(rows, np.roll(rows, -k)) for k in range(1, n)]
    tried += [(rows, np.roll(rows[::-1], k)) for k in range(n)]
    # A row was added to one of two lists, and the last one has no partner.
    for k in range(1, min(n // 3, n - _FEWEST) + 1):
        tried += [(rows[:-k], rows[k:]), (rows[k:], rows[:-k])]
    best: Order | None = None
    for own, others in tried:
        left = left_over(model[own], world[others])
        if left is not None and (best is None or left.variance < best.left.variance):
            best = Order(own, others, left)
    if best is None or not far_better(best.left, given, _BY_CHANCE / len(tried)):
        return None
    return best


def row_order_findings(
    labels: Sequence[str], model: FloatArray, world: FloatArray, *, photos: bool = False
) -> list[Finding]:
    """Return a message if the coordinates of points or photos are those of other rows."""
    found, given = other_order(model, world), left_over(model, world)
    if found is None or given is None:
        return []
    words = {
        "after_m": float(np.sqrt(3.0 * found.left.variance)),
        "before_m": float(np.sqrt(3.0 * given.variance)),
        "first": labels[int(found.rows[0])],
        "second": labels[int(found.others[0])],
    }
    if photos:
        return [Finding("control.other-order", **words, photos=True)]
    return [Finding("control.other-order", **words)]
