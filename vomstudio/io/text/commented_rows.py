"""Detection of rows that begin with `#`, such as a label `#3`, and are read as comments."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from vomstudio.core.finding_texts import Severity
from vomstudio.core.findings import Finding

_MIN_CELLS = 3

SplitFunction = Callable[[str, str], list[str]]
ParseFunction = Callable[..., float | None]


def commented_rows(
    lines: Sequence[str],
    sample: Sequence[str | list[str]],
    width: int,
    delimiter: str,
    split: SplitFunction,
    parse: ParseFunction,
) -> list[int]:
    """Find comments that look like rows of the table.

    Parameters
    ----------
    lines : sequence of str
    sample : sequence of str or list of str
        Some rows, split or not. Without rows, two numbers in a comment are sufficient.
    width : int
        Number of columns; no rows are found if there are fewer than three.
    delimiter : str
    split : callable
        Function that splits a line into cells.
    parse : callable
        Function that returns the number in a cell.

    Returns
    -------
    list of int
        Numbers of the lines, from 1, that have the same width as the rows and contain numbers in
        the numerical columns.
    """
    if width < _MIN_CELLS:
        return []

    def split_row(row: str | list[str]) -> list[str]:
        return split(row, delimiter) if isinstance(row, str) else row

    def is_number(cell: str) -> bool:
        value = parse(cell, decimal_comma=delimiter in ";\t")
        return value is not None and value == value

    rows = [split_row(row) for row in sample]
    columns = [
        column
        for column in range(width)
        if all(is_number(row[column]) for row in rows if len(row) > column)
    ]
    line_numbers = []
    for line_number, line in enumerate(lines, 1):
        if line.lstrip()[:1] != "#":
            continue
        cells = split_row(line.strip()[1:])
        if sample:
            # The label may be the entire first cell.
            resembles_row = len(cells) == width and all(
                is_number(cells[column]) for column in columns if column
            )
        else:
            resembles_row = len(cells) >= width and sum(map(is_number, cells)) >= 2
        if resembles_row and len(columns) >= 2:
            line_numbers.append(line_number)
    return line_numbers


def commented_rows_finding(lines: Sequence[int], severity: Severity = "warning") -> Finding:
    """Return the finding about lines that are comments but look like rows."""
    return Finding("table.commented-rows", severity, count=len(lines), lines=lines)
