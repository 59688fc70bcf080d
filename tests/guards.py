"""Quiet is a test: a thread, timer, window or VTK object that outlives its test fails it, and so
does a warning in the log that nobody expected.

The hooks are taken into conftest.py. A test whose subject is a warning or an error of the program
says so with the marker `expects_log`; what Qt warns of is guarded by pytest-qt itself
(`qt_log_level_fail` in pyproject.toml).
"""

from __future__ import annotations

import contextlib
import faulthandler
import gc
import logging
import sys
import threading
import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from _pytest.faulthandler import fault_handler_stderr_fd_key

_WINDOWS = tuple(str(Path(__file__).parent / name) for name in ("journeys", "rendering", "ui"))
"""Tests of these folders open windows or make pictures: what they leave is looked for in memory."""
_PATIENCE_S = 20.0
_MEMORY_PATIENCE_S = 5.0
"""A thread that was told to end may be in the middle of something, and one that arranges a large
model for picking gives way to everybody else."""
MODULES_PER_COLLECTION = 20

_THREADS = (
    # Dask has one of each for the process, made with its first client.
    "Dask-Offload",
    "Dask-Callback-Thread",
    # A client of Dask's that finds no scheduler raises before anybody could close it.
    "IO loop",
)
"""How the names of threads begin which a library starts and never ends."""
_THREADS_OF_A_WINDOW = (
    "worker output",
    "worker errors",
    "net",
    "photos",
    "in photos",
    "viewport_",
    "clouds_",
)
"""Threads that a window starts when it first needs them and ends when it is closed."""


