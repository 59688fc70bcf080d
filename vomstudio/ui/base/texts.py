"""Preparation of texts from other parts of the program for display."""

from __future__ import annotations

from collections.abc import Sequence

from vomstudio.core.words import tr_n

_ENDS = ".!?…"


def format_sentence(text: str) -> str:
    """Return a text with an initial capital and a full stop, unless it is empty."""
    text = text.strip()
    if not text:
        return ""
    return text[:1].upper() + text[1:] + ("" if text[-1] in _ENDS else ".")


def first_sentence(text: str) -> str:
    """Return the first sentence of a text."""
    head, dot, _ = text.partition(". ")
    return head + dot.strip()


def abbreviate_names(names: Sequence[str], max_names: int = 3) -> str:
    """Return the first names of a list, separated by commas, and the number of other names."""
    listed_names = ", ".join(names[:max_names])
    remaining_count = len(names) - max_names
    if remaining_count <= 0:
        return listed_names
    return tr_n(
        "{names} and {count} more", "{names} and {count} more", remaining_count, names=listed_names
    )
