"""Escaping of text that a spreadsheet would evaluate as a formula.

Excel and LibreOffice evaluate a cell that begins with =, +, -, @, a tab or a carriage return, and
the formula may load or send data (OWASP, "CSV injection"). A leading apostrophe turns the cell
into text. A text that already begins with an apostrophe gets another one, so that every text can
be restored.
"""

from __future__ import annotations

import re

from vomstudio.core.files.plain_characters import replace_control_characters

_FORMULA_STARTS = frozenset("=+-@\t\r'")


def escape_formula(text: str) -> str:
    """Return the text of a cell, prefixed with an apostrophe if it would be evaluated.

    Control characters are replaced by spaces.
    """
    text = replace_control_characters(text)
    return f"'{text}" if text[:1] in _FORMULA_STARTS and text else text


def escape_foreign_cell(cell: str) -> str:
    """Escape a cell of a foreign table, except for numbers and dashes (missing values)."""
    return cell if _NUMBER.fullmatch(cell) else escape_formula(cell)


def comment_line(text: str) -> str:
    """Return a line of the `#` comment block above a table, including the line ending.

    The line contains names of files and models, and a spreadsheet splits it into cells like any
    other line.
    """
    line = _QUOTED_FORMULA.sub(r'\1 "', replace_control_characters(" ".join(text.split())))
    return f"# {_INNER_FORMULA.sub(_escape_match, line)}\n"


def _escape_match(match: re.Match[str]) -> str:
    return match[0] if _NUMBER.fullmatch(match[2].rstrip(")]}. ")) else f"{match[1]}'{match[2]}"


_NUMBER = re.compile(r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?|[+-]+")
_INNER_FORMULA = re.compile(r"([,;] *)([=+\-@][^,;]*)")
_QUOTED_FORMULA = re.compile(r'([,;])"(?=[=+\-@])')


def unescape_formula(cell: str) -> str:
    """Return the original text of a cell that `escape_formula` may have changed."""
    return cell[1:] if cell[:1] == "'" and cell[1:2] in _FORMULA_STARTS and cell[1:] else cell
