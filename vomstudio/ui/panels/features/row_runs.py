"""Runs of consecutive rows, because Qt handles ranges faster than single rows."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np


def find_runs(rows: Iterable[int], max_count: int | None = None) -> list[tuple[int, int]]:
    """Return the first and last row of each run of consecutive rows, in ascending order.

    Parameters
    ----------
    rows : iterable of int
    max_count : int, optional
        Number of runs above which a single run that spans all rows is returned.
    """
    numbers = np.unique(np.fromiter(rows, np.int64))
    if not len(numbers):
        return []
    ends = np.flatnonzero(np.diff(numbers) > 1)
    if max_count is not None and len(ends) >= max_count:
        return [(int(numbers[0]), int(numbers[-1]))]
    first_rows = numbers[np.concatenate([[0], ends + 1])]
    last_rows = numbers[np.concatenate([ends, [len(numbers) - 1]])]
    return list(zip(first_rows.tolist(), last_rows.tolist(), strict=True))
