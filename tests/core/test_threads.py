"""Threads and pools: errors arrive, nothing goes on behind the caller, and no more runs at once."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time

import pytest

from vomstudio.core.threads import (
    lower_priority,
    map_parallel,
    map_unordered,
    run_in_thread,
    start_thread,
    start_timer,
    thread_pool,
)


class Work:
    """Counts how many calls run at once, and which have run."""

    def __init__(self, seconds: float = 0.01) -> None:
        self.done: list[int] = []
        self.most = 0
        self._seconds, self._now, self._lock = seconds, 0, threading.Lock()

    def __call__(self, item: int) -> int:
        with self._lock:
            self._now += 1
            self.most = max(self.most, self._now)
        time.sleep(self._seconds)
        with self._lock:
            self._now -= 1
            self.done.append(item)
        if item < 0:
            raise ValueError(item)
        return item * item


@pytest.mark.parametrize("threads", [1, 2, 4])
@pytest.mark.parametrize("count", [0, 1, 2, 25])
def test_results_come_in_the_order_of_the_items(threads: int, count: int) -> None:
    work = Work(0.001)
    assert list(map_parallel(work, range(count), threads)) == [n * n for n in range(count)]
    assert sorted(work.done) == list(range(count))
    assert work.most <= threads


@pytest.mark.parametrize("threads", [1, 3])
def test_unordered_results_have_index_of_their_item(threads: int) -> None:
    work, taken = Work(), []

    def items():
        for item in range(20):
            taken.append(item)
            yield item + 5

    results = {}
    for number, result in map_unordered(work, items(), threads):
        results[number] = result
        assert len(taken) <= len(results) + 2 * threads
    assert results == {n: (n + 5) ** 2 for n in range(20)}
    assert work.most <= threads


@pytest.mark.parametrize("parallel", [map_parallel, map_unordered])
def test_error_is_raised_and_no_more_items_run(parallel) -> None:
    work = Work()
    with pytest.raises(ValueError, match="-1"):
        list(parallel(work, [1, -1, *range(2, 50)], 2))
    done = len(work.done)
    assert done < 50
    time.sleep(0.05)
    assert len(work.done) == done


@pytest.mark.parametrize("parallel", [map_parallel, map_unordered])
def test_nothing_runs_once_the_caller_has_stopped(parallel) -> None:
    work = Work()

    def take_one() -> None:
        for _ in parallel(work, range(50), 2):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        take_one()
    done = len(work.done)
    assert done < 50
    time.sleep(0.05)
    assert len(work.done) == done


def test_check_function_can_interrupt_waiting() -> None:
    begun, end = time.monotonic(), threading.Event()

    def check() -> None:
        raise InterruptedError

    with pytest.raises(InterruptedError):
        list(map_unordered(lambda _: end.wait(20.0), [1], 1, check=check, wait=False))
    assert time.monotonic() - begun < 5.0
    end.set()


def test_a_future_has_the_result_or_the_error() -> None:
    assert run_in_thread(divmod, 7, 2, name="quotient").result(5.0) == (3, 1)
    failed = run_in_thread(divmod, 7, 0, name="quotient")
    with pytest.raises(ZeroDivisionError):
        failed.result(5.0)
    with pytest.raises(SystemExit):
        run_in_thread(sys.exit, 3, name="end").result(5.0)


def test_thread_has_name_and_is_daemon_by_default() -> None:
    names: list[tuple[str, bool]] = []

    def note() -> None:
        thread = threading.current_thread()
        names.append((thread.name, thread.daemon))

    start_thread(note, name="notes").join(5.0)
    start_thread(note, name="kept", daemon=False).join(5.0)
    assert names == [("notes", True), ("kept", False)]


def test_a_timer_calls_once_unless_it_is_cancelled() -> None:
    calls: list[str] = []
    kept, dropped = (start_timer(0.05, calls.append, name) for name in ("kept", "dropped"))
    dropped.cancel()
    kept.join(5.0)
    dropped.join(5.0)
    assert calls == ["kept"]


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has priorities of threads")
def test_lowered_priority_applies_only_to_thread_and_its_children() -> None:
    def priority() -> int:
        return os.getpriority(os.PRIO_PROCESS, threading.get_native_id())

    def lowered() -> tuple[int, list[int]]:
        lower_priority(7)
        return priority(), list(map_parallel(lambda _: priority(), range(2), 2))

    before = priority()
    assert run_in_thread(lowered, name="low").result(5.0) == (7, [7, 7])
    with thread_pool(1, niceness=9) as pool:
        assert pool.submit(priority).result(5.0) == 9
    assert priority() == before


def test_threads_module_does_not_import_concurrent_futures() -> None:
    code = "import sys, vomstudio.core.threads; print('concurrent.futures' in sys.modules)"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == "False"
