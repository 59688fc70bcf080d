"""Background work: answers arrive in the owner's thread, stale ones never, errors as errors."""

from __future__ import annotations

import random
import threading
import time
from collections.abc import Callable, Iterator

import pytest

from tests.studio.loop import Loop
from vomstudio.core.errors import InputError
from vomstudio.studio.background import Background, Request


@pytest.fixture
def loop() -> Loop:
    return Loop()


@pytest.fixture
def background(loop: Loop) -> Iterator[Background]:
    created = Background(loop.post, "tested")
    yield created
    created.stop(wait_s=20.0)


class Gate:
    """A function that runs until the gate is opened; notes when it begins."""

    def __init__(self) -> None:
        self.begun, self._open = threading.Event(), threading.Event()

    def open(self) -> None:
        self._open.set()

    def __call__(self) -> str:
        self.begun.set()
        assert self._open.wait(20.0)
        return "through"


def until(loop: Loop, done: Callable[[], object]) -> None:
    assert loop.run_until(lambda: bool(done()), 20.0)


def let_threads_end(loop: Loop) -> None:
    """Make all calls that still come."""
    until(loop, lambda: not any(t.name == "tested" for t in threading.enumerate()))
    loop.run_until(lambda: False, 0.05)


def test_a_result_arrives_in_the_owners_thread(loop: Loop, background: Background) -> None:
    results: list[tuple[str, threading.Thread, threading.Thread]] = []
    background.run(
        threading.current_thread,
        lambda worker: results.append(("result", worker, threading.current_thread())),
    )
    assert background.is_busy
    until(loop, lambda: results)
    assert results[0][1].name == "tested"
    assert results[0][2] is threading.current_thread()
    assert not background.is_busy


def test_expected_error_is_passed_to_the_error_callback(loop: Loop, background: Background) -> None:
    error, arrived, results = InputError("is no model"), [], []

    def fail() -> None:
        raise error

    background.run(fail, results.append, arrived.append, key="k")
    until(loop, lambda: arrived)
    assert arrived == [error]
    assert results == []
    assert not background.is_waiting("k")


def test_unexpected_error_is_logged_and_passed_to_the_error_callback(
    loop: Loop, background: Background, monkeypatch: pytest.MonkeyPatch
) -> None:
    reported, arrived = [], []
    monkeypatch.setattr(threading, "excepthook", lambda args: reported.append(args.exc_type))
    background.run(lambda: {}["x"], print, arrived.append)
    until(loop, lambda: arrived)
    assert [error.code for error in arrived] == ["program.internal-error"]
    assert reported == [KeyError]
    background.run(lambda: {}["x"], print, arrived.append, expected=(KeyError,))
    until(loop, lambda: len(arrived) == 2)
    assert arrived[1].code == "file.unreadable"
    assert reported == [KeyError]
    # Without anybody to take it, it is reported, and the next function runs all the same.
    background.run(lambda: 1 / 0, print, key="k")
    until(loop, lambda: not background.is_waiting("k"))
    assert reported == [KeyError, ZeroDivisionError]


def test_newer_request_replaces_older_ones_with_the_same_key(
    loop: Loop, background: Background
) -> None:
    gate, begun, results = Gate(), [], []
    background.run(gate, results.append, key="k")
    assert gate.begun.wait(20.0)
    for number in range(5):
        background.run(lambda n=number: (begun.append(n), n)[1], results.append, key="k")
    background.run(lambda: "other", results.append, key="other")
    until(loop, lambda: results)
    assert results == ["other"]
    assert background.is_waiting("k")
    gate.open()
    let_threads_end(loop)
    assert begun == [4]
    assert results == ["other", 4]


