"""The list of photos beside an open one, with those first that can show the chosen point."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSignalBlocker, QSize, Qt, Signal
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QListView, QListWidget, QListWidgetItem

from vomstudio.core.words import tr, tr_n
from vomstudio.photogrammetry.georeferencing.mark_prediction import BAD_PX
from vomstudio.rendering.qt.painting import VERDICT_COLORS
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import escape_markup
from vomstudio.ui.base.photo_images import THUMBNAIL
from vomstudio.ui.panels.photos.photo_marks import PhotoMarks
from vomstudio.ui.panels.photos.photo_row import PhotoRow


class PhotoList(QListWidget):
    """Each photo with its thumbnail and state. opened : the name of the photo that was chosen."""

    opened = Signal(str)

    def __init__(self, rows: Sequence[PhotoRow], marks: PhotoMarks) -> None:
        super().__init__()
        self._rows = {row.name: row for row in rows}
        self._marks = marks
        self._label = ""
        self.setObjectName("photo_list")
        self.setIconSize(THUMBNAIL)
        self.setUniformItemSizes(True)
        self.setTextElideMode(Qt.TextElideMode.ElideRight)
        self.setViewMode(QListView.ViewMode.ListMode)
        self.setMinimumWidth(236)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self._items: dict[str, QListWidgetItem] = {}
        for name, row in self._rows.items():
            item = QListWidgetItem(theme.picture_icon(row.thumbnail, THUMBNAIL), name)
            item.setSizeHint(QSize(0, THUMBNAIL.height() + 6))
            item.setData(Qt.ItemDataRole.UserRole, name)
            self._items[name] = item
            self.addItem(item)
        self.currentItemChanged.connect(self._current)
        marks.changed.connect(self.refresh)
        self.refresh()

    @property
    def names(self) -> list[str]:
        """In the order of the list."""
        return [self.item(i).data(Qt.ItemDataRole.UserRole) for i in range(self.count())]

    def set_label(self, label: str) -> None:
        """Choose the point for which the photos are sorted; "" for none."""
        self._label = label
        self.refresh()

    def refresh(self) -> None:
        """Sort the photos and renew what is said of each."""
        marking, label = self._marks.marking, self._label
        prediction = self._marks.prediction(label) if label else None
        own = marking.of(label) if label else {}
        first = [name for name in self._rows if name in own]
        by_use = (
            [] if prediction is None else [n for n in prediction.unmarked_photos if n in self._rows]
        )
        cameras = self._marks.cameras
        rest = [name for name in self._rows if name not in own and name not in by_use]
        if cameras is not None and own:
            # A second mark of the same part tells where the point is in all of it.
            parts = {cameras.part_of(name) for name in own}
            rest.sort(key=lambda name: cameras.part_of(name) not in parts)
        names = [*first, *by_use, *rest]
        with QSignalBlocker(self):
            if names != self.names:
                current = self.currentItem()
                while self.count():
                    self.takeItem(0)
                for name in names:
                    self.addItem(self._items[name])
                if current is not None:
                    self.setCurrentItem(current)
        counts: dict[str, int] = {}
        for mark in marking.marks:
            counts[mark.photo] = counts.get(mark.photo, 0) + 1
        for name in names:
            item = self._items[name]
            words, bad = self._words(name, counts.get(name, 0))
            item.setText(f"{name.rpartition('/')[2]}\n{words}")
            item.setToolTip(escape_markup(f"{name}\n{words}"))
            color = QColor(VERDICT_COLORS["poor"]) if bad else self.palette().text().color()
            item.setForeground(color)

    def _words(self, name: str, count: int) -> tuple[str, bool]:
        label, bad = self._label, False
        said = []
        if label:
            prediction = self._marks.prediction(label)
            residual = prediction.residuals_px.get(name)
            if name in self._marks.marking.of(label):
                said.append(tr("{label} marked", label=label))
                if residual is not None:
                    said.append(f"{residual:.2f} px")
                worst = prediction.worst
                bad = worst is not None and worst[0] == name and worst[1] > BAD_PX
            elif name in prediction.expected:
                said.append(tr("{label} predicted", label=label))
        elif count:
            said.append(tr_n("{count} mark", "{count} marks", count))
        if self._rows[name].mask is not None:
            said.append(tr("mask"))
        cameras = self._marks.cameras
        if cameras is not None:
            part = cameras.part_of(name)
            if part is None:
                said.append(tr("not aligned"))
            elif part:
                said.append(tr("component {number}", number=part + 1))
        return " · ".join(said), bad

    def open(self, name: str) -> None:
        self.setCurrentItem(self._items[name])

    def step(self, by: int) -> None:
        """Open the photo so many rows further, from the last to the first."""
        if count := self.count():
            self.setCurrentRow((max(self.currentRow(), 0) + by) % count)

    def _current(self, item: QListWidgetItem | None) -> None:
        if item is not None:
            self.opened.emit(item.data(Qt.ItemDataRole.UserRole))
