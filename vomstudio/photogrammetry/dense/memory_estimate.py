"""Memory for depth maps and their cloud, and the photo size that fits into it."""

from __future__ import annotations

from collections.abc import Sequence

from vomstudio.photogrammetry.base import memory
from vomstudio.photogrammetry.dense import depthmaps, fusion


def peak_memory(page_side: int, sizes: Sequence[tuple[int, int]]) -> int:
    """Return the larger of the peak memories of a single depth map and the fusion, in bytes.

    page_side : long side of the reduced photos
    sizes : width and height of each original photo
    """
    reduced_sizes = []
    for width, height in sizes:
        scale = min(1.0, page_side / max(width, height))
        reduced_sizes.append((round(width * scale), round(height * scale)))
    areas = [width * height for width, height in reduced_sizes]
    bytes_per_photo = max(depthmaps.peak_memory_bytes(*size) for size in reduced_sizes)
    return max(bytes_per_photo, fusion.peak_memory_bytes(sum(areas), max(areas)))


def fitting_size(wanted_px: int, sizes: Sequence[tuple[int, int]]) -> int:
    """Return a long side of the photos at which their depth maps fit into free memory.

    wanted_px : maximum long side
    sizes : as in `peak_memory`
    """
    return memory.fitting_size(wanted_px, lambda side: peak_memory(side, sizes))
