"""Short work, such as reading a file, done in a thread so that the window stays responsive."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from typing import TypeVar

from PySide6.QtCore import QObject, QRunnable, QThreadPool, QTimer
from shiboken6 import isValid

from vomstudio.failures import exception_hooks
from vomstudio.ui.common.qt_owner import poster

Made = TypeVar("Made")
Question = TypeVar("Question")
Work = Callable[[], object]
Then = Callable[[object], None]

_SLOW_MS = 200


class Background(QObject):
    """Runs work in a thread and passes what it returns to a function in the GUI's thread, unless
    the owner is gone by then. Work must not raise; expected errors are returned. An exception is
    reported as a fault of the program, and nothing is passed on."""

    def __init__(self, owner: QObject) -> None:
        super().__init__(owner)
        self.closed = False
        self._post = poster(self)

    def run(self, work: Work, then: Then) -> None:
        """Do `work` in a thread, then call `then` with its result in the GUI's thread."""
        QThreadPool.globalInstance().start(_Task(work, partial(self._hand_over, then)))

    def close(self) -> None:
        """No result is passed on any more."""
        self.closed = True

    def unless_closed(self, then: Callable[[Made], None]) -> Callable[[Made], None]:
        """A function that does nothing once this is closed, or gone with its owner: for what is
        called by somebody who outlives the owner, such as a job."""

        def called(made: Made) -> None:
            if isValid(self) and not self.closed:
                then(made)

        return called

    def _hand_over(self, then: Then, made: object) -> None:
        """From the thread."""
        self._post(partial(self._deliver, then, made))

    def _deliver(self, then: Then, made: object) -> None:
        if not self.closed:
            then(made)


class NewestResult(QObject):
    """Does one piece of work at a time in a thread, and then the one that was asked for last; what
    was asked for in between is never begun. Work must not raise; it returns expected errors.

    slow : called where a result has been waited for for 0.2 s
    """

    def __init__(self, owner: QObject, then: Then, slow: Callable[[], None]) -> None:
        super().__init__(owner)
        self._background = Background(self)
        self._then = then
        self._wanted: Work | None = None
        self._busy = self._dropped = False
        self._slow = QTimer(self)
        self._slow.setSingleShot(True)
        self._slow.setInterval(_SLOW_MS)
        self._slow.timeout.connect(slow)

    @property
    def waiting(self) -> bool:
        """Whether a result is to come."""
        return self._wanted is not None or (self._busy and not self._dropped)

    def at_once(self, work: Work) -> None:
        """Short work: done here and now, in place of what was asked for before."""
        self.drop()
        self._then(work())

    def answer(self, question: Question | str, work: Callable[[Question], object]) -> str | None:
        """As `ask`, of the work on a question. Words in place of one say why there is none: then
        nothing is waited for any more, and they come back."""
        if isinstance(question, str):
            self.drop()
            return question
        self.ask(partial(work, question))
        return None

    def ask(self, work: Work) -> None:
        """Do this in a thread, in place of what was asked for before."""
        if not self.waiting:
            self._slow.start()
        self._wanted = work
        self._begin()

    def close(self) -> None:
        """No result is passed on any more."""
        self.drop()
        self._background.close()

    def drop(self) -> None:
        """What was asked for is not wanted any more."""
        self._slow.stop()
        self._wanted = None
        self._dropped = self._busy

    def _begin(self) -> None:
        if self._busy or self._wanted is None:
            return
        work, self._wanted = self._wanted, None
        self._busy, self._dropped = True, False
        self._background.run(work, self._done)

    def _done(self, made: object) -> None:
        self._busy = False
        if self._wanted is not None:
            self._begin()
        elif not self._dropped:
            self._slow.stop()
            self._then(made)


class _Task(QRunnable):
    """In a thread of Python's for which one of Qt's waits, so that there are never more than Qt
    finds good. A thread of Qt's lives on after Python has forgotten it, and a library that keeps
    something for each thread then finds what is no longer there: the next use of pyproj in it ended
    the program (pyproj issue 1509)."""

    def __init__(self, work: Work, hand_over: Then) -> None:
        super().__init__()
        self._work, self._hand_over = work, hand_over

    def run(self) -> None:
        thread = threading.Thread(target=self._run, name="background", daemon=True)
        thread.start()
        thread.join()

    def _run(self) -> None:
        try:
            made = self._work()
        except Exception as error:  # noqa: BLE001 - the owner's thread must not wait for an answer
            exception_hooks.report_as_uncaught(error)
            return
        self._hand_over(made)
