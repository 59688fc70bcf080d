"""Threads and thread pools; this is the only module that creates them.

A pool exists only as long as the call that needs it. On Linux, a thread inherits the priority of
the thread that starts it and cannot raise it again, so a single pool would run the work of the
viewport at the priority of a background task, or vice versa. Starting four threads takes 0.4 ms.

`concurrent.futures` is imported when a pool is needed for the first time because the import takes
15 ms.
"""

from __future__ import annotations

import contextlib
import os
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import islice
from typing import TYPE_CHECKING, TypeVar, TypeVarTuple

if TYPE_CHECKING:
    from concurrent.futures import Future, ThreadPoolExecutor

Item = TypeVar("Item")
Result = TypeVar("Result")
Arguments = TypeVarTuple("Arguments")

PROCESSOR_COUNT = os.cpu_count() or 1
CHECK_PERIOD_S = 0.25


def start_thread(
    function: Callable[[*Arguments], object], *arguments: *Arguments, name: str, daemon: bool = True
) -> threading.Thread:
    """Start a thread that calls a function; its errors go to `threading.excepthook`.

    Parameters
    ----------
    function : callable
        Called in the thread with `arguments`.
    *arguments : object
    name : str
        Name of the thread for error reports.
    daemon : bool
        Whether the process may end before the thread does.
    """
    thread = threading.Thread(target=function, args=arguments, name=name, daemon=daemon)
    thread.start()
    return thread


def start_timer(
    delay_s: float, function: Callable[[*Arguments], object], *arguments: *Arguments
) -> threading.Timer:
    """Start a timer that calls a function in a thread after a delay unless it is cancelled."""
    timer = threading.Timer(delay_s, function, arguments)
    timer.daemon = True
    timer.start()
    return timer


def run_in_thread(
    function: Callable[[*Arguments], Result], *arguments: *Arguments, name: str
) -> Future[Result]:
    """Start a thread that calls a function and return the future of its result."""
    from concurrent.futures import Future

    future: Future[Result] = Future()

    def run() -> None:
        try:
            result = function(*arguments)
        except BaseException as error:  # noqa: BLE001 - raised where the result is requested
            future.set_exception(error)
        else:
            future.set_result(result)

    start_thread(run, name=name)
    return future


def thread_pool(threads: int, name: str = "pool", *, niceness: int = 0) -> ThreadPoolExecutor:
    """Create a thread pool as a context manager that waits for all work at its end."""
    from concurrent.futures import ThreadPoolExecutor

    start = partial(lower_priority, niceness) if niceness else None
    return ThreadPoolExecutor(max(1, threads), thread_name_prefix=name, initializer=start)


def map_parallel(
    function: Callable[[Item], Result], items: Iterable[Item], threads: int = PROCESSOR_COUNT
) -> Iterator[Result]:
    """Yield the results of a function for all items, in the order of the items.

    The calls run in parallel only if the function releases the GIL. If a call raises an error or
    the caller stops iterating, pending calls are cancelled and running calls are completed first.
    """
    items = list(items)
    threads = min(threads, len(items))
    if threads < 2:
        yield from map(function, items)
        return
    with thread_pool(threads) as pool:
        yield from pool.map(function, items)


def map_unordered(
    function: Callable[[Item], Result],
    items: Iterable[Item],
    threads: int,
    *,
    check: Callable[[], object] = lambda: None,
    wait: bool = True,
) -> Iterator[tuple[int, Result]]:
    """Yield (item number, result) as results become available, from at most `threads` threads.

    Parameters
    ----------
    function : callable
        Function that is called with each item in a thread.
    items : iterable
        Items, consumed as threads become available.
    threads : int
        Maximum number of threads.
    check : callable
        Function that is called every `CHECK_PERIOD_S` while waiting for results; may raise.
    wait : bool
        Whether to wait for running work when the iteration ends early.
    """
    from concurrent.futures import FIRST_COMPLETED
    from concurrent.futures import wait as wait_for

    numbered_items = enumerate(items)
    pool = thread_pool(threads)
    try:
        running_tasks = {
            pool.submit(function, item): n for n, item in islice(numbered_items, threads)
        }
        while running_tasks:
            finished_tasks, _ = wait_for(running_tasks, CHECK_PERIOD_S, FIRST_COMPLETED)
            check()
            for future in finished_tasks:
                index = running_tasks.pop(future)
                result = future.result()
                for n, item in islice(numbered_items, 1):
                    running_tasks[pool.submit(function, item)] = n
                yield index, result
    finally:
        pool.shutdown(wait=wait, cancel_futures=True)


def lower_priority(niceness: int = 5) -> None:
    """Lower the priority of this thread and of the threads it starts; works only on Linux.

    Parameters
    ----------
    niceness : int
        Niceness of the thread; with 19 it runs only while the processor is idle.
    """
    if sys.platform == "linux":
        with contextlib.suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), niceness)
