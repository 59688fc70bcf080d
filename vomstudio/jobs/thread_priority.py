"""Priority of threads."""

from __future__ import annotations

import contextlib
import os
import sys
import threading


def lower_priority(niceness: int = 5) -> None:
    """Let the window's thread, and those that draw for it, go before this thread; with 19 it works
    only while nobody else does. Only Linux has priorities of threads."""
    if sys.platform == "linux":
        with contextlib.suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), niceness)