class _Records(logging.Handler):
    """Warnings and worse of the program itself."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.texts: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        # Not the record: it holds the error, and the error all that its functions had in hand.
        self.texts.append(f"{record.levelname} {record.name}: {record.getMessage()}")


@dataclass
class _Before:
    """What was there before a test."""

    threads: set[threading.Thread]
    records: _Records
    in_windows: bool
    failed: bool = False


@dataclass
class _Memory:
    """State of the memory checks. windows : addresses of the windows that existed before.
    shared : a window is in use by several tests; memory is checked when it is closed"""

    module: str = ""
    modules: int = 0
    windows: set[int] = field(default_factory=set)
    shared: bool = False

    def hide_existing(self) -> None:
        """Hide all existing objects from the garbage collector: it then goes through what comes
        later within milliseconds, and finds only that."""
        gc.freeze()
        self.windows = set(_windows())


_BEFORE = pytest.StashKey[_Before]()
_memory = _Memory()


def pytest_collection_finish() -> None:
    """Hide the thousands of collected tests from the garbage collector."""
    gc.collect()
    gc.freeze()


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> Iterator[None]:
    before = _Before(set(threading.enumerate()), _Records(), str(item.path).startswith(_WINDOWS))
    item.stash[_BEFORE] = before
    logging.getLogger("vomstudio").addHandler(before.records)
    if before.in_windows and not _memory.shared:
        _collect_now_and_then(str(item.path))
        _memory.hide_existing()
    try:
        return (yield)
    except BaseException:
        before.failed = True
        raise


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    try:
        return (yield)
    except BaseException:
        # What a failure holds, and has not come to, is no leak.
        item.stash[_BEFORE].failed = True
        raise


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_teardown(item: pytest.Item) -> Iterator[None]:
    before = item.stash[_BEFORE]
    if _memory.shared and hasattr(item, "funcargs"):
        # The shared window may be closed in this teardown; pytest would still hold it.
        item.funcargs.clear()
    try:
        return (yield)
    finally:
        logging.getLogger("vomstudio").removeHandler(before.records)
        _watch_for_crashes(item.config)
        if not before.failed and sys.exc_info()[0] is None:
            left = [*_said(item, before), *_threads(before)]
            if before.in_windows and not _memory.shared:
                left += _in_memory(item)
            if left:
                pytest.fail("the test leaves behind:\n  " + "\n  ".join(left), pytrace=False)


def _watch_for_crashes(config: pytest.Config) -> None:
    """The program has its own place for the traces of native crashes, and leaves none behind: those
    of later tests are to be seen again."""
    out = config.stash.get(fault_handler_stderr_fd_key, None)
    if out is not None and not faulthandler.is_enabled():
        faulthandler.enable(out)


def _said(item: pytest.Item, before: _Before) -> list[str]:
    if item.get_closest_marker("expects_log"):
        return []
    return [f"an unexpected log record: {text}" for text in before.records.texts]


# --- threads ---------------------------------------------------------------------------------
def _threads(before: _Before) -> list[str]:
    end = time.monotonic() + _PATIENCE_S
    while (left := _new_threads(before)) and time.monotonic() < end:
        time.sleep(0.01)
        _let_qt_work()
    return [f"a running thread: {thread.name}" for thread in left]


def _new_threads(before: _Before) -> list[threading.Thread]:
    return [
        thread
        for thread in threading.enumerate()
        if thread not in before.threads
        and not thread.name.startswith(_THREADS)
        and not (_memory.shared and thread.name.startswith(_THREADS_OF_A_WINDOW))
        # Stands for a thread of Qt or of a native library in which Python was called once.
        and not isinstance(thread, threading._DummyThread)
    ]


# --- memory ----------------------------------------------------------------------------------
def has_failed(item: pytest.Item) -> bool:
    """Whether the setup or the call of a test has raised."""
    return item.stash[_BEFORE].failed


def begin_sharing() -> None:
    """Start to share a window between tests: memory is no longer checked after each of them."""
    assert not _memory.shared, "a window is shared already"
    _memory.shared = True


def end_sharing(*, check: bool = True) -> list[str]:
    """Return what the tests that shared a window leave in memory after it was closed.

    Parameters
    ----------
    check : False after a failure, whose traceback holds objects that did not leak.
    """
    _memory.shared = False
    left = _wait_for_memory() if check else []
    _memory.hide_existing()
    return left


def _collect_now_and_then(path: str) -> None:
    """Collect the garbage that was hidden, at the beginning of every few modules: going through all
    objects, most of which belong to pytest, takes a second or more."""
    if _memory.module == path:
        return
    _memory.module = path
    _memory.modules += 1
    if _memory.modules % MODULES_PER_COLLECTION == 0:
        gc.unfreeze()
        with warnings.catch_warnings():
            # What earlier tests have left open is not the fault of this one.
            warnings.simplefilter("ignore", ResourceWarning)
            gc.collect()


def _in_memory(item: pytest.Item) -> list[str]:
    if hasattr(item, "funcargs"):
        # Kept by pytest until after this, and with them all that the fixtures have made.
        item.funcargs.clear()
    return _wait_for_memory()


def _wait_for_memory() -> list[str]:
    # What a thread has just handed over is let go when Qt comes to it.
    end = time.monotonic() + _MEMORY_PATIENCE_S
    while (left := _what_is_left()) and time.monotonic() < end:
        time.sleep(0.05)
    return left


def _what_is_left() -> list[str]:
    _let_qt_work()
    gc.collect()
    _let_qt_work()
    found = gc.get_objects()
    left = [f"a window: {words}" for ptr, words in _windows().items() if ptr not in _memory.windows]
    left += _running_timers(found)
    left += _vtk_objects(found)
    return left


def _qt() -> Any:
    """QApplication, where there is one."""
    widgets = sys.modules.get("PySide6.QtWidgets")
    if widgets is None or widgets.QApplication.instance() is None:
        return None
    return widgets.QApplication


def _let_qt_work() -> None:
    if (application := _qt()) is not None:
        from PySide6.QtCore import QCoreApplication, QEvent

        with contextlib.suppress(RuntimeError):
            application.processEvents()
            # Outside an event loop nobody does what deleteLater has asked for.
            QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)


def _windows() -> dict[int, str]:
    """Address and name of each window that belongs to no other one."""
    if (application := _qt()) is None:
        return {}
    import shiboken6

    return {
        shiboken6.getCppPointer(widget)[0]: f"{type(widget).__name__} {widget.windowTitle()}"
        for widget in application.topLevelWidgets()
        if widget.parent() is None
    }


def _running_timers(found: list[Any]) -> list[str]:
    if _qt() is None:
        return []
    import shiboken6
    from PySide6.QtCore import QTimer

    timers = [each for each in found if type(each) is QTimer and shiboken6.isValid(each)]
    return [
        f"a running timer of {each.interval()} ms of {type(each.parent()).__name__}"
        for each in timers
        if each.isActive()
    ]


def _vtk_objects(found: list[Any]) -> list[str]:
    core = sys.modules.get("vtkmodules.vtkCommonCore")
    if core is None:
        return []
    # By its type: asking a weak proxy for its class asks what may be gone.
    names = [type(each).__name__ for each in found if issubclass(type(each), core.vtkObjectBase)]
    return [f"{names.count(name)} {name}" for name in sorted(set(names))]
