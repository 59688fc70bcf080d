"""Find a command by its words (Ctrl+K), and the list of shortcuts (F1)."""

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
    """Lists the commands whose texts contain all typed words; `chosen` is the selected one."""

    def __init__(self, parent: QWidget, actions: Actions) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("Find command"))
        self.resize(520, 420)
        self._actions = actions
        self._words = QLineEdit()
        self._words.setPlaceholderText(tr("Type part of a command's name"))
        self._words.textChanged.connect(self._fill)
        self._words.installEventFilter(self)
        # Rows with and without an icon stand in one line.
        blank = QPixmap(16, 16)
        blank.fill(Qt.GlobalColor.transparent)
        self._blank = QIcon(blank)
        self._list = QListWidget()
        self._list.itemActivated.connect(lambda _: self.accept())
        self._list.itemClicked.connect(lambda _: self.accept())
        layout = QVBoxLayout(self)
        layout.addWidget(self._words)
        layout.addWidget(self._list)
        self._words.returnPressed.connect(self._run)
        self._fill("")

    def _run(self) -> None:
        if self.chosen is not None:
            self.accept()

    @property
    def chosen(self) -> str | None:
        """Name of the selected command; None where none can run."""
        item = self._list.currentItem()
        return str(item.data(Qt.ItemDataRole.UserRole)) if item and item.flags() else None

    def _fill(self, text: str) -> None:
        self._list.clear()
        self._actions.refresh()
        words = text.casefold().split()
        for command in self._actions.commands():
            action = self._actions.all[command.name]
            plain = command.text.replace("&", "")
            haystack = f"{plain} {command.tip} {command.name}".casefold()
            if not all(word in haystack for word in words):
                continue
            keys = ", ".join(key.toString() for key in action.shortcuts())
            why_not = command.why_not()
            item = QListWidgetItem(
                self._blank if action.icon().isNull() else action.icon(),
                plain + (f"    {keys}" if keys else "") + (f"    – {why_not}" if why_not else ""),
            )
            item.setData(Qt.ItemDataRole.UserRole, command.name)
            if why_not is not None:
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
            # Past what cannot run now.
            while 0 <= row < self._list.count() and not self._list.item(row).flags():
                row += step
            if 0 <= row < self._list.count():
                self._list.setCurrentRow(row)
            return True
        return super().eventFilter(watched, event)
