"""Names of columns, as they are compared."""

from __future__ import annotations

import re


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
