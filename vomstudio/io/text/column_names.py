"""Comparison of column names."""

from __future__ import annotations

import re
from collections.abc import Sequence

from vomstudio.io.text.rows import parse_number, shorten


def normalise_name(name: str) -> str:
    """Return a column name without case, separators and unit, for comparisons.

    `Dip direction (deg)`, `dip_direction_deg` and `DIPDIRECTION` all become `dipdirection`.
    """
    text = _remove_brackets(name.casefold()).replace("°", " ")
    text = re.sub(r"(?<=[\s_\-.])(deg|degrees?|metres?|meters?|m)\s*$", "", text)
    return re.sub(r"[\W_]+", "", text)


def _remove_brackets(text: str) -> str:
    """Replace each pair of brackets and its content by a space.

    A single pattern is not used: for a long name with unclosed brackets, its run time would be
    quadratic.
    """
    parts, offset = [], 0
    while opening_match := _OPENING.search(text, offset):
        closing_match = _CLOSING.search(text, opening_match.end())
        if closing_match is None:
            break
        parts += [text[offset : opening_match.start()], " "]
        offset = closing_match.end()
    return "".join([*parts, text[offset:]])


_OPENING, _CLOSING = re.compile(r"[\[(]"), re.compile(r"[\])]")


def doubtful_cell(names: Sequence[str], line: int | None, delimiter: str) -> str | None:
    """Return a word of a header that also contains numbers, or None.

    Such a header may be a row of data. `line` is None for a table that is not from a file; in this
    case, None is returned.
    """
    values = [parse_number(name, decimal_comma=delimiter in ";\t") for name in names]
    text_names = [name for name, value in zip(names, values, strict=True) if value is None]
    if (
        line is None
        or not text_names
        or not any(value is not None and value == value for value in values)
    ):
        return None
    return shorten(text_names[0], 40)
