"""Where the work on many photos or tiles is done: threads of this process, or a Dask cluster."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from typing import Any, TypeVar

from vomstudio.errors import UsageError, WorkerError
from vomstudio.progress import Executor, Inline, Progress

Item = TypeVar("Item")
Result = TypeVar("Result")

# How long a wish to stop may go unheard.
_PATIENCE_S = 0.25


class Threads:
    """An Executor of `count` threads. What it is given is native code that frees the GIL; threads
    share the photos that they read, and one process is what a supervisor can kill."""

    def __init__(self, count: int) -> None:
        self._count = count

    def map(
        self, work: Callable[[Item], Result], items: Iterable[Item], progress: Progress
    ) -> Iterator[tuple[int, Result]]:
        done = 0
        progress.step(0)
        pool = ThreadPoolExecutor(self._count)
        try:
            numbered = enumerate(items)
            running = {
                pool.submit(work, item): number
                for number, item in itertools.islice(numbered, self._count)
            }
            while running:
                finished, _ = wait(running, _PATIENCE_S, FIRST_COMPLETED)
                progress.step(done)
                for future in finished:
                    number = running.pop(future)
                    result = future.result()
                    for next_number, item in itertools.islice(numbered, 1):
                        running[pool.submit(work, item)] = next_number
                    done += 1
                    yield number, result
                    progress.step(done)
        finally:
            # Nobody waits for what is not wanted any more.
            pool.shutdown(wait=False, cancel_futures=True)

    def close(self) -> None:
        pass


class Cluster:
    """An Executor on the workers of a Dask scheduler, which must have this version installed."""

    def __init__(self, address: str) -> None:
        """Raises UsageError where Dask is not installed, or the scheduler does not answer."""
        try:
            import distributed
        except ImportError as error:
            raise UsageError(
                "a cluster needs Dask; install it with: pip install 'vomstudio[cluster]'",
                field="--scheduler",
            ) from error
        try:
            self._client = distributed.Client(address, timeout=10, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:
            raise UsageError(
                f"no Dask scheduler answers at {address}; start one, or leave this out",
                field="--scheduler",
            ) from error
        if not self.workers:
            self.close()
            raise UsageError(
                f"the scheduler at {address} has no workers; start some: dask worker {address}",
                field="--scheduler",
            )

    @property
    def workers(self) -> int:
        """Threads of all workers together."""
        return sum(self._client.nthreads().values())

    def map(
        self, work: Callable[[Item], Result], items: Iterable[Item], progress: Progress
    ) -> Iterator[tuple[int, Result]]:
        import distributed

        done = 0
        progress.step(0)
        running: dict[Any, int] = {}
        numbered = enumerate(items)

        def submit(count: int) -> None:
            for number, item in itertools.islice(numbered, count):
                # A large item travels as data of its own, not inside the task's description.
                sent = self._client.scatter(item, direct=False, hash=False)
                future = self._client.submit(work, sent, pure=False, retries=2)
                running[future] = number

        try:
            submit(self.workers + 1)
            while running:
                try:
                    with self._client.as_current():
                        finished = distributed.wait(
                            list(running), timeout=_PATIENCE_S, return_when="FIRST_COMPLETED"
                        ).done
                except TimeoutError:
                    progress.step(done)
                    if not self._client.nthreads():
                        raise WorkerError(
                            "the cluster has lost all its workers; what is finished is kept, "
                            "start workers and try again"
                        ) from None
                    continue
                for future in finished:
                    number = running.pop(future)
                    try:
                        result = future.result()
                    except (distributed.KilledWorker, distributed.CancelledError) as error:
                        raise WorkerError(
                            f"the cluster lost a part of the work ({type(error).__name__}); what "
                            "is finished is kept, try again"
                        ) from error
                    submit(1)
                    done += 1
                    yield number, result
                    progress.step(done)
        finally:
            self._client.cancel(list(running))

    def close(self) -> None:
        self._client.close()


def make_executor(threads: int | None = None, scheduler: str | None = None) -> Executor:
    """threads: None for as many as there are processors. Raises UsageError."""
    if scheduler is not None:
        return Cluster(scheduler)
    count = threads or os.cpu_count() or 1
    return Inline() if count == 1 else Threads(count)
