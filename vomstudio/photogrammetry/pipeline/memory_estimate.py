"""Memory requirement of a reconstruction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from vomstudio.photogrammetry.base.settings import PipelineSettings


@dataclass(frozen=True)
class MemoryRequirement:
    """Memory requirement of the depth maps and their cloud, the largest of all stages.

    Attributes
    ----------
    wanted_px, size_px : int
        Long side of the photos selected by the quality, and the long side that fits into memory.
    needed_bytes : int
        Memory required at `size_px`.
    free_bytes : int
        Memory that is currently available.
    """

    wanted_px: int
    size_px: int
    needed_bytes: int
    free_bytes: int


def estimate_memory(
    settings: PipelineSettings, sizes: Sequence[tuple[int, int]]
) -> MemoryRequirement:
    """Return the memory requirement of photos with these widths and heights."""
    from vomstudio.photogrammetry.base.memory import available_bytes
    from vomstudio.photogrammetry.dense.memory_estimate import fitting_size, peak_memory

    requested_px = settings.quality_sizes.dense_px
    size = fitting_size(requested_px, sizes)
    return MemoryRequirement(requested_px, size, peak_memory(size, sizes), available_bytes())
