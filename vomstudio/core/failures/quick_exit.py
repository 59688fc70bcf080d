"""The end of a process that threads may still be at work in.

Python that ends itself stops a thread wherever it next asks for the interpreter. Inside a library
of C++ that ends the process by SIGABRT or SIGSEGV (python/cpython issue 87135), after everything
went well: a window that was closed while a thread still imported matplotlib did so once in a
hundred times.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import sys


def end_with(code: int) -> None:
    """Let the process end with this exit code without ending Python, as soon as its main thread and
    the threads that are waited for, those that are not daemons, have ended. What is open must have
    been closed by then."""
    atexit.register(_end, code)


def _end(code: int) -> None:
    for stream in (sys.stdout, sys.stderr):
        # There is no stream where the program was started from a menu.
        with contextlib.suppress(AttributeError, OSError, ValueError):
            stream.flush()
    os._exit(code)
