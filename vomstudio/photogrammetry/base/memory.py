"""How much memory there is, how much was needed, and what size of photos fits."""

from __future__ import annotations

from collections.abc import Callable

from vomstudio.core.files.available_memory import group_bytes

# The rest is left to the system and to other programs.
SHARE = 0.7
_SMALLEST_PX = 320


def available_bytes() -> int:
    """Memory that can be taken now without swapping; in a container no more than is left to it."""
    import psutil

    available = int(psutil.virtual_memory().available)
    left = group_bytes()
    return available if left is None else min(available, left)


def peak_bytes() -> int:
    """The most that this process has held at once."""
    import psutil

    info = psutil.Process().memory_info()
    if hasattr(info, "peak_wset"):
        return int(info.peak_wset)
    import resource
    import sys

    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return int(most) if sys.platform == "darwin" else int(most) * 1024


def workers_at_once(needed: int, threads: int) -> int:
    """How many of `threads` may work side by side, each taking `needed` bytes; one always may."""
    if needed <= 0 or threads <= 1:
        return max(threads, 1)
    return int(min(max(SHARE * available_bytes() // needed, 1), threads))


def fitting_size(wanted_px: int, needed: Callable[[int], int]) -> int:
    """The long side of photos, at most `wanted_px`, with which `needed(side)` bytes are there."""
    free = SHARE * available_bytes()
    size = wanted_px
    while size > _SMALLEST_PX and needed(size) > free:
        size = max(_SMALLEST_PX, int(size * 0.9))
    return size
