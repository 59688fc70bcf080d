"""Search of commands, pages and documentation by their words (Ctrl+K)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QObject, QSize, Qt
from PySide6.QtGui import QIcon, QKeyEvent, QPixmap
from PySide6.QtWidgets import (
    QDialog,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.ui.base.actions import Actions, strip_mnemonic
from vomstudio.ui.base.controls import Label
from vomstudio.ui.base.search import SearchEntry, command_synonyms, rank
from vomstudio.ui.base.texts import first_sentence

MAX_RECENT = 20
_ICON_SIZE = QSize(18, 18)


@dataclass(frozen=True)
class Destination:
    """Page or document that the search opens."""

    entry: SearchEntry
    open: Callable[[], object]


class CommandPalette(QDialog):
    """Dialog that lists all entries that match the typed words, best match first."""

    def __init__(
        self, parent: QWidget, actions: Actions, destinations: Sequence[Destination] = ()
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("Search"))
        self.resize(560, 460)
        self._actions = actions
        self._destinations = {item.entry.key: item for item in destinations}
        self._search = QLineEdit()
        self._search.setPlaceholderText(tr("Command, page, setting or document"))
        self._search.textChanged.connect(self._fill)
        self._search.installEventFilter(self)
        # An empty icon aligns the texts of entries without an icon.
        empty_pixmap = QPixmap(_ICON_SIZE)
        empty_pixmap.fill(Qt.GlobalColor.transparent)
        self._empty_icon = QIcon(empty_pixmap)
        self._list = QListWidget()
        self._list.setIconSize(_ICON_SIZE)
        self._list.setTextElideMode(Qt.TextElideMode.ElideRight)
        self._list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self._list.itemActivated.connect(lambda _: self._accept_selection())
        self._list.itemClicked.connect(lambda _: self._accept_selection())
        self._no_match_label = Label(tr("No command matches."))
        self._no_match_label.setAlignment(Qt.AlignmentFlag.AlignCenter)
        layout = QVBoxLayout(self)
        layout.addWidget(self._search)
        layout.addWidget(self._no_match_label)
        layout.addWidget(self._list)
        self._search.returnPressed.connect(self._accept_selection)
        self._commands = {command.name: command for command in actions.commands()}
        entries = (
            SearchEntry(
                name, strip_mnemonic(item.text).rstrip("…"), command_synonyms(name), item.tip
            )
            for name, item in self._commands.items()
        )
        self._entries = [*entries, *(item.entry for item in destinations)]
        self._fill("")

    def _accept_selection(self) -> None:
        if self.selected_command is not None:
            self.accept()

    @property
    def selected_command(self) -> str | None:
        """Key of the selected entry, or None if no entry is selected or it cannot run now."""
        item = self._list.currentItem()
        key = None if item is None else str(item.data(Qt.ItemDataRole.UserRole))
        return None if key is None or self._disabled_reason(key) else key

    def run_selected(self) -> None:
        """Run the selected command, or open the selected page or document."""
        key = self.selected_command
        if key is None:
            return
        if key in self._actions.recent_commands:
            self._actions.recent_commands.remove(key)
        self._actions.recent_commands.insert(0, key)
        del self._actions.recent_commands[MAX_RECENT:]
        if key in self._commands:
            self._actions.run(key)
        else:
            self._destinations[key].open()

    def _disabled_reason(self, key: str) -> Finding | None:
        return self._commands[key].disabled_reason() if key in self._commands else None

    def _fill(self, text: str) -> None:
        self._list.clear()
        self._actions.refresh()
        ranked_entries = rank(text, self._entries, self._actions.recent_commands)
        self._no_match_label.setVisible(not ranked_entries)
        for entry in ranked_entries:
            self._list.addItem(self._create_item(entry))
        self._list.setCurrentRow(0)

    def _create_item(self, entry: SearchEntry) -> QListWidgetItem:
        icon, title = self._empty_icon, entry.title
        reason = self._disabled_reason(entry.key)
        if entry.key in self._commands:
            action = self._actions.all[entry.key]
            shortcuts = ", ".join(key.toString() for key in action.shortcuts())
            icon = icon if action.icon().isNull() else action.icon()
            title += (f"    {shortcuts}" if shortcuts else "") + (
                f"    – {first_sentence(reason.message)}" if reason else ""
            )
        item = QListWidgetItem(icon, title)
        item.setData(Qt.ItemDataRole.UserRole, entry.key)
        if reason is not None:
            item.setToolTip(reason.message)
            item.setForeground(self.palette().placeholderText())
        return item

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if (
            isinstance(event, QKeyEvent)
            and event.type() == QEvent.Type.KeyPress
            and event.key() in (Qt.Key.Key_Down, Qt.Key.Key_Up)
        ):
            step = 1 if event.key() == Qt.Key.Key_Down else -1
            row = self._list.currentRow() + step
            if 0 <= row < self._list.count():
                self._list.setCurrentRow(row)
            return True
        return super().eventFilter(watched, event)
