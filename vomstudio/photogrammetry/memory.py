"""How much memory there is, how much was needed, and what size of photos fits."""

from __future__ import annotations

# What the system and other programs are left.
SHARE = 0.7


def available_bytes() -> int:
    """Memory that can be taken now without swapping."""
    import psutil

    return int(psutil.virtual_memory().available)


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


def fitting_size(wanted_px: int, bytes_per_pixel: float, aspect: float, at_once: int) -> int:
    """The long side, at most `wanted_px`, with which `at_once` photos can be worked on.

    bytes_per_pixel : that the work on one photo needs for each of its pixels
    aspect : long side over short side
    """
    pixels = SHARE * available_bytes() / (bytes_per_pixel * at_once)
    fits = int((pixels * aspect) ** 0.5)
    return min(wanted_px, max(fits, 320))
