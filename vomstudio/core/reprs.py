"""How objects with figures are shown in a console and a notebook."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from html import escape
from typing import Any

from vomstudio.core.results import Result

_MOST = 6


class Shown(Result):
    """A dataclass that a console and a notebook show with one line for each field."""

    def __repr__(self) -> str:
        return in_lines(type(self).__name__, self._figures())

    def _repr_html_(self) -> str:
        return html_table(type(self).__name__, self._figures())

    def _figures(self) -> dict[str, Any]:
        """Return the object with its findings as sentences."""
        return {name: _replace_findings(value) for name, value in self.to_dict().items()}


def _replace_findings(value: Any) -> Any:
    """Return a value with the messages of findings in their places."""
    if isinstance(value, Mapping):
        if value.keys() >= {"code", "severity", "message"}:
            return value["message"]
        return {name: _replace_findings(each) for name, each in value.items()}
    if isinstance(value, list):
        return [_replace_findings(each) for each in value]
    return value


def in_lines(title: str, figures: Mapping[str, Any]) -> str:
    """A name and its value on each line; what does not apply is left out."""
    named = dict(_flat(figures))
    width = max(map(len, named), default=0)
    return "\n".join([title, *(f"  {name:<{width}}  {text}" for name, text in named.items())])


def html_table(title: str, figures: Mapping[str, Any]) -> str:
    """The same as a table of two columns."""
    rows = "".join(
        f"<tr><th style='text-align:left'>{escape(name)}</th>"
        f"<td style='text-align:left'>{escape(text)}</td></tr>"
        for name, text in _flat(figures)
    )
    return f"<table><caption>{escape(title)}</caption>{rows}</table>"


def _flat(figures: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, str]]:
    """Groups of groups are named with a point; a group of plain values stands on one line."""
    for key, value in figures.items():
        name = f"{before}{key}"
        if value is None or (isinstance(value, list | tuple) and not value):
            continue
        if isinstance(value, Mapping) and any(isinstance(v, Mapping) for v in value.values()):
            yield from _flat(value, f"{name}.")
        else:
            yield name, shown(value)


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
        if len(value) > _MOST or any(isinstance(each, Mapping | list | tuple) for each in value):
            return f"{len(value)} entries"
        separator = "; " if any(isinstance(each, str) for each in value) else ", "
        return separator.join(shown(each) for each in value)
    return str(value)
