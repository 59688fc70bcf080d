"""How Python shares its time out, so that the window's thread is never kept waiting for long."""

from __future__ import annotations

import gc
import sys

SWITCH_S = 0.0005
"""A thread that computes in Python gives way after so long. The window's thread lets go at every
call of Qt and VTK, and waits as long before it may go on: with Python's own 5 ms a paint of ten
calls beside such a thread takes half as many hundredths of a second."""
YOUNG = 5_000
"""Objects that are made before those among them are looked for that nobody needs."""


def take_short_turns() -> None:
    """Call once, when the window is made."""
    sys.setswitchinterval(SWITCH_S)
    gc.set_threshold(YOUNG, *gc.get_threshold()[1:])


def spares_nothing() -> bool:
    """Whether this is the first window of the process."""
    return gc.get_freeze_count() == 0


def spare_what_is_there() -> None:
    """Whatever has been imported and made stays until the end: going through all of it for
    garbage, in whichever thread, stops every thread for 50 ms and more."""
    gc.freeze()
