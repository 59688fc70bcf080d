"""Exaggeration with which residuals are drawn."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt


def exaggeration(lengths: npt.ArrayLike, long_side: float) -> int:
    """By what round factor vectors of these lengths (pixels) are drawn, so that the usual one takes
    up to a fiftieth of the photo's long side; 1 where there is nothing to be enlarged."""
    lengths_px = np.asarray(lengths, np.float64)
    median_px = float(np.median(lengths_px)) if len(lengths_px) else 0.0
    if not median_px > 0:
        return 1
    target = max(1.0, long_side / 50 / median_px)
    magnitude = 10 ** math.floor(math.log10(target))
    return max(int(step * magnitude) for step in (1, 2, 5) if step * magnitude <= target)
