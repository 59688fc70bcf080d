"""Cells that contain yes or no, in the notations of various programs and languages."""

from __future__ import annotations

YES_WORDS = frozenset(
    {"1", "1.0", "true", "t", "yes", "y", "x", "ja", "j", "si", "sí", "sì", "oui", "o", "sim"}
    | {"wahr", "vrai", "vero", "verdadero", "verdadeiro", "да", "истина", "是"}
)
NO_WORDS = frozenset(
    {"", "0", "0.0", "false", "f", "no", "n", "nein", "non", "não", "falsch", "faux", "falso"}
    | {"-", "–", "nan", "na", "n/a", "none", "null", "<na>", "нет", "ложь", "否"}
)
OVERTURNED_WORDS = frozenset({"overturned", "inverted", "reversed", "invertida", "überkippt", "-1"})
UPRIGHT_WORDS = frozenset({"upright", "normal", "right way up", "aufrecht"})


def parse_flag(
    cell: str, yes_words: frozenset[str] = frozenset(), no_words: frozenset[str] = frozenset()
) -> bool | None:
    """Interpret a cell as yes or no.

    Parameters
    ----------
    cell : str
    yes_words, no_words : frozenset of str
        Additional words used in this column.

    Returns
    -------
    bool or None
        Value of the cell: False for an empty cell, None for an unknown word.
    """
    word = cell.strip().casefold()
    if word in YES_WORDS or word in yes_words:
        return True
    return False if word in NO_WORDS or word in no_words else None


def is_overturned(cell: str) -> bool | None:
    """Interpret a cell as overturned or not; return None for an unknown word."""
    return parse_flag(cell, OVERTURNED_WORDS, UPRIGHT_WORDS)
