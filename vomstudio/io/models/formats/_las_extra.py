"""Handling of LAS files whose description of extra fields is invalid.

The points of such a file are valid, so the description is hidden from laspy, which would reject the
file.
"""

from __future__ import annotations

import io
import struct
from pathlib import Path
from typing import Any

from vomstudio.core.files.regular import open_regular_file
from vomstudio.io.models.formats._las_header import MIN_HEADER_BYTES

_BYTES = 192
_KINDS = 30
_USER_ID_OFFSET = 2


def invalid_extra_record_offset(path: Path) -> int | None:
    """Return the offset of the user ID of an invalid extra bytes record, or None."""
    with open_regular_file(path) as file:
        header_bytes = file.read(MIN_HEADER_BYTES)
        offset, points_offset, count = struct.unpack_from("<HII", header_bytes, 94)
        file.seek(0)
        header = file.read(points_offset)
    for _ in range(count):
        if offset + 54 > len(header):
            return None
        user_id, record_id, length = struct.unpack_from("<16sHH", header, offset + _USER_ID_OFFSET)
        if user_id.split(b"\0")[0] == b"LASF_Spec" and record_id == 4:
            return (
                None
                if _is_valid(header[offset + 54 : offset + 54 + length])
                else offset + _USER_ID_OFFSET
            )
        offset += 54 + length
    return None


def _is_valid(record: bytes) -> bool:
    names: set[str] = set()
    for offset in range(0, len(record) - _BYTES + 1, _BYTES):
        data_type, options = record[offset + 2], record[offset + 3]
        try:
            name = record[offset + 4 : offset + 36].split(b"\0")[0].decode("utf-8")
        except UnicodeDecodeError:
            return False
        if not name or name in names or data_type > _KINDS or (data_type == 0 and options == 0):
            return False
        names.add(name)
    return len(record) % _BYTES == 0


class FileWithHiddenRecord(io.FileIO):
    """File in which the user ID at `offset` is replaced by an unknown one."""

    def __init__(self, path: Path, offset: int) -> None:
        super().__init__(path, "r")
        self._offset = offset

    def readinto(self, buffer: Any, /) -> int:
        start = self.tell()
        count = super().readinto(buffer)
        if count and start <= self._offset < start + count:
            memoryview(buffer).cast("B")[self._offset - start] = ord("-")
        return count or 0
