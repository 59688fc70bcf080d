"""Memory that a reconstruction will need."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from vomstudio.photogrammetry.base.settings import Settings


@dataclass(frozen=True)
class MemoryNeed:
    """Of depths and their cloud, which take the most memory.

    wanted_px : long side of the photos that the quality asks for; size_px : that fits into memory
    needed_bytes : at size_px; free_bytes : now
    """

    wanted_px: int
    size_px: int
    needed_bytes: int
    free_bytes: int


def memory_need(settings: Settings, sizes: Sequence[tuple[int, int]]) -> MemoryNeed:
    """As the reconstruction itself decides it; sizes : width and height of the photos."""
    from vomstudio.photogrammetry.base.memory import available_bytes
    from vomstudio.photogrammetry.dense.memory_limits import fitting_size, memory_of_all

    wanted = settings.steps.dense_px
    size = fitting_size(wanted, sizes)
    return MemoryNeed(wanted, size, memory_of_all(size, sizes), available_bytes())
