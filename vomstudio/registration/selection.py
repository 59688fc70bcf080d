"""Names of the rows that a mask selects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt


def selected(names: Sequence[str], mask: npt.NDArray[np.bool_]) -> list[str]:
    """Return the names of the rows that a mask (n,) selects."""
    return [names[int(row)] for row in np.flatnonzero(mask)]
