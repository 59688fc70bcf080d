"""Cells that answer yes or no, as programs and people write them."""

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


def answer(
    cell: str, yes: frozenset[str] = frozenset(), no: frozenset[str] = frozenset()
) -> bool | None:
    """Yes, no (an empty cell as well), or None where the word is neither.

    yes, no : further words of this column
    """
    word = cell.strip().casefold()
    if word in YES or word in yes:
        return True
    return False if word in NO or word in no else None


def is_overturned(cell: str) -> bool | None:
    """Of a bed, by the cell of its column. None where the word is not understood."""
    return answer(cell, OVERTURNED, UPRIGHT)
