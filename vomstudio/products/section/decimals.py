"""Number of decimals of a length with an error."""

from __future__ import annotations

import math


def decimals_for(error: float) -> int:
    """Return the number of decimals at which the error has two significant digits."""
    if not math.isfinite(error) or error <= 0:
        return 3
    return min(max(0, 1 - math.floor(math.log10(error))), 6)


def format_with_error(value: float, error95: float | None) -> str:
    """Format a value with its error, e.g. "2.46 ± 0.06", or with three decimals if none."""
    if error95 is None:
        return f"{value:.3f}"
    digits = decimals_for(error95)
    return f"{value:.{digits}f} ± {error95:.{digits}f}"
