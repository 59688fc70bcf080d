"""Characters that a file of text can hold.

Names come from journals, tables and models of anybody. Control characters in them have no place in
XML (XML 1.0, 2.2), and make a table one that readers take for a binary file.
"""

from __future__ import annotations

import re

_NO_CHARACTERS = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\ud800-\udfff\ufffe\uffff]")


def plain(text: str) -> str:
    """The text with a space for each character that stands for nothing to be read."""
    return _NO_CHARACTERS.sub(" ", text)
