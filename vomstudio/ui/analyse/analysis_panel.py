"""Panels that refresh only while they are visible, and panels that analyse the project."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Generic, TypeVar

from PySide6.QtCore import QTimer
from PySide6.QtGui import QPaintEvent
from PySide6.QtWidgets import QWidget

from vomstudio.document.edit import Edit
from vomstudio.errors import VomError
from vomstudio.ui.common.command_targets import ask_for_target
from vomstudio.ui.common.explained import explain
from vomstudio.ui.common.qt_background import NewestResult, QtBackground
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.interpret.tool_panels.common import hint_label

Question = TypeVar("Question")
Answer = TypeVar("Answer")

_SOON_MS = 120
"""After the last change of a row of them."""


class LazyPanel(QWidget):
    """Panel that refreshes only while it is visible, by its method `show_now`."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._stale = True
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(_SOON_MS)
        self._timer.timeout.connect(self.refresh)

    def show_now(self) -> None:
        """Bring everything up to date; somebody looks."""
        raise NotImplementedError

    def refresh(self) -> None:
        """Anew, unless nobody sees it."""
        self._stale = self.visibleRegion().isEmpty()
        if not self._stale:
            self.show_now()

    def _soon(self, *_: object) -> None:
        """Nothing waits where nobody looks: the panel comes up to date when it is painted."""
        if self.visibleRegion().isEmpty():
            self._stale = True
        elif not self._timer.isActive():
            self._timer.start()

    def _edited(self, edit: Edit) -> None:
        if self._studio.affected(edit):
            self._soon()

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        super().paintEvent(event)
        if self._stale:
            self._soon()


class AnalysisPanel(LazyPanel, Generic[Question, Answer]):
    """Panel that answers a question about the project, in a thread.

    answered : the result that is shown; None if there is none

    Parameters
    ----------
    studio : Studio
    prefix : str
        Beginning of the object names.
    topic : str
        Page of the help.
    busy : str
        Shown while a result is computed.
    """

    def __init__(self, studio: Studio, prefix: str, topic: str, busy: str) -> None:
        super().__init__(studio)
        explain(self, topic)
        self.answered: Answer | None = None
        self.said = hint_label()
        self.said.setObjectName(f"{prefix}_said")
        self._background = QtBackground(self)
        self._asked = NewestResult(self, self._came, self._failed, lambda: self.said.setText(busy))
        studio.jobs.closed.connect(self._close)

    def show_now(self) -> None:
        """Compute the result of what the form asks, or show why there is none."""
        if not self._studio.has_project:
            return
        self._list()
        why = self._asked.answer(self._question(), self._answer)
        if why is None:
            self._refresh()
        else:
            self._show(None, why)

    def _list(self) -> None:
        """Bring the lists of the form up to date."""

    def _question(self) -> Question | str:
        """Return what the form asks, or a sentence that states what is missing."""
        raise NotImplementedError

    def _answer(self, question: Question) -> Answer:
        """Compute the result. Runs in a thread. Raises VomError."""
        raise NotImplementedError

    def _result_text(self, made: Answer) -> str:
        raise NotImplementedError

    def _came(self, made: Answer) -> None:
        self._show(made, self._result_text(made))

    def _failed(self, error: VomError) -> None:
        self._show(None, error.message)

    def _show(self, answered: Answer | None, said: str) -> None:
        self.answered = answered
        self.said.setText(said)
        self._draw()
        self._refresh()

    def _draw(self) -> None:
        """Draw the result that is shown."""

    def _refresh(self) -> None:
        """Enable and disable the buttons."""

    # --- files -------------------------------------------------------------------------------
    def _ask_for_file(self, title: str, name: str, formats: Mapping[str, str]) -> None:
        path = ask_for_target(self, self._studio, title, name, formats)
        if path is not None:
            self.write_to(path)

    def write_to(self, path: Path) -> None:
        """Write the result that is shown, in a thread."""
        raise NotImplementedError

    def _write(
        self, write: Callable[[Any, Path], object], what: Any, path: Path, said: str
    ) -> None:
        studio = self._studio
        self._background.run(partial(write, what, path), lambda _: studio.info(said), studio.fail)

    def _close(self) -> None:
        self._timer.stop()
        self._asked.close()
        self._background.stop()
