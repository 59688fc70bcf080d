"""Search dialog for commands."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QIcon, QKeyEvent, QPixmap
from PySide6.QtWidgets import (
    QDialog,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.words import tr
from vomstudio.ui.base.actions import Actions


class CommandPalette(QDialog):
    """Search for commands whose texts contain all typed words."""

    def __init__(self, parent: QWidget, actions: Actions) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("Find command"))
        self.resize(520, 420)
        self._actions = actions
        self._search = QLineEdit()
        self._search.setPlaceholderText(tr("Type part of a command's name"))
        self._search.textChanged.connect(self._fill)
        self._search.installEventFilter(self)
        # An empty icon aligns the texts of commands without an icon.
        empty_pixmap = QPixmap(16, 16)
        empty_pixmap.fill(Qt.GlobalColor.transparent)
        self._empty_icon = QIcon(empty_pixmap)
        self._list = QListWidget()
        self._list.itemActivated.connect(lambda _: self.accept())
        self._list.itemClicked.connect(lambda _: self.accept())
        layout = QVBoxLayout(self)
        layout.addWidget(self._search)
        layout.addWidget(self._list)
        self._search.returnPressed.connect(self._accept_selection)
        self._fill("")

    def _accept_selection(self) -> None:
        if self.selected_command is not None:
            self.accept()

    @property
    def selected_command(self) -> str | None:
        """Name of the selected command, None if no listed command is enabled."""
        item = self._list.currentItem()
        return str(item.data(Qt.ItemDataRole.UserRole)) if item and item.flags() else None

    def _fill(self, text: str) -> None:
        self._list.clear()
        self._actions.refresh()
        terms = text.casefold().split()
        for command in self._actions.commands():
            action = self._actions.all[command.name]
            title = command.text.replace("&", "")
            searched_text = f"{title} {command.tip} {command.name}".casefold()
            if not all(word in searched_text for word in terms):
                continue
            shortcuts = ", ".join(key.toString() for key in action.shortcuts())
            reason = command.why_not()
            item = QListWidgetItem(
                self._empty_icon if action.icon().isNull() else action.icon(),
                title
                + (f"    {shortcuts}" if shortcuts else "")
                + (f"    – {reason}" if reason else ""),
            )
            item.setData(Qt.ItemDataRole.UserRole, command.name)
            if reason is not None:
                item.setFlags(Qt.ItemFlag.NoItemFlags)
            self._list.addItem(item)
        for row in range(self._list.count()):
            if self._list.item(row).flags():
                self._list.setCurrentRow(row)
                break

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if (
            isinstance(event, QKeyEvent)
            and event.type() == QEvent.Type.KeyPress
            and event.key() in (Qt.Key.Key_Down, Qt.Key.Key_Up)
        ):
            step = 1 if event.key() == Qt.Key.Key_Down else -1
            row = self._list.currentRow() + step
            # Skip disabled commands.
            while 0 <= row < self._list.count() and not self._list.item(row).flags():
                row += step
            if 0 <= row < self._list.count():
                self._list.setCurrentRow(row)
            return True
        return super().eventFilter(watched, event)
