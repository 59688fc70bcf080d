"""What long work reports to, and how it is told to stop. No Qt, no threads of its own."""

from __future__ import annotations

import threading
from typing import Protocol

from vomstudio.errors import Cancelled


class CancelToken:
    """Set from any thread; work asks it between steps."""

    def __init__(self) -> None:
        self._event = threading.Event()

    def cancel(self) -> None:
        self._event.set()

    @property
    def cancelled(self) -> bool:
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
