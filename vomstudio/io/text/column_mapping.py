"""Meanings of columns stated by the user, for tables with unknown column names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.io.text.column_names import normalise_name
from vomstudio.io.text.orientation_columns import ALIASES
from vomstudio.io.text.slip_columns import SLIP_NAMES
from vomstudio.io.text.tables import TextTable

MEANINGS = tuple(
    dict.fromkeys(
        (
            *(meaning.replace(" ", "_") for meaning in ALIASES),
            *SLIP_NAMES,
            *("x", "y", "z", "name", "station", "domain", "notes"),
        )
    )
)
"""Meanings that can be stated for a column."""


def parse_columns(text: str | None) -> dict[str, str]:
    """Return the meaning of each column by its name or number.

    Parameters
    ----------
    text : str or None
        Text such as ``azi=dip_direction,inc=dip`` or ``1=trend,2=plunge``.

    Raises
    ------
    UsageError
        If the text has another form, or a meaning is unknown.
    """
    columns: dict[str, str] = {}
    for item in (text or "").split(",") if text is not None else ():
        name, equals_sign, meaning = (part.strip() for part in item.rpartition("="))
        if not (name and equals_sign and meaning):
            raise UsageError(Finding("columns.invalid", text=item.strip()), field="--columns")
        columns[name] = parse_meaning(meaning)
    return columns


def parse_meaning(text: str) -> str:
    """Return the usual form of a meaning, which may be given by an alias.

    Parameters
    ----------
    text : str

    Returns
    -------
    str

    Raises
    ------
    UsageError
        If the meaning is unknown.
    """
    word = normalise_name(text)
    for meaning in MEANINGS:
        if normalise_name(meaning) == word:
            return meaning
    for meaning, aliases in (*ALIASES.items(), *SLIP_NAMES.items()):
        if word in map(normalise_name, aliases):
            return meaning.replace(" ", "_")
    finding = Finding("columns.unknown-meaning", meaning=text, meanings=MEANINGS)
    raise UsageError(finding, field="--columns")


def name_columns(table: TextTable, meanings: Mapping[str, str]) -> TextTable:
    """Name columns by their stated meaning.

    Parameters
    ----------
    table : TextTable
    meanings : mapping of str to str
        Meaning of each column by its name or its number from 1.

    Raises
    ------
    UsageError
        If the table has no such column.
    """
    if not meanings:
        return table
    names = [table.label(i) for i in range(table.width)]
    for name, meaning in meanings.items():
        names[table.find(name)] = meaning
    return replace(table, names=tuple(names))
