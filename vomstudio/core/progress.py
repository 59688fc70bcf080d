"""Progress and cancellation of long work, without Qt and without threads."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from typing import Protocol, TypeVar

from vomstudio.core.errors import Cancelled


class CancelToken:
    """Flag that any thread can set; long work checks it between steps.

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
        """Request the end of the work."""
        self._event.set()

    @property
    def cancelled(self) -> bool:
        """Whether `cancel` was called."""
        return self._event.is_set()

    def check(self) -> None:
        """Raise `Cancelled` if `cancel` was called."""
        if self.cancelled:
            raise Cancelled()


class Progress(Protocol):
    """Receiver of progress, in real counts and not in estimated percentages."""

    def stage(self, name: str, total: int | None = None) -> None:
        """Begin a stage.

        Parameters
        ----------
        name : str
            Name of the stage for the user.
        total : int, optional
            Number of its steps, None if unknown.
        """

    def step(self, done: int) -> None:
        """Report the number of complete steps of the stage.

        Raises
        ------
        Cancelled
            Once the user has stopped the work.
        """


class Silent:
    """Progress that is not displayed but can be cancelled."""

    def __init__(self, token: CancelToken | None = None) -> None:
        self._token = token

    def stage(self, name: str, total: int | None = None) -> None:
        self.step(0)

    def step(self, done: int) -> None:
        if self._token is not None:
            self._token.check()


Item = TypeVar("Item")
Result = TypeVar("Result")


class Executor(Protocol):
    """Runs work on many photos or tiles: in this process, in other processes or on a cluster."""

    def map(
        self,
        work: Callable[[Item], Result],
        items: Iterable[Item],
        progress: Progress,
        needed: int = 0,
    ) -> Iterator[tuple[int, Result]]:
        """Yield (number of the item, result) as results are ready, in any order.

        Parameters
        ----------
        work : callable
            Function at the top level of a module; items and results are pickled. Photos travel as
            bytes. Its exceptions are raised here.
        items : iterable
            Consumed lazily: few items are in flight.
        progress : Progress
        needed : int
            Maximum memory of the work on one item, in bytes; limits the number of parallel items.

        Raises
        ------
        Cancelled
            Within a second after the user has stopped the work.
        """

    def close(self) -> None:
        """Release the executor; it accepts no more work."""


class ResumedProgress:
    """Progress of a stage, some steps of which an earlier run has completed."""

    def __init__(self, progress: Progress, done: int) -> None:
        self._progress, self._done = progress, done

    def stage(self, name: str, total: int | None = None) -> None:
        self._progress.stage(name, total)

    def step(self, done: int) -> None:
        self._progress.step(self._done + done)


class InlineExecutor:
    """Executor that works in this process, one item after the other."""

    def map(
        self,
        work: Callable[[Item], Result],
        items: Iterable[Item],
        progress: Progress,
        needed: int = 0,
    ) -> Iterator[tuple[int, Result]]:
        for number, item in enumerate(items):
            progress.step(number)
            yield number, work(item)

    def close(self) -> None:
        pass
