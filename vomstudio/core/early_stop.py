"""Handling of signals that end the process before `vomstudio.app` is imported.

Without this handling, a signal would end the process with a traceback or with the signal
number as its status. No work has begun by then, so there is nothing to undo: the module writes one
sentence and ends the process. It imports only built-in modules because importing `signal` takes
longer than everything done here.
"""

import _signal
import os
import sys

_CANCELLED_MESSAGE = b"vomstudio: Cancelled.\n"
_EXIT_CODE = 130


def stop(signal_number: int, frame: object) -> None:
    """End the process on a signal that arrives while modules are still being imported."""
    try:
        os.write(2, _CANCELLED_MESSAGE)
    finally:
        # If stderr is closed, the exit code is the only report.
        os._exit(_EXIT_CODE)


def handle_signals() -> None:
    """Handle SIGINT, SIGTERM and SIGHUP from now on, except signals that are ignored.

    A worker ignores these signals: its parent ends it, and a terminal signal may reach both
    processes.
    """
    is_worker = sys.argv[1:2] == ["--worker"]
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        signal_number = getattr(_signal, name, None)
        if signal_number is None or _signal.getsignal(signal_number) not in (
            _signal.SIG_DFL,
            _signal.default_int_handler,
        ):
            continue
        _signal.signal(signal_number, _signal.SIG_IGN if is_worker else stop)
