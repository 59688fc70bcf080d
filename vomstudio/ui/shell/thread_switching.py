"""Thread switching and garbage collection, set so that the window's thread never waits for long."""

from __future__ import annotations

import gc
import sys

SWITCH_S = 0.0005
"""Seconds after which a thread that computes in Python lets another one run. The window's thread
releases the interpreter at every call of Qt and VTK and then waits this long for it: with Python's
default of 5 ms, a paint of ten calls beside a computing thread takes 50 ms."""
YOUNG = 5_000
"""Number of new objects after which the garbage collector runs."""


def shorten_switch_interval() -> None:
    """Set switch interval and collector threshold; called once, when the window is made."""
    sys.setswitchinterval(SWITCH_S)
    gc.set_threshold(YOUNG, *gc.get_threshold()[1:])


def nothing_frozen() -> bool:
    """Whether `freeze_objects` has not been called yet: this is the process's first window."""
    return gc.get_freeze_count() == 0


def freeze_objects() -> None:
    """Take all present objects out of garbage collection: they stay until the program ends, and
    scanning them stops every thread for 50 ms and more."""
    gc.freeze()
