"""Colours of the sets in a figure."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding


def select_colors(colors: Mapping[str, str], names: Collection[str]) -> dict[str, str]:
    """Return the colours selected by the user, keyed by the set names of a figure.

    The planes and the lines of a set have the same colour.

    Parameters
    ----------
    colors : mapping of str to str
        Colours by set name as typed by the user.
    names : collection of str
        Names of the sets in the figure.

    Raises
    ------
    UsageError
        If a set is not in the figure.
    """
    set_colors: dict[str, str] = {}
    for name, color in colors.items():
        matches = [n for n in names if n in (name, f"{name} (planes)", f"{name} (lines)")]
        if not matches:
            raise UsageError(
                Finding("option.not-a-choice", value=name, choices=list(names)), field="--color"
            )
        set_colors |= dict.fromkeys(matches, color)
    return set_colors
