"""Objects as a notebook shows them."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any


def shown(value: Any) -> str:
    """A figure with six significant digits, undefined as a dash."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {shown(each)}" for key, each in value.items())
    if isinstance(value, list | tuple):
        if len(value) > 6:
            return f"{len(value)} entries"
        return ", ".join(shown(each) for each in value)
    return str(value)


def html_table(title: str, figures: Mapping[str, Any]) -> str:
    """Two columns, name and value; what does not apply is left out."""
    rows = "".join(
        f"<tr><th style='text-align:left'>{escape(str(name))}</th>"
        f"<td style='text-align:left'>{escape(shown(value))}</td></tr>"
        for name, value in figures.items()
        if value is not None
    )
    return f"<table><caption>{escape(title)}</caption>{rows}</table>"


def in_lines(title: str, figures: Mapping[str, Any]) -> str:
    """The same as text."""
    named = {name: shown(value) for name, value in figures.items() if value is not None}
    width = max(map(len, named), default=0)
    lines = [f"  {name:<{width}}  {text}" for name, text in named.items()]
    return "\n".join([title, *lines])
