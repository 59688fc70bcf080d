"""Replacement of characters that are not allowed in text files.

Names come from journals, tables and models of unknown sources. Control characters are not valid in
XML (XML 1.0, 2.2), and readers mistake a table that contains them for a binary file.
"""

from __future__ import annotations

import re

_INVALID_CHARACTERS = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\ud800-\udfff\ufffe\uffff]")


def replace_control_characters(text: str) -> str:
    """Return the text with each control character or lone surrogate replaced by a space."""
    return _INVALID_CHARACTERS.sub(" ", text)
