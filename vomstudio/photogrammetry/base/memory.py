"""Available and used memory, and the photo size that fits into it."""

from __future__ import annotations

from collections.abc import Callable

from vomstudio.core.files.available_memory import group_bytes

# Share of the free memory to use; the system and other programs need the rest.
MAX_MEMORY_SHARE = 0.7
_MIN_SIZE_PX = 320


def available_bytes() -> int:
    """Return the memory available without swapping, respecting the limit of a container."""
    import psutil

    available_memory = int(psutil.virtual_memory().available)
    group_memory = group_bytes()
    return available_memory if group_memory is None else min(available_memory, group_memory)


def peak_bytes() -> int:
    """Return the peak memory of this process, in bytes."""
    import psutil

    info = psutil.Process().memory_info()
    if hasattr(info, "peak_wset"):
        return int(info.peak_wset)
    import resource
    import sys

    maximum = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return int(maximum) if sys.platform == "darwin" else int(maximum) * 1024


def worker_count(needed_bytes: int, threads: int) -> int:
    """Return how many of `threads` workers of `needed_bytes` fit into memory; at least 1."""
    if needed_bytes <= 0 or threads <= 1:
        return max(threads, 1)
    return int(min(max(MAX_MEMORY_SHARE * available_bytes() // needed_bytes, 1), threads))


def fitting_size(target_px: int, needed_bytes: Callable[[int], int]) -> int:
    """Return a long side, up to `target_px`, for which enough memory is available.

    The size is reduced in steps of 10 %, but not below 320 pixels even if these need more memory.
    """
    usable_memory = MAX_MEMORY_SHARE * available_bytes()
    size = target_px
    while size > _MIN_SIZE_PX and needed_bytes(size) > usable_memory:
        size = max(_MIN_SIZE_PX, int(size * 0.9))
    return size
