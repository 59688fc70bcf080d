"""Signals that end a command in the same way as Ctrl+C, without partial results."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator
from typing import Any

from vomstudio.core.failures import stop_requests

_SIGNAL_NAMES = ("SIGTERM", "SIGHUP")


@contextlib.contextmanager
def interrupt_on_stop_signals() -> Iterator[None]:
    """Raise KeyboardInterrupt on SIGTERM and SIGHUP in the block.

    Signals with another handler, and those that the parent process ignores (nohup), are unaffected.
    Outside the main thread, nothing changes.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    previous_handlers: dict[int, Any] = {}
    for name in _SIGNAL_NAMES:
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is signal.SIG_DFL:
            previous_handlers[number] = signal.SIG_DFL
            stop_requests.listen(number)
    try:
        yield
    finally:
        for number, handler in previous_handlers.items():
            signal.signal(number, handler)
