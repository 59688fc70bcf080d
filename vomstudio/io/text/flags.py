"""Cells that contain yes or no, in the notations of various programs and languages."""

from __future__ import annotations

YES = frozenset(
    {"1", "1.0", "true", "t", "yes", "y", "x", "ja", "j", "si", "sí", "sì", "oui", "o", "sim"}
    | {"wahr", "vrai", "vero", "verdadero", "verdadeiro", "да", "истина", "是"}
)
NO = frozenset(
    {"", "0", "0.0", "false", "f", "no", "n", "nein", "non", "não", "falsch", "faux", "falso"}
    | {"-", "–", "nan", "na", "n/a", "none", "null", "<na>", "нет", "ложь", "否"}
)
OVERTURNED = frozenset({"overturned", "inverted", "reversed", "invertida", "überkippt", "-1"})
UPRIGHT = frozenset({"upright", "normal", "right way up", "aufrecht"})


def parse_flag(
    cell: str, yes: frozenset[str] = frozenset(), no: frozenset[str] = frozenset()
) -> bool | None:
    """Interpret a cell as yes or no.

    Parameters
    ----------
    cell : str
    yes, no : frozenset of str
        Additional words used in this column.

    Returns
    -------
    bool or None
        Value of the cell: False for an empty cell, None for an unknown word.
    """
    word = cell.strip().casefold()
    if word in YES or word in yes:
        return True
    return False if word in NO or word in no else None


def is_overturned(cell: str) -> bool | None:
    """Interpret a cell as overturned or not; return None for an unknown word."""
    return parse_flag(cell, OVERTURNED, UPRIGHT)
