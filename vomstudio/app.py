"""The one place where objects are made and joined."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Sequence
from types import FrameType

_STOPPING = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]


def main(argv: Sequence[str] | None = None) -> int:
    """`vomstudio` opens the window, `vomstudio COMMAND ...` works without one."""
    words = list(sys.argv[1:] if argv is None else argv)
    taken = _hear_stop_signals()
    try:
        return _run(words, taken)
    except KeyboardInterrupt:
        # Before the command could say so in the form that was asked for, or after it.
        print("vomstudio: Cancelled.", file=sys.stderr)
        return 130
    finally:
        _leave(taken)


def _hear_stop_signals() -> list[int]:
    """From now on what asks the process to end raises KeyboardInterrupt, as Ctrl+C does: a command
    is asked to end while its modules are read, too. Which of these signals it is."""
    if threading.current_thread() is not threading.main_thread():
        return []
    taken = [n for n in _STOPPING if signal.getsignal(n) is signal.SIG_DFL]
    for number in taken:
        signal.signal(number, _stop)
    return taken


def _leave(taken: list[int]) -> None:
    for number in taken:
        signal.signal(number, signal.SIG_DFL)


def _stop(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt


def _run(words: list[str], taken: list[int]) -> int:
    """taken : signals that the window and the workers hear in ways of their own"""
    from vomstudio.languages import use_users_language

    use_users_language()
    if words[:1] in (["--worker"], ["--graphics"]):
        _leave(taken)
    if words[:1] == ["--worker"]:
        from vomstudio.jobs.worker import main as work

        return work()
    if words[:1] == ["--graphics"]:
        from vomstudio.rendering.scene.graphics import main as say

        return say()
    from vomstudio.cli import is_for_window

    if not is_for_window(words):
        from vomstudio.cli import main as command_line
        from vomstudio.failures import log

        log.start("command")
        return command_line(words)
    _leave(taken)
    from vomstudio.failures import crashes, exception_hooks
    from vomstudio.failures.error_collector import ERRORS
    from vomstudio.ui.shell.window_start import run_window

    exception_hooks.install(crashes.WINDOW)
    try:
        return run_window(words)
    except Exception as error:
        ERRORS.report(error, "outside the window's event loop")
        raise
    finally:
        exception_hooks.uninstall()
