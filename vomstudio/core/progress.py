"""Progress and cancellation of long-running tasks, without Qt or threads."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from typing import Protocol, TypeVar

from vomstudio.core.errors import Cancelled


class CancelToken:
    """Flag that any thread can set and that long-running tasks check between steps.

    Examples
    --------
    >>> import vomstudio as vs
    >>> token = vs.CancelToken()
    >>> token.cancel()
    >>> token.cancelled
    True
    """

    def __init__(self) -> None:
        self._event = threading.Event()

    def cancel(self) -> None:
        """Request the end of the task."""
        self._event.set()

    @property
    def cancelled(self) -> bool:
        """Whether `cancel` has been called."""
        return self._event.is_set()

    def check(self) -> None:
        """Raise `Cancelled` if `cancel` has been called."""
        if self.cancelled:
            raise Cancelled()


class Progress(Protocol):
    """Receiver of progress, reported in actual counts instead of estimated percentages."""

    def stage(self, name: str, total: int | None = None) -> None:
        """Begin a stage of the task.

        Parameters
        ----------
        name : str
            Display name of the stage.
        total : int, optional
            Number of steps of the stage, or None if unknown.
        """

    def step(self, done_count: int) -> None:
        """Report the number of completed steps of the stage.

        Raises
        ------
        Cancelled
            If the user has stopped the task.
        """


class SilentProgress:
    """Progress that is not displayed but supports cancellation."""

    def __init__(self, token: CancelToken | None = None) -> None:
        self._token = token

    def stage(self, name: str, total: int | None = None) -> None:
        self.step(0)

    def step(self, done_count: int) -> None:
        if self._token is not None:
            self._token.check()


Item = TypeVar("Item")
Result = TypeVar("Result")


class Executor(Protocol):
    """Executor of work on many photos or tiles, in this or other processes or on a cluster."""

    def map(
        self,
        function: Callable[[Item], Result],
        items: Iterable[Item],
        progress: Progress,
        needed_bytes: int = 0,
    ) -> Iterator[tuple[int, Result]]:
        """Yield (item number, result) as results become available, in any order.

        Parameters
        ----------
        function : callable
            Function at the top level of a module. Items and results are pickled; photos are
            transferred as bytes. Exceptions of the function are raised here.
        items : iterable
            Items, consumed lazily so that only a few are in progress at a time.
        progress : Progress
        needed_bytes : int
            Maximum memory needed for one item, in bytes; it limits the number of parallel items.

        Raises
        ------
        Cancelled
            Within a second after the user has stopped the task.
        """

    def close(self) -> None:
        """Release the executor, which then accepts no more work."""


class ResumedProgress:
    """Progress of a stage that an earlier run has completed in part."""

    def __init__(self, progress: Progress, done: int) -> None:
        self._progress, self._done_count = progress, done

    def stage(self, name: str, total: int | None = None) -> None:
        self._progress.stage(name, total)

    def step(self, done_count: int) -> None:
        self._progress.step(self._done_count + done_count)


class InlineExecutor:
    """Executor that processes the items one after the other in this process."""

    def map(
        self,
        function: Callable[[Item], Result],
        items: Iterable[Item],
        progress: Progress,
        needed_bytes: int = 0,
    ) -> Iterator[tuple[int, Result]]:
        for index, item in enumerate(items):
            progress.step(index)
            yield index, function(item)

    def close(self) -> None:
        pass
