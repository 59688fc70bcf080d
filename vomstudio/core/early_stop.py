"""What asks the process to end is heard from its first line on, before anything else is read.

Signals that come before `vomstudio.app` hears them would end the process by their own number, or in
a stack of Python's. Nothing has begun by then, so there is nothing to undo: a sentence is written,
and the process ends. It imports what is built into Python alone: `signal` takes as long to read as
all that it would be wanted for.
"""

import _signal
import os
import sys

_SENTENCE = b"vomstudio: Cancelled.\n"
_EXIT_CODE = 130


def stop(number: int, frame: object) -> None:
    """Handle a signal while modules are still being read."""
    try:
        os.write(2, _SENTENCE)
    finally:
        # Where nobody reads stderr the exit code must do.
        os._exit(_EXIT_CODE)


def hear() -> None:
    """From now on. What is ignored stays so. A worker is ended by whoever started it: what asks
    that one to end may reach every process of a terminal."""
    worker = sys.argv[1:2] == ["--worker"]
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        number = getattr(_signal, name, None)
        if number is None or _signal.getsignal(number) not in (
            _signal.SIG_DFL,
            _signal.default_int_handler,
        ):
            continue
        _signal.signal(number, _signal.SIG_IGN if worker else stop)
