"""Exclusion of rows that repeat another pick, so that each structure counts once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.io.text.column_names import normalise_name
from vomstudio.io.text.tables import TextTable

_REPEAT_COLUMN = normalise_name("repeat_of")


def exclude_repeats(table: TextTable) -> TextTable:
    """Return a table without the rows that repeat others according to `repeat_of`.

    A note of the table states the number of excluded rows. A table without that column is returned
    unchanged.

    Raises
    ------
    InputError
        If all rows are repeats.
    """
    names = [normalise_name(name) for name in table.names or ()]
    if _REPEAT_COLUMN not in names or not len(table):
        return table
    first_rows = [i for i, cell in enumerate(table.cells(names.index(_REPEAT_COLUMN))) if not cell]
    if len(first_rows) == len(table):
        return table
    if not first_rows:
        raise InputError(
            Finding("table.only-repeats"),
            file=table.path,
            field=(table.names or ("repeat_of",))[names.index(_REPEAT_COLUMN)],
        )
    return replace(
        table,
        repeats=len(table) - len(first_rows),
        notes=(*table.notes, repeats_finding(len(table) - len(first_rows))),
        line_numbers=table.line_numbers[np.array(first_rows)],
        _text=replace(table._text, rows=[table.rows[i] for i in first_rows], lines=[]),
    )


def repeats_finding(count: int) -> Finding:
    """Return the finding about excluded repeats for operations that count structures."""
    return Finding("table.repeats-left-out", count=count)


def repeats_note(count: int) -> tuple[str, ...]:
    """Return the note about excluded repeats for a figure; empty if there are none."""
    if not count:
        return ()
    return (repeats_finding(count).message,)
