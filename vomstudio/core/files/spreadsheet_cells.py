"""Text that a spreadsheet would calculate, marked so that it does not, and without the mark again.

A cell that begins with =, +, -, @, a tab or a carriage return is a formula to Excel and
LibreOffice, and may fetch or send what its author likes (OWASP, "CSV injection"). An apostrophe
before it makes it text. What begins with an apostrophe gets one more, so that reading gives back
every text.
"""

from __future__ import annotations

import re

from vomstudio.core.files.plain_characters import plain

_CALCULATED = frozenset("=+-@\t\r'")


def guarded(text: str) -> str:
    """The text of a cell as it is written: with an apostrophe before what would be calculated."""
    text = plain(text)
    return f"'{text}" if text[:1] in _CALCULATED and text else text


def guarded_word(cell: str) -> str:
    """As `guarded`, for a cell of a table that somebody else wrote: its numbers, and the dashes
    that stand for none, stay as they are."""
    return cell if _NUMBER.fullmatch(cell) else guarded(cell)


def head_line(words: str) -> str:
    """A line of the `#` block above a table, with its end. Names of files and models stand there,
    and a spreadsheet cuts it into cells as any other line."""
    line = _QUOTED.sub(r'\1 "', plain(" ".join(words.split())))
    return f"# {_CALCULATED_INSIDE.sub(_marked, line)}\n"


def _marked(found: re.Match[str]) -> str:
    return found[0] if _NUMBER.fullmatch(found[2].rstrip(")]}. ")) else f"{found[1]}'{found[2]}"


_NUMBER = re.compile(r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?|[+-]+")
_CALCULATED_INSIDE = re.compile(r"([,;] *)([=+\-@][^,;]*)")
_QUOTED = re.compile(r'([,;])"(?=[=+\-@])')


def unguarded(cell: str) -> str:
    """The text that `guarded` was given; other cells as they are."""
    return cell[1:] if cell[:1] == "'" and cell[1:2] in _CALCULATED and cell[1:] else cell
