"""Number of decimals of a length with an error."""

from __future__ import annotations

import math

MAX_DECIMALS = 3
"""Decimals of a millimetre; only smaller errors have more."""


def decimal_count(error: float) -> int:
    """Return the number of decimals at which the error has two significant digits.

    More than `MAX_DECIMALS`, but at most 6, are used only if the error would be zero otherwise.
    """
    if not math.isfinite(error) or error <= 0:
        return MAX_DECIMALS
    decimals = -math.floor(math.log10(error))
    return min(max(0, decimals + 1), max(MAX_DECIMALS, decimals), 6)


def format_with_error(value: float, error95: float | None) -> str:
    """Format a value with its error, e.g. "2.46 ± 0.06"; with three decimals if it has none."""
    if error95 is None:
        return f"{value:.{MAX_DECIMALS}f}"
    digits = decimal_count(error95)
    return f"{value:.{digits}f} ± {error95:.{digits}f}"