@pytest.mark.parametrize("threads", [1, 4])
def test_stale_answers_never_arrive(loop: Loop, threads: int) -> None:
    """Whatever the order in which threads take turns: only what was requested last may arrive."""
    background = Background(loop.post, "tested", threads=threads)
    rng = random.Random(3)
    newest: dict[int, int] = {}
    arrived: dict[int, int] = {}

    def take(key: int, number: int) -> None:
        assert newest[key] == number
        arrived[key] = number

    for number in range(300):
        key, pause = rng.randrange(3), rng.choice([0.0, 0.0, 0.001])
        newest[key] = number
        background.run(
            lambda n=number, s=pause: (time.sleep(s), n)[1],
            lambda n, key=key: take(key, n),
            key=key,
        )
        if rng.random() < 0.1:
            background.cancel(key)
            newest[key] = -1
        if rng.random() < 0.3:
            loop.run_until(lambda: False, 0.002)
    let_threads_end(loop)
    assert {key: n for key, n in newest.items() if n >= 0}.items() <= arrived.items()
    assert not background.is_busy


@pytest.mark.parametrize("end", [Background.stop, Background.cancel_all])
def test_nothing_arrives_after_the_owner_has_stopped(
    loop: Loop, background: Background, end: Callable[[Background], None]
) -> None:
    gate, results = Gate(), []
    background.run(gate, results.append, results.append)
    background.run(lambda: "done", results.append)
    assert gate.begun.wait(20.0)
    # The result of the second one may be on its way already.
    time.sleep(0.05)
    end(background)
    gate.open()
    let_threads_end(loop)
    assert results == []
    background.run(lambda: "later", results.append)
    let_threads_end(loop)
    assert results == ([] if end is Background.stop else ["later"])


def test_stop_waits_only_if_requested(background: Background) -> None:
    gate = Gate()
    background.run(gate, print)
    assert gate.begun.wait(20.0)
    begun_s = time.monotonic()
    background.stop()
    assert time.monotonic() - begun_s < 1.0
    background.stop(wait_s=0.2)
    assert time.monotonic() - begun_s < 5.0
    assert any(thread.name == "tested" for thread in threading.enumerate())
    threading.Thread(target=lambda: (time.sleep(0.1), gate.open())).start()
    background.stop(wait_s=20.0)
    assert not any(thread.name == "tested" for thread in threading.enumerate())


def test_requests_without_a_key_all_arrive_within_the_thread_limit(
    loop: Loop,
) -> None:
    background = Background(loop.post, "tested", threads=3)
    counts, results = [], []

    def count(number: int) -> int:
        counts.append(sum(thread.name == "tested" for thread in threading.enumerate()))
        time.sleep(0.001)
        return number

    for number in range(40):
        background.run(lambda n=number: count(n), results.append)
    let_threads_end(loop)
    assert sorted(results) == list(range(40))
    assert max(counts) <= 3


def test_single_thread_returns_results_in_order_with_urgent_ones_first(
    loop: Loop,
) -> None:
    background = Background(loop.post, "tested", threads=1)
    gate, results = Gate(), []
    background.run(gate, results.append)
    assert gate.begun.wait(20.0)
    for number in range(4):
        background.run(lambda n=number: n, results.append)
    background.run_request(lambda _: "urgent", results.append, is_first=True)
    gate.open()
    let_threads_end(loop)
    assert results == ["through", "urgent", 0, 1, 2, 3]


def test_partial_results_arrive_until_the_request_is_stale(
    loop: Loop, background: Background
) -> None:
    results, ended = [], threading.Event()

    def count(request: Request[int]) -> int:
        try:
            for number in range(100_000):
                request.emit(number)
                time.sleep(0.001)
        finally:
            ended.set()
        return -1

    background.run_request(count, results.append, key="k")
    until(loop, lambda: len(results) > 3)
    background.cancel("k")
    seen = len(results)
    assert ended.wait(20.0)
    let_threads_end(loop)
    assert len(results) == seen
    assert results == list(range(seen))


def test_guarded_callback_is_ignored_after_stop(background: Background) -> None:
    results: list[int] = []
    guarded = background.guard(results.append)
    guarded(1)
    background.stop()
    guarded(2)
    assert results == [1]
