"""COLMAP as a library: quiet, and stoppable."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable
from typing import Any, TypeVar

from vomstudio.errors import Cancelled
from vomstudio.progress import Progress

Result = TypeVar("Result")
_POLL_S = 0.1


def colmap() -> Any:
    """The pycolmap module, which then says only what is fatal, and never on standard output."""
    first = "pycolmap" not in sys.modules
    import pycolmap

    if first and threading.current_thread() is threading.main_thread():
        # Its logging prints a stack of C++ and ends the process where it is asked to end.
        signal.signal(signal.SIGTERM, signal.getsignal(signal.SIGTERM))
    pycolmap.logging.logtostdout = False
    pycolmap.logging.minloglevel = 3
    pycolmap.logging.stderrthreshold = 3
    return pycolmap


def cancellable(
    call: Callable[[Any], Result], progress: Progress, done: Callable[[], int] = lambda: 0
) -> Result:
    """Run `call(token)` in a thread of its own, telling `done()` to the progress meanwhile.

    What stops the progress (Cancelled, an interrupt from the keyboard) cancels the token; the call
    is waited for, so that nothing writes behind the caller's back, and then it is raised.
    """
    token = colmap().CancellationToken()
    results: list[Result] = []
    failures: list[BaseException] = []

    def work() -> None:
        try:
            results.append(call(token))
        except BaseException as error:  # noqa: BLE001  (raised again by who waits)
            failures.append(error)

    thread = threading.Thread(target=work, name="colmap", daemon=True)
    thread.start()
    try:
        while thread.is_alive():
            thread.join(_POLL_S)
            progress.step(done())
    except BaseException:
        token.cancel()
        thread.join()
        raise
    if failures:
        if isinstance(failures[0], InterruptedError):
            raise Cancelled() from failures[0]
        raise failures[0]
    return results[0]
