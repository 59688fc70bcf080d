"""What long work reports to, and how it is told to stop. No Qt, no threads of its own."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from typing import Protocol, TypeVar

from vomstudio.core.errors import Cancelled


class CancelToken:
    """Set from any thread; work asks it between steps.

    >>> import vomstudio as vs
    >>> token = vs.CancelToken()
    >>> token.cancel()
    >>> token.cancelled
    True
    """

    def __init__(self) -> None:
        self._event = threading.Event()

    def cancel(self) -> None:
        """The work is not wanted any more."""
        self._event.set()

    @property
    def cancelled(self) -> bool:
        """Whether that was said."""
        return self._event.is_set()

    def check(self) -> None:
        """Raise `Cancelled` if the user has stopped the work."""
        if self.cancelled:
            raise Cancelled()


class Progress(Protocol):
    """Real counts, never invented percentages."""

    def stage(self, name: str, total: int | None = None) -> None:
        """A stage begins; `total` counts its steps, None where they cannot be known."""

    def step(self, done: int) -> None:
        """`done` steps of the stage are complete. Raises `Cancelled` once the work is stopped."""


class Silent:
    """A Progress nobody watches, which still can be cancelled."""

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
    """Where work on many photos or tiles is done: here, in processes, or on a cluster."""

    def map(
        self,
        work: Callable[[Item], Result],
        items: Iterable[Item],
        progress: Progress,
        needed: int = 0,
    ) -> Iterator[tuple[int, Result]]:
        """(number of the item, result) as they are finished, in any order.

        needed : bytes that the work on one item takes at most; as many are done at once as the
        memory of this machine holds

        `work` is a function at the top of a module, items and results can be pickled; photos travel
        as bytes. At most a few items are in flight, so that `items` may be made lazily. What `work`
        raises is raised here; Cancelled is raised within a second of the user's wish.
        """

    def close(self) -> None:
        """Nothing more is given to it."""


class Ahead:
    """Progress of what is left of a stage, some of whose steps an earlier run has done."""

    def __init__(self, progress: Progress, done: int) -> None:
        self._progress, self._done = progress, done

    def stage(self, name: str, total: int | None = None) -> None:
        self._progress.stage(name, total)

    def step(self, done: int) -> None:
        self._progress.step(self._done + done)


class Inline:
    """An Executor that does everything here, one item after the other."""

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
