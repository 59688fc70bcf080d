"""Names in a sentence: of many the first ones, and how many more there are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from vomstudio.words import tr

_MOST = 8


def listed(names: Sequence[str]) -> str:
    if len(names) <= _MOST:
        return ", ".join(names)
    return tr("{names} and {count} more", names=", ".join(names[:_MOST]), count=len(names) - _MOST)


def listed_of(names: Sequence[str], which: npt.NDArray[np.bool_]) -> str:
    """Those of the names that are chosen (n,)."""
    return listed([names[int(row)] for row in np.flatnonzero(which)])
