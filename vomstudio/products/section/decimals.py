"""How many digits a length is written with."""

from __future__ import annotations

import math


def decimals_for(error: float) -> int:
    """Of a value with this error, so that the error has two figures."""
    if not math.isfinite(error) or error <= 0:
        return 3
    return min(max(0, 1 - math.floor(math.log10(error))), 6)


def with_error(value: float, error95: float | None) -> str:
    """ "2.46 ± 0.06"; three decimals where nothing is known of the error."""
    if error95 is None:
        return f"{value:.3f}"
    digits = decimals_for(error95)
    return f"{value:.{digits}f} ± {error95:.{digits}f}"
