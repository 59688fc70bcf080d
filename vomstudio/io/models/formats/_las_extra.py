"""A LAS file whose extra fields are described in a way that nobody can follow: its points are
sound, so the description is hidden from laspy, which would refuse the file."""

from __future__ import annotations

import io
import struct
from pathlib import Path
from typing import Any

from vomstudio.core.files.regular import open_regular
from vomstudio.io.models.formats._las_header import MIN_HEADER_BYTES

_BYTES = 192
_KINDS = 30
_USER_AT = 2


def place_of_unsound_extra(path: Path) -> int | None:
    """Where the user of the record of extra bytes stands in the file, if it cannot be followed."""
    with open_regular(path) as file:
        head = file.read(MIN_HEADER_BYTES)
        at, points_at, count = struct.unpack_from("<HII", head, 94)
        file.seek(0)
        top = file.read(points_at)
    for _ in range(count):
        if at + 54 > len(top):
            return None
        user, number, length = struct.unpack_from("<16sHH", top, at + _USER_AT)
        if user.split(b"\0")[0] == b"LASF_Spec" and number == 4:
            return None if _is_sound(top[at + 54 : at + 54 + length]) else at + _USER_AT
        at += 54 + length
    return None


def _is_sound(record: bytes) -> bool:
    names: set[str] = set()
    for at in range(0, len(record) - _BYTES + 1, _BYTES):
        number, options = record[at + 2], record[at + 3]
        try:
            name = record[at + 4 : at + 36].split(b"\0")[0].decode("utf-8")
        except UnicodeDecodeError:
            return False
        if not name or name in names or number > _KINDS or (number == 0 and options == 0):
            return False
        names.add(name)
    return len(record) % _BYTES == 0


class WithoutRecord(io.FileIO):
    """A file in which the record at `place` belongs to nobody that is known."""

    def __init__(self, path: Path, place: int) -> None:
        super().__init__(path, "r")
        self._place = place

    def readinto(self, buffer: Any, /) -> int:
        start = self.tell()
        count = super().readinto(buffer)
        if count and start <= self._place < start + count:
            memoryview(buffer).cast("B")[self._place - start] = ord("-")
        return count or 0
