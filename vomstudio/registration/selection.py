"""Names of the rows that a mask selects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vomstudio.core.arrays import BoolArray


def select_names(names: Sequence[str], mask: BoolArray) -> list[str]:
    """Return the names of the rows that a mask selects.

    Parameters
    ----------
    names : sequence of str
    mask : (n,) ndarray of bool

    Returns
    -------
    list of str
    """
    return [names[int(row)] for row in np.flatnonzero(mask)]
