"""Exit from a process in which threads may still be running.

The interpreter stops other threads when they next request the GIL. If this happens inside a C++
library, the process ends with SIGABRT or SIGSEGV (python/cpython issue 87135), although all work
is complete. This happened about once in a hundred times when a window was closed while a thread
was importing matplotlib.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import sys


def exit_without_finalising(code: int) -> None:
    """End the process with an exit code, without finalising the interpreter.

    The process ends after its main thread and all non-daemon threads have finished. Close open
    files before calling this function.
    """
    atexit.register(_exit, code)


def _exit(code: int) -> None:
    for stream in (sys.stdout, sys.stderr):
        # A program that was started from a desktop menu has None instead of standard streams.
        with contextlib.suppress(AttributeError, OSError, ValueError):
            stream.flush()
    os._exit(code)
