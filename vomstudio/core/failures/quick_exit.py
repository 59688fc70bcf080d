"""Exit of a process in which threads may still be running.

The interpreter stops other threads when they next request the GIL. Inside a C++ library that ends
the process by SIGABRT or SIGSEGV (python/cpython issue 87135), although all work is complete: this
happened once in a hundred times to a window that was closed while a thread imported matplotlib.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import sys


def exit_without_finalising(code: int) -> None:
    """End the process with an exit code, without finalising the interpreter.

    The process ends after its main thread and all threads that are not daemons. Close open files
    before.
    """
    atexit.register(_exit, code)


def _exit(code: int) -> None:
    for stream in (sys.stdout, sys.stderr):
        # The streams are None if the program was started from a menu.
        with contextlib.suppress(AttributeError, OSError, ValueError):
            stream.flush()
    os._exit(code)
