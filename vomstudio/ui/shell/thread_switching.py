"""Settings of thread switching and garbage collection for a responsive window."""

from __future__ import annotations

import gc
import sys

SWITCH_INTERVAL_S = 0.0005
"""Time, in seconds, after which a thread that runs Python code yields to another thread. The
window's thread releases the interpreter at every call of Qt and VTK, and then waits this long to
get it back. With Python's default of 5 ms, a paint with ten calls takes 50 ms while another thread
is computing."""
YOUNG_OBJECTS_THRESHOLD = 5_000
"""Number of new objects that triggers the garbage collector."""


def shorten_switch_interval() -> None:
    """Set the switch interval and collector threshold. Called once for the first window."""
    sys.setswitchinterval(SWITCH_INTERVAL_S)
    gc.set_threshold(YOUNG_OBJECTS_THRESHOLD, *gc.get_threshold()[1:])


def is_unfrozen() -> bool:
    """Return whether `freeze_objects` has not been called yet in this process."""
    return gc.get_freeze_count() == 0


def freeze_objects() -> None:
    """Exclude all present objects from garbage collection.

    They remain until the program ends, and scanning them would stop all threads for 50 ms or
    more.
    """
    gc.freeze()
