"""Text and HTML representations of results for consoles and notebooks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from html import escape
from typing import Any

from vomstudio.core.results import Result

_MAX_SHOWN_ITEMS = 6


class PrintableResult(Result):
    """Dataclass that consoles and notebooks display with one line per field."""

    def __repr__(self) -> str:
        return text_table(type(self).__name__, self._figures())

    def _repr_html_(self) -> str:
        return html_table(type(self).__name__, self._figures())

    def _figures(self) -> dict[str, Any]:
        """Return the dict of the result with findings replaced by sentences."""
        return {name: _replace_findings(value) for name, value in self.to_dict().items()}


def _replace_findings(value: Any) -> Any:
    """Return a value in which findings are replaced by their messages."""
    if isinstance(value, Mapping):
        if value.keys() >= {"code", "severity", "message"}:
            return value["message"]
        return {name: _replace_findings(item) for name, item in value.items()}
    if isinstance(value, list):
        return [_replace_findings(item) for item in value]
    return value


def text_table(title: str, figures: Mapping[str, Any]) -> str:
    """Return figures as lines of names and values, omitting None and empty lists."""
    texts = dict(_flatten(figures))
    width = max(map(len, texts), default=0)
    return "\n".join([title, *(f"  {name:<{width}}  {text}" for name, text in texts.items())])


def html_table(title: str, figures: Mapping[str, Any]) -> str:
    """Return figures as an HTML table of two columns, omitting None and empty lists."""
    rows = "".join(
        f"<tr><th style='text-align:left'>{escape(name)}</th>"
        f"<td style='text-align:left'>{escape(text)}</td></tr>"
        for name, text in _flatten(figures)
    )
    return f"<table><caption>{escape(title)}</caption>{rows}</table>"


def _flatten(figures: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, str]]:
    """Yield name and text of each figure; names of nested groups are joined with a dot."""
    for key, value in figures.items():
        name = f"{prefix}{key}"
        if value is None or (isinstance(value, list | tuple) and not value):
            continue
        if isinstance(value, Mapping) and any(isinstance(v, Mapping) for v in value.values()):
            yield from _flatten(value, f"{name}.")
        else:
            yield name, format_figure(value)


def format_figure(value: Any) -> str:
    """Format a figure with six significant digits; an undefined figure becomes a dash."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {format_figure(item)}" for key, item in value.items())
    if isinstance(value, list | tuple):
        if len(value) > _MAX_SHOWN_ITEMS or any(
            isinstance(item, Mapping | list | tuple) for item in value
        ):
            return f"{len(value)} entries"
        separator = "; " if any(isinstance(item, str) for item in value) else ", "
        return separator.join(format_figure(item) for item in value)
    return str(value)
