"""Rows of buttons that drop texts where there is no room for them."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from PySide6.QtCore import QCoreApplication, QEvent, QObject, Qt
from PySide6.QtWidgets import QToolButton, QWidget

_BESIDE = Qt.ToolButtonStyle.ToolButtonTextBesideIcon
_ICON = Qt.ToolButtonStyle.ToolButtonIconOnly


class CollapsingTexts(QObject):
    """Buttons of a row show icon and text as far as there is room; the others one of both."""

    def __init__(self, row: QWidget, needed: Callable[[], int]) -> None:
        """needed : the width in pixels that the row would need as it is"""
        super().__init__(row)
        self._row, self._needed = row, needed
        self._groups: list[tuple[list[QToolButton], Qt.ToolButtonStyle]] = []
        self._widths: list[int] = []
        row.installEventFilter(self)

    def drop(self, buttons: Iterable[QToolButton], instead: Qt.ToolButtonStyle = _ICON) -> None:
        """These go next, all at once. instead : what they then show"""
        self._groups.append((list(buttons), instead))
        self._widths = []

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        kind = event.type()
        if kind in (QEvent.Type.FontChange, QEvent.Type.StyleChange):
            self._widths = []
        elif kind in (QEvent.Type.Resize, QEvent.Type.Show):
            self.fit()
        return False

    def refit(self) -> None:
        """Texts have changed, or buttons have come or gone."""
        self._widths = []
        self.fit()

    def fit(self) -> None:
        """Show as many texts as the row has room for."""
        if not self._widths:
            for dropped in range(len(self._groups) + 1):
                self._show(dropped)
                self._widths.append(self._needed())
        room = self._row.width()
        fits = [dropped for dropped, width in enumerate(self._widths) if width <= room]
        self._show(fits[0] if fits else len(self._groups))
        layout = self._row.layout()
        if layout is not None:
            # A button that lay behind the arrow at the end is hidden: such ones ask for nothing.
            layout.invalidate()
            QCoreApplication.postEvent(self._row, QEvent(QEvent.Type.LayoutRequest))

    def _show(self, dropped: int) -> None:
        for place, (buttons, instead) in enumerate(self._groups):
            for button in buttons:
                button.setToolButtonStyle(instead if place < dropped else _BESIDE)
