"""Names of columns, as they are compared."""

from __future__ import annotations

import re
from collections.abc import Sequence

from vomstudio.io.text.rows import parse_number, shortened


def plain(name: str) -> str:
    """A column's name without case, separators and unit: what is compared.

    `Dip direction (deg)`, `dip_direction_deg` and `DIPDIRECTION` are all `dipdirection`.
    """
    text = _without_brackets(name.casefold()).replace("°", " ")
    text = re.sub(r"(?<=[\s_\-.])(deg|degrees?|metres?|meters?|m)\s*$", "", text)
    return re.sub(r"[\W_]+", "", text)


def _without_brackets(text: str) -> str:
    """With a blank for each pair of brackets and what is in it. By hand: a pattern would look for
    the end of every bracket that has none, through all of a long name."""
    kept, at = [], 0
    while begun := _OPENS.search(text, at):
        ended = _CLOSES.search(text, begun.end())
        if ended is None:
            break
        kept += [text[at : begun.start()], " "]
        at = ended.end()
    return "".join([*kept, text[at:]])


_OPENS, _CLOSES = re.compile(r"[\[(]"), re.compile(r"[\])]")


def doubtful_cell(names: Sequence[str], line: int | None, delimiter: str) -> str | None:
    """Return a cell that is a word if other cells of the header are numbers, else None.

    Such a header may be a row of data. The line is None for a table that is not from a file.
    """
    values = [parse_number(name, decimal_comma=delimiter in ";\t") for name in names]
    words = [name for name, value in zip(names, values, strict=True) if value is None]
    if line is None or not words or not any(v is not None and v == v for v in values):
        return None
    return shortened(words[0], 40)
