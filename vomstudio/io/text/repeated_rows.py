"""Rows of a table that repeat the pick of another: a structure that was picked twice is no two."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.io.text.column_names import plain
from vomstudio.io.text.tables import TextTable

_COLUMN = plain("repeat_of")


def first_picks(table: TextTable) -> TextTable:
    """Its rows that repeat no other, by the column `repeat_of`; how many were left out is one of
    its notes. Raises InputError where nothing is left."""
    names = [plain(name) for name in table.names or ()]
    if _COLUMN not in names or not len(table):
        return table
    first = [i for i, cell in enumerate(table.cells(names.index(_COLUMN))) if not cell]
    if len(first) == len(table):
        return table
    if not first:
        raise InputError(
            Finding("table.only-repeats"),
            file=table.path,
            field=(table.names or ("repeat_of",))[names.index(_COLUMN)],
        )
    return replace(
        table,
        repeats=len(table) - len(first),
        notes=(*table.notes, repeats_left_out(len(table) - len(first))),
        line_numbers=table.line_numbers[np.array(first)],
        _text=replace(table._text, rows=[table.rows[i] for i in first], lines=[]),
    )


def repeats_left_out(count: int) -> Finding:
    """Return the finding about picks that repeat others, wherever structures are counted."""
    return Finding("table.repeats-left-out", count=count)


def repeats_not_drawn(count: int) -> tuple[str, ...]:
    """The note of a figure without so many of them; nothing where there are none."""
    if not count:
        return ()
    return (repeats_left_out(count).message,)
