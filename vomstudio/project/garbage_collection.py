"""Pause of Python's garbage collector while many records are created."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def pause_collection(*, is_long_lived: bool = False) -> Iterator[None]:
    """Pause the garbage collector.

    Records, figures and rows contain no reference cycles, but the collector scans all of them
    repeatedly while their number grows, which takes up to half of the time.

    Parameters
    ----------
    is_long_lived : bool
        Whether the created objects are long-lived and therefore excluded from later scans too,
        which would stop every thread for 30 ms if there are thousands of records. They are still
        freed when their last reference is removed.
    """
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if is_long_lived:
            gc.freeze()
        if was_enabled:
            gc.enable()
