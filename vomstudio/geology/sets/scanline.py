"""Parser of a straight scanline."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding


def parse_scanline(text: str | None) -> FloatArray | None:
    """Parse the end points of a scanline, "x,y,z,x,y,z".

    Parameters
    ----------
    text : str or None

    Returns
    -------
    (2, 3) ndarray or None
        End points in metres; None if there is no text.

    Raises
    ------
    UsageError
        If the text is not a valid scanline.
    """
    if text is None:
        return None
    try:
        line = np.array([float(word) for word in text.replace(";", ",").split(",")])
    except ValueError:
        line = np.empty(0)
    if line.size != 6 or not np.isfinite(line).all() or not (line[:3] != line[3:]).any():
        raise UsageError(Finding("sets.not-a-scanline"), field="--scanline")
    return line.reshape(2, 3)
