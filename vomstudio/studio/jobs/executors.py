"""Executors of the work on many photos or tiles: threads of this process, or a Dask cluster."""

from __future__ import annotations

import itertools
import logging
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

from vomstudio.core.errors import UsageError, WorkerError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Executor, InlineExecutor, Progress
from vomstudio.core.threads import CHECK_PERIOD_S, PROCESSORS, map_unordered
from vomstudio.photogrammetry.base.memory import workers_at_once

Item = TypeVar("Item")
Result = TypeVar("Result")

# How often a part of the work may take a worker of a cluster down with it.
_TRIES = 3
# How long a cluster may be without any worker.
_RESTART_S = 10.0


class Threads:
    """An Executor of `count` threads. What it is given is native code that frees the GIL; threads
    share the photos that they read, and one process is what a supervisor can kill."""

    def __init__(self, count: int) -> None:
        self._count = count

    def map(
        self,
        work: Callable[[Item], Result],
        items: Iterable[Item],
        progress: Progress,
        needed: int = 0,
    ) -> Iterator[tuple[int, Result]]:
        """See `Executor`."""
        done = 0
        progress.step(0)
        threads = workers_at_once(needed, self._count)

        def check() -> None:
            progress.step(done)

        results = map_unordered(work, items, threads, check=check, wait=False)
        for done, result in enumerate(results, 1):  # noqa: B007 - read by `check`
            yield result
            check()

    def close(self) -> None:
        """Nothing is held."""


class Cluster:
    """An Executor on the workers of a Dask scheduler, which must have this version installed."""

    def __init__(self, address: str) -> None:
        """Raises UsageError where Dask is not installed, or the scheduler does not answer."""
        try:
            import distributed
        except ImportError as error:
            raise UsageError(
                Finding("cluster.no-dask"),
                field="--scheduler",
            ) from error
        for name in ("distributed", "distributed.client", "distributed.core", "tornado"):
            # What it says of lost connections, in tracebacks, is said here in sentences.
            logging.getLogger(name).setLevel(logging.CRITICAL)
        try:
            connect: Any = distributed.Client
            self._client: Any = connect(address, timeout=10, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:
            raise UsageError(
                Finding("cluster.no-scheduler", address=address),
                field="--scheduler",
            ) from error
        if not self._wait_for_workers():
            self.close()
            raise UsageError(
                Finding("cluster.no-workers", address=address),
                field="--scheduler",
            )

    @property
    def workers(self) -> int:
        """Threads of all workers together."""
        return sum(self._client.nthreads().values())

    def map(
        self,
        work: Callable[[Item], Result],
        items: Iterable[Item],
        progress: Progress,
        needed: int = 0,
    ) -> Iterator[tuple[int, Result]]:
        """See `Executor`. Raises WorkerError where the cluster loses its workers or the same
        part again and again."""
        import distributed

        lost = (distributed.KilledWorker, distributed.CancelledError)
        done = 0
        progress.step(0)
        running: dict[Any, tuple[int, Item, int]] = {}
        numbered = enumerate(items)
        heard = threading.Event()

        def submit(number: int, item: Item, tries: int = 1) -> None:
            # A large item travels as data of its own, not inside the task's description.
            sent = self._client.scatter(item, direct=False, hash=False)
            future = self._client.submit(work, sent, pure=False)
            running[future] = (number, item, tries)
            future.add_done_callback(lambda _: heard.set())

        try:
            for number, item in itertools.islice(numbered, self.workers + 1):
                submit(number, item)
            while running:
                # Not distributed.wait: it raises for all where one was lost with its worker.
                heard.wait(CHECK_PERIOD_S)
                heard.clear()
                progress.step(done)
                finished = [future for future in running if future.done()]
                if not finished:
                    self._require_workers()
                for future in finished:
                    number, item, tries = running.pop(future)
                    try:
                        result = future.result()
                    except lost as error:
                        # What a dead worker held is gone with it, and is sent again.
                        self._require_workers()
                        if tries == _TRIES:
                            raise WorkerError(
                                Finding(
                                    "cluster.part-lost", tries=tries, error=type(error).__name__
                                )
                            ) from error
                        submit(number, item, tries + 1)
                        continue
                    for next_number, next_item in itertools.islice(numbered, 1):
                        submit(next_number, next_item)
                    done += 1
                    yield number, result
                    progress.step(done)
        finally:
            self._client.cancel(list(running))

    def _require_workers(self) -> None:
        if not self._wait_for_workers():
            raise WorkerError(Finding("cluster.workers-lost"))

    def _wait_for_workers(self) -> bool:
        """A worker may just be starting, or starting again in place of one that died."""
        end = time.monotonic() + _RESTART_S
        while not self._threads():
            if self._client.status != "running" or time.monotonic() > end:
                return False
            time.sleep(CHECK_PERIOD_S)
        return True

    def _threads(self) -> int:
        try:
            return self.workers
        except OSError:
            # The scheduler itself is gone.
            return 0

    def close(self) -> None:
        """Leave the scheduler."""
        self._client.close()


def make_executor(threads: int | None = None, scheduler: str | None = None) -> Executor:
    """threads: None for as many as there are processors. Raises UsageError."""
    if scheduler is not None:
        return Cluster(scheduler)
    count = threads or PROCESSORS
    return InlineExecutor() if count == 1 else Threads(count)
