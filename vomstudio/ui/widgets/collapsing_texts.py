"""Rows of buttons that hide their texts if the row is too narrow."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from PySide6.QtCore import QCoreApplication, QEvent, QObject, Qt
from PySide6.QtWidgets import QToolButton, QWidget

_TEXT_BESIDE_ICON = Qt.ToolButtonStyle.ToolButtonTextBesideIcon
_ICON_ONLY = Qt.ToolButtonStyle.ToolButtonIconOnly


class CollapsingTexts(QObject):
    """Event filter that hides icons or texts of buttons if their row is too narrow.

    Parameters
    ----------
    row : QWidget
        Row that contains the buttons.
    required_width : callable
        Returns the width in pixels that the row needs in its current state.
    """

    def __init__(self, row: QWidget, required_width: Callable[[], int]) -> None:
        super().__init__(row)
        self._row, self._required_width = row, required_width
        self._groups: list[tuple[list[QToolButton], Qt.ToolButtonStyle]] = []
        self._widths: list[int] = []
        row.installEventFilter(self)

    def add_group(
        self, buttons: Iterable[QToolButton], style: Qt.ToolButtonStyle = _ICON_ONLY
    ) -> None:
        """Add a group of buttons that collapse together, after the earlier groups.

        Parameters
        ----------
        style : Qt.ToolButtonStyle
            Style of the collapsed buttons.
        """
        self._groups.append((list(buttons), style))
        self._widths = []

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        event_type = event.type()
        if event_type in (QEvent.Type.FontChange, QEvent.Type.StyleChange):
            self._widths = []
        elif event_type in (QEvent.Type.Resize, QEvent.Type.Show):
            self.fit()
        return False

    def refit(self) -> None:
        """Measure the row again after texts or buttons have changed."""
        self._widths = []
        self.fit()

    def fit(self) -> None:
        """Show as many texts as fit."""
        if not self._widths:
            for group_count in range(len(self._groups) + 1):
                self._collapse_groups(group_count)
                self._widths.append(self._required_width())
        available_width = self._row.width()
        fits = [
            group_count
            for group_count, width in enumerate(self._widths)
            if width <= available_width
        ]
        self._collapse_groups(fits[0] if fits else len(self._groups))
        layout = self._row.layout()
        if layout is not None:
            # Buttons behind the extension arrow are hidden and do not request a layout.
            layout.invalidate()
            QCoreApplication.postEvent(self._row, QEvent(QEvent.Type.LayoutRequest))

    def _collapse_groups(self, collapsed_count: int) -> None:
        for number, (buttons, style) in enumerate(self._groups):
            for button in buttons:
                button.setToolButtonStyle(style if number < collapsed_count else _TEXT_BESIDE_ICON)
