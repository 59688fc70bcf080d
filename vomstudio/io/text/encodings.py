"""Texts as programs of all systems save them: UTF-16 is told by its mark, all else is UTF-8."""

from __future__ import annotations

MARKS = (b"\xff\xfe", b"\xfe\xff")
"""By which UTF-16 begins, of either byte order."""
_UTF8_MARK = b"\xef\xbb\xbf"


def as_utf8(raw: bytes) -> bytes:
    """The same text in UTF-8, without a byte order mark; what is no UTF-16 remains as it is. What
    is damaged in it becomes the sign for that."""
    if raw[:2] in MARKS:
        return raw.decode("utf-16", "replace").encode()
    return raw.removeprefix(_UTF8_MARK)


def text_of(raw: bytes) -> str:
    """Raises UnicodeDecodeError where it is neither UTF-16 nor UTF-8."""
    return as_utf8(raw).decode("utf-8")
