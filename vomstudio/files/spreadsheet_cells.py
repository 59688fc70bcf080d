"""Text that a spreadsheet would calculate, marked so that it does not, and without the mark again.

A cell that begins with =, +, -, @, a tab or a carriage return is a formula to Excel and
LibreOffice, and may fetch or send what its author likes (OWASP, "CSV injection"). An apostrophe
before it makes it text. What begins with an apostrophe gets one more, so that reading gives back
every text.
"""

from __future__ import annotations

_CALCULATED = frozenset("=+-@\t\r'")


def guarded(text: str) -> str:
    """The text of a cell as it is written: with an apostrophe before what would be calculated."""
    return f"'{text}" if text[:1] in _CALCULATED and text else text


def unguarded(cell: str) -> str:
    """The text that `guarded` was given; other cells as they are."""
    return cell[1:] if cell[:1] == "'" and cell[1:2] in _CALCULATED and cell[1:] else cell
