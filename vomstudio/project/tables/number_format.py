"""Formatting of numbers with their usual number of digits."""

from __future__ import annotations

from typing import Any


def number(value: Any, decimals: int) -> str:
    """Return a number with fixed decimals, or `-` if it is undefined."""
    return "-" if value is None else f"{value:.{decimals}f}"


def figures(value: Any, digits: int = 4) -> str:
    """Return a number of any magnitude with significant digits."""
    if value is None:
        return "-"
    return f"{value:.{digits}g}" if 1e-3 <= abs(value) < 1e6 or value == 0 else f"{value:.3e}"


def azimuth(value: Any, decimals: int = 1) -> str:
    """Return an azimuth with three digits before the decimal point."""
    if value is None:
        return "-"
    wrapped_azimuth = round(value, decimals) % 360.0
    return f"{wrapped_azimuth:0{4 + decimals if decimals else 3}.{decimals}f}"
