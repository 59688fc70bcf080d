"""Signals and what waits until all are told."""

from __future__ import annotations

import threading

import pytest

from vomstudio.core.signals import Signal, once_told, telling


def test_what_is_asked_for_many_times_is_done_once_after_all_are_told() -> None:
    outer, inner = Signal[str](), Signal[()]()
    done: list[str] = []

    def count() -> None:
        done.append("counted")

    def first(what: str) -> None:
        once_told(count)
        inner.emit()
        done.append(what)

    outer.connect(first)
    inner.connect(lambda: once_told(count))
    outer.connect(lambda what: done.append(what.upper()))
    outer.emit("told")
    assert done == ["told", "TOLD", "counted"]
    with telling():
        outer.emit("a")
        outer.emit("b")
    assert done[3:] == ["a", "A", "b", "B", "counted"]
    once_told(count)
    assert done[8:] == ["counted"]


def test_it_is_done_although_a_listener_fails_and_what_it_brings_about_is_too() -> None:
    signal, done = Signal[()](), list[str]()
    signal.connect(lambda: once_told(lambda: again.emit()))

    def fail() -> None:
        raise ValueError("no")

    signal.connect(fail)
    again = Signal[()]()
    again.connect(lambda: once_told(lambda: done.append("last")))
    with pytest.raises(ValueError, match="no"):
        signal.emit()
    assert done == ["last"]


def test_one_thread_does_not_wait_for_another() -> None:
    done: list[int] = []
    with telling():
        thread = threading.Thread(target=lambda: once_told(lambda: done.append(1)))
        thread.start()
        thread.join()
        assert done == [1]
