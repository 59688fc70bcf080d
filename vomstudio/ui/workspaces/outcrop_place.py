"""The middle of the window: the outcrop, what a workspace is for, and what the program says."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QTimer
from PySide6.QtWidgets import QFrame, QLabel, QVBoxLayout, QWidget

# Of Qt, which does not export it.
_NO_LIMIT = 16777215


class OutcropPlace(QWidget):
    """Its height goes to the docks while it shows no outcrop; a message still finds room."""

    def __init__(self, first: QWidget) -> None:
        """first : stands in the place of the outcrop until that is there"""
        super().__init__()
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._column.setSpacing(0)
        self._purpose = QLabel()
        self._purpose.setObjectName("workspace_purpose")
        self._purpose.setWordWrap(True)
        self._purpose.setContentsMargins(8, 4, 8, 4)
        self._purpose.setFrameShape(QFrame.Shape.NoFrame)
        self._purpose.hide()
        self._column.addWidget(self._purpose)
        self._column.addWidget(first, 1)
        self._outcrop = first
        self._bar: QWidget | None = None
        self._shows = True

    def set_outcrop(self, outcrop: QWidget) -> None:
        self._column.replaceWidget(self._outcrop, outcrop)
        self._outcrop = outcrop
        outcrop.setVisible(self._shows)

    def set_bar(self, bar: QWidget) -> None:
        """bar : of messages, which lies over the top of the place"""
        self._bar = bar
        bar.installEventFilter(self)

    @property
    def shows_outcrop(self) -> bool:
        return self._shows

    def show_outcrop(self, shows: bool) -> None:
        """Give the outcrop its place, or the place to the docks."""
        if shows != self._shows:
            self._shows = shows
            self._outcrop.setVisible(shows)
            self._fit()
            # The window keeps the room of a dock that has just gone until it lays out anew.
            QTimer.singleShot(0, self._lay_out_window)

    def _lay_out_window(self) -> None:
        above = self.parentWidget()
        layout = None if above is None else above.layout()
        if layout is not None:
            layout.invalidate()
            layout.activate()

    def say_purpose(self, text: str) -> None:
        """One line above the outcrop; none where the text is empty."""
        self._purpose.setText(text)
        self._purpose.setVisible(bool(text))
        self._fit()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() in (QEvent.Type.Show, QEvent.Type.Hide, QEvent.Type.Resize):
            self._fit()
        return False

    def _fit(self) -> None:
        if self._shows:
            self.setMinimumHeight(0)
            self.setMaximumHeight(_NO_LIMIT)
        else:
            # A message lies over the line.
            shown = [w for w in (self._purpose, self._bar) if w is not None and not w.isHidden()]
            heights = [self._purpose.heightForWidth(self.width())] if self._purpose in shown else []
            heights += [self._bar.height()] if self._bar in shown and self._bar else []
            self.setFixedHeight(max(heights, default=0))
