"""A thread that begins with the first piece of work and waits for the next ones."""

from __future__ import annotations

import threading
from collections.abc import Callable

from vomstudio.failures import exception_hooks

Work = Callable[[], None]


class WorkerThread:
    """take : called with `lock` held, the most wanted piece of work or None where there is none;
    what it looks at is changed with `lock` held too, and `wake` called then."""

    def __init__(self, name: str, take: Callable[[], Work | None]) -> None:
        self.lock = threading.RLock()
        self._more = threading.Condition(self.lock)
        self._name, self._take = name, take
        self._thread: threading.Thread | None = None
        self.closed = False

    def wake(self) -> None:
        """There is new work: start the thread, or have it look again."""
        with self._more:
            if self._thread is None and not self.closed:
                self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
                self._thread.start()
            self._more.notify()

    def close(self) -> None:
        """End after the piece that is being worked on."""
        with self._more:
            self.closed = True
            self._more.notify()
        if self._thread is not None:
            self._thread.join(5.0)

    def _run(self) -> None:
        while True:
            with self._more:
                while (work := None if self.closed else self._take()) is None:
                    if self.closed:
                        return
                    self._more.wait()
            try:
                work()
            except Exception as error:  # noqa: BLE001 - the next piece is wanted all the same
                exception_hooks.report_as_uncaught(error)
            # Nor may it hold what the piece had in hand while it waits.
            del work
