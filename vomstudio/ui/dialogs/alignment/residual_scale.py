"""Exaggeration with which residuals are drawn."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt


def exaggeration(lengths: npt.ArrayLike, long_side: float) -> int:
    """By what round factor vectors of these lengths (pixels) are drawn, so that the usual one takes
    up to a fiftieth of the photo's long side; 1 where there is nothing to be enlarged."""
    known = np.asarray(lengths, np.float64)
    usual = float(np.median(known)) if len(known) else 0.0
    if not usual > 0:
        return 1
    wanted = max(1.0, long_side / 50 / usual)
    power = 10 ** math.floor(math.log10(wanted))
    return max(int(step * power) for step in (1, 2, 5) if step * power <= wanted)
