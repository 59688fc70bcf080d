"""How much memory the content of a file may take once it is decompressed."""

from __future__ import annotations

from vomstudio.files.memory_room import free_bytes

BYTES_PER_FILE_BYTE = 100
"""Photos and masks stay below it, except those that are nearly blank."""
FREE_ALLOWANCE_BYTES = 500_000_000
"""For every file, however small: a blank picture of 100 megapixels."""


def compression_limit(file_bytes: int) -> int:
    """Return how many bytes a file of this size may have after decompression."""
    return BYTES_PER_FILE_BYTE * file_bytes + FREE_ALLOWANCE_BYTES


def decoded_limit(file_bytes: int) -> int:
    """Return how many decompressed bytes of a file may be in memory at a time.

    `compression_limit`, and at most half of the free memory where the system reports it.
    """
    limit, free = compression_limit(file_bytes), free_bytes()
    return limit if free is None else min(limit, free // 2)
