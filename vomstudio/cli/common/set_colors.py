"""Colours of the sets of a figure."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from vomstudio.core.findings import Finding
from vomstudio.errors import UsageError


def colors_among(colors: Mapping[str, str], names: Collection[str]) -> dict[str, str]:
    """By the names of the sets that there are; planes and lines of one name have the same colour.
    Raises UsageError for a set that is not there."""
    found: dict[str, str] = {}
    for name, color in colors.items():
        meant = [n for n in names if n in (name, f"{name} (planes)", f"{name} (lines)")]
        if not meant:
            raise UsageError(
                Finding("option.not-a-choice", value=name, choices=list(names)), field="--color"
            )
        found |= dict.fromkeys(meant, color)
    return found
