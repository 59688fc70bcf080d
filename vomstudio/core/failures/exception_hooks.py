"""Hooks that pass every uncaught Python exception to the error collector."""

from __future__ import annotations

import contextlib
import logging
import platform
import sys
import threading
import traceback
from types import TracebackType
from typing import TYPE_CHECKING, Any

from vomstudio.core.failures import crashes, log
from vomstudio.core.failures.error_collector import ERRORS
from vomstudio.core.version import __version__

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

_log = logging.getLogger(__name__)

_previous_hooks: tuple[Any, Any, Any] | None = None


def install(role: str) -> None:
    """Log and display uncaught exceptions, without exiting, until `uninstall` is called.

    Parameters
    ----------
    role : str
        `crashes.WINDOW` or `crashes.WORKER`.
    """
    global _previous_hooks
    if _previous_hooks is not None:
        return
    log.start(role)
    _log.info("begins: VOM Studio %s, Python %s", __version__, platform.python_version())
    crashes.begin(role)
    _previous_hooks = sys.excepthook, threading.excepthook, sys.unraisablehook
    sys.excepthook, threading.excepthook = _handle_uncaught, _handle_uncaught_in_thread
    sys.unraisablehook = _handle_unraisable


def uninstall() -> None:
    """Restore the previous hooks, reset the collector, and close the log and crash trace."""
    global _previous_hooks
    if _previous_hooks is None:
        return
    sys.excepthook, threading.excepthook, sys.unraisablehook = _previous_hooks
    _previous_hooks = None
    ERRORS.listen(None)
    ERRORS.reset()
    crashes.end()
    log.stop()


def report_as_uncaught(error: BaseException) -> None:
    """Report an exception as uncaught, although the current thread continues."""
    threading.excepthook(
        threading.ExceptHookArgs(
            (type(error), error, error.__traceback__, threading.current_thread())
        )
    )


def _handle_uncaught(
    kind: type[BaseException], error: BaseException, trace: TracebackType | None
) -> None:
    if isinstance(error, KeyboardInterrupt):
        sys.__excepthook__(kind, error, trace)
        return
    if ERRORS.report(error):
        _print(error)
    _release_frames(error)


def _handle_uncaught_in_thread(args: threading.ExceptHookArgs) -> None:
    error = args.exc_value
    if error is None or isinstance(error, SystemExit):
        return
    name = "a thread" if args.thread is None else f"the thread {args.thread.name}"
    if ERRORS.report(error, f"in {name}"):
        _print(error)
    _release_frames(error)


def _handle_unraisable(args: UnraisableHookArgs) -> None:
    error = args.exc_value
    if error is None or sys.is_finalizing():
        sys.__unraisablehook__(args)
        return
    # The object is being finalised, so its own repr may fail.
    source = getattr(args.object, "__qualname__", type(args.object).__qualname__)
    if ERRORS.report(error, f"{args.err_msg or 'ignored'} in {source}"):
        _print(error)
    _release_frames(error)


def _print(error: BaseException) -> None:
    """Print the traceback of an error to stderr, if the process has one."""
    if sys.stderr is not None:
        with contextlib.suppress(Exception):
            traceback.print_exception(error)


def _release_frames(error: BaseException) -> None:
    """Release the last error, which Python stores with the local variables of its frames.

    Otherwise a painter would stay open, so that every later paint would fail, and the models of a
    closed project would stay in memory.
    """
    for name in ("last_exc", "last_type", "last_value", "last_traceback"):
        sys.__dict__.pop(name, None)
    with contextlib.suppress(Exception):
        cause: BaseException | None = error
        while cause is not None:
            traceback.clear_frames(cause.__traceback__)
            cause = cause.__cause__ or cause.__context__
