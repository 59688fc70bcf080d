"""Rows that begin with `#`, as labels such as `#3` do: they are comments, and that is said."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from vomstudio.core.finding_texts import Severity
from vomstudio.core.findings import Finding

_FEWEST_CELLS = 3

Cut = Callable[[str, str], list[str]]
Parsed = Callable[..., float | None]


def commented_rows(
    lines: Sequence[str],
    sample: Sequence[str | list[str]],
    width: int,
    delimiter: str,
    cut_: Cut,
    parse: Parsed,
) -> list[int]:
    """The lines, counted from 1, that begin with # and have as many cells as the rows, with numbers
    where all of these have some.

    sample : some rows, cut or not; without one any two numbers will do
    cut_, parse : what makes cells of a line, and a number of a cell
    """
    if width < _FEWEST_CELLS:
        return []

    def cut(row: str | list[str]) -> list[str]:
        return cut_(row, delimiter) if isinstance(row, str) else row

    def number(cell: str) -> bool:
        value = parse(cell, decimal_comma=delimiter in ";\t")
        return value is not None and value == value

    rows = [cut(row) for row in sample]
    columns = [c for c in range(width) if all(number(row[c]) for row in rows if len(row) > c)]
    found = []
    for at, line in enumerate(lines, 1):
        if line.lstrip()[:1] != "#":
            continue
        cells = cut(line.strip()[1:])
        if sample:
            # The label may have been all of the first cell.
            like = len(cells) == width and all(number(cells[c]) for c in columns if c)
        else:
            like = len(cells) >= width and sum(map(number, cells)) >= 2
        if like and len(columns) >= 2:
            found.append(at)
    return found


def commented_finding(lines: Sequence[int], severity: Severity = "warning") -> Finding:
    """Return the finding about lines that are comments and look like rows."""
    return Finding("table.commented-rows", severity, count=len(lines), lines=lines)
