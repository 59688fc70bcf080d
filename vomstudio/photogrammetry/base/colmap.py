"""Use of COLMAP as a library, without output and with cancellation."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable
from typing import Any, TypeVar

from vomstudio.core.errors import Cancelled
from vomstudio.core.progress import Progress
from vomstudio.core.threads import run_in_thread

Result = TypeVar("Result")
_POLL_INTERVAL_S = 0.1


def colmap() -> Any:
    """Return the pycolmap module, set to log only fatal errors and never to standard output."""
    is_first = "pycolmap" not in sys.modules
    import pycolmap

    if is_first and threading.current_thread() is threading.main_thread():
        # COLMAP's logging prints a C++ stack trace on SIGTERM and then ends the process.
        signal.signal(signal.SIGTERM, signal.getsignal(signal.SIGTERM))
    pycolmap.logging.logtostdout = False
    pycolmap.logging.minloglevel = 3
    pycolmap.logging.stderrthreshold = 3
    return pycolmap


def run_cancellable(
    call: Callable[[Any], Result], progress: Progress, count_done: Callable[[], int] = lambda: 0
) -> Result:
    """Run `call(token)` in a thread and report `count_done()` to the progress.

    If the progress raises Cancelled or a keyboard interrupt, the token is cancelled. The exception
    is raised only after the call has ended, so that nothing is written afterwards.
    """
    from concurrent.futures import wait

    token = colmap().CancellationToken()
    future = run_in_thread(call, token, name="colmap")
    try:
        while not wait([future], _POLL_INTERVAL_S).done:
            progress.step(count_done())
        progress.step(count_done())
    except BaseException:
        token.cancel()
        wait([future])
        raise
    try:
        return future.result()
    except InterruptedError as error:
        raise Cancelled() from error
