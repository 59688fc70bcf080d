"""Memory for depth maps and their cloud, and the size of photos that fits into it."""

from __future__ import annotations

from collections.abc import Sequence

from vomstudio.photogrammetry.base import memory
from vomstudio.photogrammetry.dense import depthmaps, fusion


def memory_of_all(side: int, sizes: Sequence[tuple[int, int]]) -> int:
    """Bytes for the depths of photos whose long side is reduced to `side`, one at a time, and for
    the cloud of them all, whichever is more. sizes : width and height as they were taken"""
    reduced = []
    for width, height in sizes:
        scale = min(1.0, side / max(width, height))
        reduced.append((round(width * scale), round(height * scale)))
    areas = [width * height for width, height in reduced]
    one = max(depthmaps.memory_needed(*size) for size in reduced)
    return max(one, fusion.memory_needed(sum(areas), max(areas)))


def fitting_size(wanted_px: int, sizes: Sequence[tuple[int, int]]) -> int:
    """The long side of the photos whose pixels get a depth, at most `wanted_px`, with which the
    work fits into the memory that is free; sizes as in `memory_of_all`."""
    return memory.fitting_size(wanted_px, lambda side: memory_of_all(side, sizes))
