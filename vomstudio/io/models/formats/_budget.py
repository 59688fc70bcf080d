"""Memory budget of a reader, relative to the size of its files.

In many formats, a few bytes represent a large amount of data: a mesh at thousands of positions,
lists without length, or rows without values. A reader reports memory to the budget before
allocating it.
"""

from __future__ import annotations

from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding

FREE_BYTES = 150 << 20
BYTES_PER_FILE_BYTE = 8
"""Memory per file byte: a digit with a space, or a one-byte coordinate, becomes eight bytes."""


class Budget:
    def __init__(self, path: Path, size: int) -> None:
        """Create the budget. `size` is the total size of the file and its companions in bytes."""
        self._path = path
        self._remaining_bytes = FREE_BYTES + BYTES_PER_FILE_BYTE * size

    def add(self, size: int) -> None:
        """Add another file that belongs to the model."""
        self._remaining_bytes += BYTES_PER_FILE_BYTE * size

    def take(self, nbytes: int, field: str | None = None) -> None:
        """Reserve memory. Raises InputError if the size of the files does not justify it."""
        self._remaining_bytes -= nbytes
        if self._remaining_bytes < 0:
            raise InputError(Finding("file.inflated"), file=self._path, field=field)
