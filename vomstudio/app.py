"""Creation and connection of the objects of the program."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Sequence
from typing import Any

from vomstudio.core.early_stop import stop as stop_early
from vomstudio.core.failures import stop_requests

_STOP_SIGNALS = [
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
]


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command of `vomstudio`, or open the window if no command is given."""
    words = list(sys.argv[1:] if argv is None else argv)
    previous_handlers = _handle_stop_signals()
    try:
        try:
            return _run(words, previous_handlers, owns_process=argv is None)
        finally:
            # The process that has nothing left but its exit code is not asked any more.
            _set_handlers(
                dict.fromkeys(previous_handlers, signal.SIG_IGN)
                if argv is None
                else previous_handlers
            )
    except KeyboardInterrupt:
        # The command has not started to report errors, or has finished.
        print("vomstudio: Cancelled.", file=sys.stderr)
        return 130
    finally:
        stop_requests.clear_state()
        # An interruption that leaves code compiled from a text, as that of dataclasses is while
        # modules are read, makes Python end itself by the signal in spite of the exit code, unless
        # such code has run since.
        exec("")


def _handle_stop_signals() -> dict[int, Any]:
    """Raise KeyboardInterrupt on stop signals from now on, and remember them.

    A command can also be stopped while its modules are imported. Signals that the process ignores
    stay ignored.

    Returns
    -------
    dict
        Previous handlers, by signal.
    """
    if threading.current_thread() is not threading.main_thread():
        return {}
    stop_requests.clear_state()
    default_handlers = (signal.SIG_DFL, signal.default_int_handler, stop_early)
    previous_handlers = {
        n: signal.getsignal(n) for n in _STOP_SIGNALS if signal.getsignal(n) in default_handlers
    }
    for number in previous_handlers:
        stop_requests.listen(number)
    return previous_handlers


def _set_handlers(handlers: dict[int, Any]) -> None:
    for number, handler in handlers.items():
        signal.signal(number, handler)


def _run(words: list[str], previous_handlers: dict[int, Any], *, owns_process: bool) -> int:
    """Run the command line, a worker, the graphics check or the window.

    Parameters
    ----------
    words : list of str
        Arguments of the command line.
    previous_handlers : dict
        Previous handlers of the signals that the window and the workers handle themselves.
    owns_process : bool
        Whether the process belongs to the program and ends with the exit code.

    Returns
    -------
    int
        Exit code.
    """
    if words[:1] == ["--worker"]:
        # Ctrl+C reaches every process of a terminal. The parent process ends the worker.
        _set_handlers(
            {number: signal.SIG_IGN for number in previous_handlers if number == signal.SIGINT}
        )
    from vomstudio.core.languages import use_user_language

    use_user_language()
    if words[:1] == ["--graphics"]:
        # The parent process reports the cancellation.
        _set_handlers(dict.fromkeys(previous_handlers, signal.SIG_DFL))
    if words[:1] == ["--worker"]:
        _set_handlers(
            {
                number: handler
                for number, handler in previous_handlers.items()
                if number != signal.SIGINT
            }
        )
        from vomstudio.studio.jobs.worker import main as run_worker

        return run_worker()
    if words[:1] == ["--graphics"]:
        from vomstudio.rendering.scene.graphics import main as run_graphics_check

        return run_graphics_check()
    from vomstudio.cli import opens_window

    if not opens_window(words):
        from vomstudio.cli import main as command_line
        from vomstudio.core.failures import log

        log.start("command")
        if owns_process:
            stop_requests.watch()
        return command_line(words)
    _set_handlers(previous_handlers)
    from vomstudio.core.failures import crashes, exception_hooks
    from vomstudio.core.failures.error_collector import ERRORS
    from vomstudio.ui.shell.window_start import run_window

    exception_hooks.install(crashes.WINDOW)
    try:
        code = run_window(words)
    except Exception as error:
        ERRORS.report(error, "outside the window's event loop")
        raise
    finally:
        exception_hooks.uninstall()
    if owns_process:
        from vomstudio.core.failures.quick_exit import exit_without_finalising

        exit_without_finalising(code)
    return code
