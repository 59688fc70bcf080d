"""Reading of the groups of a DXF drawing, entity by entity.

A DXF file is a list of groups, each of which consists of a code and a value: either two lines of
text, or a number and bytes. Group code 0 begins an entity, a block, a section or a table entry
(AutoCAD DXF Reference).
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from vomstudio.core.files.regular import read_small_file

Value = bytes | int | float
Groups = list[tuple[int, Value]]

MAX_BYTES = 512 << 20
_BINARY_MARK = b"AutoCAD Binary DXF\r\n\x1a\0"
# A code has only digits: a line 0 before a line with a letter is a code and not a value.
_ENTITY_START = re.compile(
    rb"(?m)^[ \t]*0[ \t]*\r?\n[ \t]*(?=[0-9]*[A-Za-z_])([A-Za-z0-9_]+)[ \t]*\r?(?:\n|\Z)"
)
# A line 60 may also be a value; only the groups show which it is.
_INVISIBLE_FLAG = re.compile(rb"(?m)^[ \t]*60[ \t]*\r?\n[ \t]*1[ \t]*\r?$")


@dataclass(frozen=True)
class DxfPiece:
    """Part of a drawing from one group with code 0 to the next.

    Parameters
    ----------
    kind : bytes
        Value of the first group in upper case.
    """

    kind: bytes
    _data: bytes
    _start: int
    _end: int
    _groups: Groups | None = None

    def groups(self) -> Groups:
        """Return the groups after the first, up to an invalid one, parsed on request."""
        if self._groups is not None:
            return self._groups
        lines = self._data[self._start : self._end].splitlines()
        groups: Groups = []
        for code, value in zip(lines[0::2], lines[1::2], strict=False):
            if not code.strip().isdigit():
                break
            groups.append((int(code), value.strip()))
        return groups

    @property
    def span(self) -> tuple[int, int]:
        """Start and end of the groups after the first one in the text of the drawing."""
        return self._start, self._end

    @property
    def may_be_invisible(self) -> bool:
        """Whether a group may mark the entity as invisible."""
        if self._groups is not None:
            return (60, 1) in self._groups
        return _INVISIBLE_FLAG.search(self._data, self._start, self._end) is not None


def dxf_pieces(path: str | Path) -> Iterator[DxfPiece]:
    """Yield the parts of a drawing; a binary drawing ends where it is damaged.

    Raises
    ------
    InputError
        If the file is too large.
    OSError
        If the file cannot be read.
    """
    data = read_small_file(path, MAX_BYTES)
    return _binary_pieces(data) if is_binary(data) else text_pieces(data)


def is_binary(data: bytes) -> bool:
    """Return whether a drawing is a binary DXF."""
    return data.startswith(_BINARY_MARK)


def value_text(value: Value) -> bytes:
    """Return the value of a group as text."""
    return value if isinstance(value, bytes) else str(value).encode()


def text_pieces(data: bytes) -> Iterator[DxfPiece]:
    """Yield the parts of a text DXF file."""
    kind, start = b"", 0
    for match in chain(_ENTITY_START.finditer(data), (None,)):
        yield DxfPiece(kind, data, start, len(data) if match is None else match.start())
        if match is not None:
            kind, start = match[1].upper(), match.end()


_VALUE_SIZES = (
    (range(10), 0),
    (range(10, 60), 8),
    (range(60, 80), 2),
    (range(90, 100), 4),
    (range(100, 110), 0),
    (range(110, 160), 8),
    (range(160, 170), 8),
    (range(170, 180), 2),
    (range(210, 240), 8),
    (range(270, 290), 2),
    (range(290, 300), 1),
    (range(300, 310), 0),
    (range(310, 320), -1),
    (range(320, 370), 0),
    (range(370, 390), 2),
    (range(390, 400), 0),
    (range(400, 410), 2),
    (range(410, 420), 0),
    (range(420, 430), 4),
    (range(430, 440), 0),
    (range(440, 460), 4),
    (range(460, 470), 8),
    (range(470, 482), 0),
    (range(999, 1004), 0),
    (range(1004, 1005), -1),
    (range(1005, 1010), 0),
    (range(1010, 1060), 8),
    (range(1060, 1071), 2),
    (range(1071, 1072), 4),
)
"""Bytes of a value by group code: 0 for zero-terminated text, -1 for a length byte and data."""
_SIZE_BY_CODE = {code: size for codes, size in _VALUE_SIZES for code in codes}


def _binary_pieces(data: bytes) -> Iterator[DxfPiece]:
    kind, groups = b"", Groups()
    for code, value in binary_groups(data):
        if code == 0:
            yield DxfPiece(kind, b"", 0, 0, groups)
            kind, groups = value_text(value).upper(), []
        else:
            groups.append((code, value))
    yield DxfPiece(kind, b"", 0, 0, groups)


def binary_groups(data: bytes) -> Iterator[tuple[int, Value]]:
    """Yield the code and value of each group of a binary DXF file."""
    offset = len(_BINARY_MARK)
    while offset + 2 <= len(data):
        (code,) = struct.unpack_from("<H", data, offset)
        offset += 2
        size = _SIZE_BY_CODE.get(code, 0)
        if size == 0:
            end = data.find(b"\0", offset)
            if end < 0:
                return
            yield code, data[offset:end]
            offset = end + 1
        elif size < 0:
            if offset >= len(data):
                return
            offset += 1 + data[offset]
        else:
            if size in (1, 2, 4):
                yield code, int.from_bytes(data[offset : offset + size], "little", signed=True)
            elif code < 60:
                yield (
                    code,
                    struct.unpack_from("<d", data, offset)[0] if offset + 8 <= len(data) else 0.0,
                )
            offset += size
