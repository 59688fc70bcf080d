"""What a reconstruction will need of the machine."""

from __future__ import annotations

import os
from dataclasses import asdict, dataclass
from typing import Any

from vomstudio.photogrammetry.settings import Settings

_ASPECT = 4 / 3


@dataclass(frozen=True)
class MemoryNeed:
    """Of finding depths, which takes the most memory, with as many photos at once as threads.

    wanted_px : long side of the photos that the quality asks for; size_px : that fits into memory
    needed_bytes : at size_px; free_bytes : now
    """

    threads: int
    wanted_px: int
    size_px: int
    needed_bytes: int
    free_bytes: int

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)


def memory_need(settings: Settings) -> MemoryNeed:
    """As the reconstruction itself decides it."""
    from vomstudio.photogrammetry.depthmaps import memory_needed
    from vomstudio.photogrammetry.memory import available_bytes, fitting_size

    threads = settings.threads or os.cpu_count() or 1
    wanted = settings.steps.dense_px
    size = fitting_size(wanted, memory_needed, _ASPECT, threads)
    needed = threads * memory_needed(size, round(size / _ASPECT))
    return MemoryNeed(threads, wanted, size, needed, available_bytes())
