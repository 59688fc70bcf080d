"""Signals and what waits until all are told."""

from __future__ import annotations

import threading

import pytest

from vomstudio.core.signals import Signal, call_after_notifications, group_notifications


def test_repeated_deferred_call_runs_once_after_all_notifications() -> None:
    outer, inner = Signal[str](), Signal[()]()
    done: list[str] = []

    def count() -> None:
        done.append("counted")

    def first(what: str) -> None:
        call_after_notifications(count)
        inner.emit()
        done.append(what)

    outer.connect(first)
    inner.connect(lambda: call_after_notifications(count))
    outer.connect(lambda what: done.append(what.upper()))
    outer.emit("told")
    assert done == ["told", "TOLD", "counted"]
    with group_notifications():
        outer.emit("a")
        outer.emit("b")
    assert done[3:] == ["a", "A", "b", "B", "counted"]
    call_after_notifications(count)
    assert done[8:] == ["counted"]


def test_deferred_calls_run_even_if_a_listener_raises() -> None:
    signal, done = Signal[()](), list[str]()
    signal.connect(lambda: call_after_notifications(lambda: again.emit()))

    def fail() -> None:
        raise ValueError("no")

    signal.connect(fail)
    again = Signal[()]()
    again.connect(lambda: call_after_notifications(lambda: done.append("last")))
    with pytest.raises(ValueError, match="no"):
        signal.emit()
    assert done == ["last"]


def test_notification_groups_do_not_affect_other_threads() -> None:
    done: list[int] = []
    with group_notifications():
        thread = threading.Thread(target=lambda: call_after_notifications(lambda: done.append(1)))
        thread.start()
        thread.join()
        assert done == [1]
