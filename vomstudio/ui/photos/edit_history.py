"""What was done to photos in a window, to be taken back and done again."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

from PySide6.QtCore import QObject, Signal

_MOST = 500
_TOGETHER_S = 1.5


@dataclass(eq=False)
class Step:
    """words : what was done; photo : where it is to be seen
    swap : exchanges what is with what was, and so takes back and does again
    join : steps that follow each other at once under the same one are taken back together
    """

    words: str
    photo: str
    swap: Callable[[], None]
    join: object = None
    time: float = field(default_factory=time.monotonic)


class EditHistory(QObject):
    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self._done: list[Step] = []
        self._undone: list[Step] = []

    def add(self, step: Step) -> bool:
        """A step that is done. False where it belongs to the one before, whose swap does for
        both."""
        last = self._done[-1] if self._done else None
        self._undone.clear()
        if (
            last is not None
            and step.join is not None
            and last.join == step.join
            and step.time - last.time < _TOGETHER_S
        ):
            last.time = step.time
            self.changed.emit()
            return False
        self._done = [*self._done[-_MOST:], step]
        self.changed.emit()
        return True

    @property
    def undo_words(self) -> str | None:
        return self._done[-1].words if self._done else None

    @property
    def redo_words(self) -> str | None:
        return self._undone[-1].words if self._undone else None

    def undo(self) -> Step | None:
        return self._move(self._done, self._undone)

    def redo(self) -> Step | None:
        return self._move(self._undone, self._done)

    def _move(self, source: list[Step], target: list[Step]) -> Step | None:
        if not source:
            return None
        step = source.pop()
        step.swap()
        step.join = None
        target.append(step)
        self.changed.emit()
        return step
