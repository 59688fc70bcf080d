"""Executors for work on many photos or tiles, in threads or on a Dask cluster."""

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
from vomstudio.core.threads import CHECK_PERIOD_S, PROCESSOR_COUNT, map_unordered
from vomstudio.photogrammetry.base.memory import worker_count

Item = TypeVar("Item")
Result = TypeVar("Result")

# Number of times that an item may crash its worker before the job fails.
MAX_ATTEMPTS = 3
# Maximum time during which the cluster may have no workers.
MAX_RESTART_TIME_S = 10.0


class Threads:
    """Executor that processes the items in threads of this process.

    The work is native code that releases the GIL. Threads share the photos that they read, and a
    supervisor can stop them by killing their process.
    """

    def __init__(self, count: int) -> None:
        self._count = count

    def map(
        self,
        work: Callable[[Item], Result],
        items: Iterable[Item],
        progress: Progress,
        needed_count: int = 0,
    ) -> Iterator[tuple[int, Result]]:
        """Yield results as they become available; see `Executor.map`."""
        done_count = 0
        progress.step(0)
        threads = worker_count(needed_count, self._count)

        def check() -> None:
            progress.step(done_count)

        results = map_unordered(work, items, threads, check=check, wait=False)
        for done_count, result in enumerate(results, 1):  # noqa: B007 - read by `check`
            yield result
            check()

    def close(self) -> None:
        """Do nothing, because the executor has no resources to release."""


class Cluster:
    """Executor on the workers of a Dask scheduler, which must run this program version."""

    def __init__(self, address: str) -> None:
        """Connect to a scheduler.

        Raises
        ------
        UsageError
            If Dask is missing, or the scheduler does not respond or has no workers.
        """
        try:
            import distributed
        except ImportError as error:
            raise UsageError(
                Finding("cluster.no-dask"),
                field="--scheduler",
            ) from error
        for name in ("distributed", "distributed.client", "distributed.core", "tornado"):
            # Lost connections are reported as errors below, not as tracebacks of distributed.
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
        """Total number of threads of all workers."""
        return sum(self._client.nthreads().values())

    def map(
        self,
        work: Callable[[Item], Result],
        items: Iterable[Item],
        progress: Progress,
        needed_count: int = 0,
    ) -> Iterator[tuple[int, Result]]:
        """Yield results as they become available; see `Executor.map`.

        Raises
        ------
        WorkerError
            If the cluster has lost its workers, or the same item fails repeatedly.
        """
        import distributed

        worker_errors = (distributed.KilledWorker, distributed.CancelledError)
        done_count = 0
        progress.step(0)
        running_futures: dict[Any, tuple[int, Item, int]] = {}
        numbered_items = enumerate(items)
        completion = threading.Event()

        def submit(number: int, item: Item, attempt: int = 1) -> None:
            # Large items are sent as data, not inside the description of the task.
            item_future = self._client.scatter(item, direct=False, hash=False)
            future = self._client.submit(work, item_future, pure=False)
            running_futures[future] = (number, item, attempt)
            future.add_done_callback(lambda _: completion.set())

        try:
            for number, item in itertools.islice(numbered_items, self.workers + 1):
                submit(number, item)
            while running_futures:
                # `distributed.wait` would raise for all futures if one was lost with its worker.
                completion.wait(CHECK_PERIOD_S)
                completion.clear()
                progress.step(done_count)
                finished_futures = [future for future in running_futures if future.done()]
                if not finished_futures:
                    self._require_workers()
                for future in finished_futures:
                    number, item, attempt_number = running_futures.pop(future)
                    try:
                        result = future.result()
                    except worker_errors as error:
                        # The item was lost with its worker, and is sent again.
                        self._require_workers()
                        if attempt_number == MAX_ATTEMPTS:
                            raise WorkerError(
                                Finding(
                                    "cluster.part-lost",
                                    tries=attempt_number,
                                    error=type(error).__name__,
                                )
                            ) from error
                        submit(number, item, attempt_number + 1)
                        continue
                    for next_number, next_item in itertools.islice(numbered_items, 1):
                        submit(next_number, next_item)
                    done_count += 1
                    yield number, result
                    progress.step(done_count)
        finally:
            self._client.cancel(list(running_futures))

    def _require_workers(self) -> None:
        if not self._wait_for_workers():
            raise WorkerError(Finding("cluster.workers-lost"))

    def _wait_for_workers(self) -> bool:
        """Wait for a worker to start or restart. Return whether a worker is available."""
        end = time.monotonic() + MAX_RESTART_TIME_S
        while not self._threads():
            if self._client.status != "running" or time.monotonic() > end:
                return False
            time.sleep(CHECK_PERIOD_S)
        return True

    def _threads(self) -> int:
        try:
            return self.workers
        except OSError:
            # The connection to the scheduler is lost.
            return 0

    def close(self) -> None:
        """Disconnect from the scheduler."""
        self._client.close()


def make_executor(threads: int | None = None, scheduler: str | None = None) -> Executor:
    """Create an executor on a Dask cluster or in threads of this process.

    Parameters
    ----------
    threads : int, optional
        Number of threads, by default the number of processors.
    scheduler : str, optional
        Address of a Dask scheduler.

    Raises
    ------
    UsageError
        If the scheduler cannot be used.
    """
    if scheduler is not None:
        return Cluster(scheduler)
    count = threads or PROCESSOR_COUNT
    return InlineExecutor() if count == 1 else Threads(count)
