"""Limits for the decompressed content of a file."""

from __future__ import annotations

from vomstudio.core.files.available_memory import free_bytes

BYTES_PER_FILE_BYTE = 100
"""Maximum compression ratio; photos and masks have a lower one unless they are nearly blank."""
FREE_ALLOWANCE_BYTES = 500_000_000
"""Allowance for files of any size, such as a blank picture of 100 megapixels."""


def compression_limit(file_bytes: int) -> int:
    """Return the maximum decompressed size of a file, in bytes."""
    return BYTES_PER_FILE_BYTE * file_bytes + FREE_ALLOWANCE_BYTES


def decoding_limit(file_bytes: int) -> int:
    """Return the maximum decompressed content of a file in memory at a time, in bytes.

    This is `compression_limit`, but not more than half of the free memory if the system reports
    it.
    """
    limit, available_bytes = compression_limit(file_bytes), free_bytes()
    return limit if available_bytes is None else min(limit, available_bytes // 2)
