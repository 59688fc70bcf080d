"""Text encodings: UTF-16 is recognised by its byte order mark; other text is UTF-8."""

from __future__ import annotations

MARKS = (b"\xff\xfe", b"\xfe\xff")
"""Byte order marks of UTF-16."""
_UTF8_MARK = b"\xef\xbb\xbf"


def convert_to_utf8(raw_bytes: bytes) -> bytes:
    """Convert UTF-16 to UTF-8 and remove a byte order mark.

    Other data are unchanged; damaged UTF-16 characters are replaced.
    """
    if raw_bytes[:2] in MARKS:
        return raw_bytes.decode("utf-16", "replace").encode()
    return raw_bytes.removeprefix(_UTF8_MARK)


def decode_text(raw_bytes: bytes) -> str:
    """Decode UTF-16 or UTF-8. Raises UnicodeDecodeError for other data."""
    return convert_to_utf8(raw_bytes).decode("utf-8")
