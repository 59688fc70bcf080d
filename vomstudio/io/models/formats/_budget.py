"""What may be made in memory of a file, against the bytes that are there.

Formats let a few bytes stand for much: a mesh in thousands of places, lists of no length, rows that
nothing fills. A reader tells the budget what it is about to make, before it makes it.
"""

from __future__ import annotations

from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding

FREE_BYTES = 150 << 20
PER_BYTE = 8
"""A digit and a blank of text become eight bytes, as does a coordinate of one byte."""


class Budget:
    def __init__(self, path: Path, size: int) -> None:
        """size : of the file, and of those that belong to it, in bytes."""
        self._path = path
        self._left = FREE_BYTES + PER_BYTE * size

    def add(self, size: int) -> None:
        """Another file belongs to the model."""
        self._left += PER_BYTE * size

    def take(self, nbytes: int, field: str | None = None) -> None:
        """Raises InputError where so much more cannot have come from the file's bytes."""
        self._left -= nbytes
        if self._left < 0:
            raise InputError(Finding("file.inflated"), file=self._path, field=field)
