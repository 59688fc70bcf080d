"""Errors of coordinates and attitudes as their user states them."""

from __future__ import annotations

from collections.abc import Mapping

from vomstudio.errors import UsageError
from vomstudio.words import tr

_MOST_M = 1e6
_MOST_DEG = 90.0


def check_errors(metres: Mapping[str, float], degrees: Mapping[str, float] | None = None) -> None:
    """By the names of their options. Raises UsageError for what is negative, endless or undefined,
    and for an angle beyond 90 degrees."""
    for field, value in metres.items():
        if not 0.0 <= value <= _MOST_M:
            raise UsageError(
                tr("Errors must not be negative, nor more than {most:,.0f} metres.", most=_MOST_M),
                field=field,
            )
    for field, value in (degrees or {}).items():
        if not 0.0 <= value <= _MOST_DEG:
            raise UsageError(
                tr("Errors must not be negative, nor more than {most:g} degrees.", most=_MOST_DEG),
                field=field,
            )
