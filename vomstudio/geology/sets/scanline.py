"""A straight scanline as it is typed."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.errors import UsageError
from vomstudio.words import tr


def parse_scanline(text: str | None) -> npt.NDArray[np.float64] | None:
    """(2, 3) ends of "x,y,z,x,y,z", m; None for None. Raises UsageError."""
    if text is None:
        return None
    try:
        found = np.array([float(word) for word in text.replace(";", ",").split(",")])
    except ValueError:
        found = np.empty(0)
    return checked_scanline(found.reshape(2, 3) if found.shape == (6,) else found)


def checked_scanline(line: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The same line. Raises UsageError for what is no line (2, 3) with a length."""
    if line.shape != (2, 3) or not np.isfinite(line).all() or not (line[0] != line[1]).any():
        raise UsageError(
            tr("A scanline is two different points, x,y,z,x,y,z, in metres."), field="--scanline"
        )
    return line
