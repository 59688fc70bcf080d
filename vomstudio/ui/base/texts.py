"""Texts from other parts of the program, made ready to be shown."""

from __future__ import annotations

from collections.abc import Sequence

from vomstudio.core.words import tr_n

_ENDS = ".!?…"


def format_sentence(text: str) -> str:
    """A text with a capital at the beginning and a full stop at the end; "" stays as it is."""
    text = text.strip()
    if not text:
        return ""
    return text[:1].upper() + text[1:] + ("" if text[-1] in _ENDS else ".")


def abbreviate_names(names: Sequence[str], shown: int = 3) -> str:
    """The first names of a list with commas between them, and how many more there are."""
    first = ", ".join(names[:shown])
    more = len(names) - shown
    if more <= 0:
        return first
    return tr_n("{names} and {count} more", "{names} and {count} more", more, names=first)
