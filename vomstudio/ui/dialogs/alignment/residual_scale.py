"""Exaggeration of residual vectors."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt


def exaggeration(lengths: npt.ArrayLike, long_side_px: float) -> int:
    """Return a round factor by which residual vectors are enlarged.

    A vector of median length becomes at most a fiftieth of the long side of the photo, unless it is
    longer without enlargement.

    Parameters
    ----------
    lengths : array_like
        Lengths of the residuals in pixels.
    long_side_px : float
        Long side of the photo in pixels.

    Returns
    -------
    int
        Exaggeration factor; 1 if the median is zero or there are no residuals.
    """
    lengths_px = np.asarray(lengths, np.float64)
    median_px = float(np.median(lengths_px)) if len(lengths_px) else 0.0
    if not median_px > 0:
        return 1
    max_factor = max(1.0, long_side_px / 50 / median_px)
    magnitude = 10 ** math.floor(math.log10(max_factor))
    return max(int(step * magnitude) for step in (1, 2, 5) if step * magnitude <= max_factor)
