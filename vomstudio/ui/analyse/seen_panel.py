"""A panel that comes up to date while somebody looks at it, and never otherwise."""

from __future__ import annotations

from PySide6.QtCore import QTimer
from PySide6.QtGui import QPaintEvent
from PySide6.QtWidgets import QWidget

from vomstudio.document.edit import Edit
from vomstudio.ui.common.studio import Studio

_SOON_MS = 120
"""After the last change of a row of them."""


class SeenPanel(QWidget):
    """What is shown is made anew by `show_now` of the panels of this kind."""

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
