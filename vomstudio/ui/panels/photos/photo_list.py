"""List of photos beside an open photo, sorted by usefulness for the selected point."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSignalBlocker, QSize, Qt, Signal
from PySide6.QtWidgets import QListView, QListWidget, QListWidgetItem

from vomstudio.core.words import tr, tr_n
from vomstudio.photogrammetry.georeferencing.mark_prediction import MAX_GOOD_RESIDUAL_PX
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import escape_markup
from vomstudio.ui.base.photo_images import THUMBNAIL_SIZE
from vomstudio.ui.panels.photos.photo_marks import PhotoMarks
from vomstudio.ui.panels.photos.photo_row import PhotoRow


class PhotoList(QListWidget):
    """List of photos with thumbnails and states.

    Attributes
    ----------
    opened : Signal
        Emitted with the name of the photo that the user selected.
    """

    opened = Signal(str)

    def __init__(self, rows: Sequence[PhotoRow], marks: PhotoMarks) -> None:
        super().__init__()
        self._rows = {row.name: row for row in rows}
        self._marks = marks
        self._label = ""
        self.setObjectName("photo_list")
        self.setIconSize(THUMBNAIL_SIZE)
        self.setUniformItemSizes(True)
        self.setTextElideMode(Qt.TextElideMode.ElideRight)
        self.setViewMode(QListView.ViewMode.ListMode)
        self.setMinimumWidth(236)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self._items: dict[str, QListWidgetItem] = {}
        for name, row in self._rows.items():
            item = QListWidgetItem(theme.picture_icon(row.thumbnail, THUMBNAIL_SIZE), name)
            item.setSizeHint(QSize(0, THUMBNAIL_SIZE.height() + 6))
            item.setData(Qt.ItemDataRole.UserRole, name)
            self._items[name] = item
            self.addItem(item)
        self.currentItemChanged.connect(self._emit_photo_opened)
        marks.changed.connect(self.refresh)
        self.refresh()

    @property
    def names(self) -> list[str]:
        """Photo names in the order of the list."""
        return [self.item(i).data(Qt.ItemDataRole.UserRole) for i in range(self.count())]

    def set_label(self, label: str) -> None:
        """Sort the photos for the point with this label; an empty string means no point."""
        self._label = label
        self.refresh()

    def refresh(self) -> None:
        """Sort the photos and update their texts."""
        marking, label = self._marks.marking, self._label
        prediction = self._marks.prediction(label) if label else None
        marked_pixels = marking.of(label) if label else {}
        marked_photos = [name for name in self._rows if name in marked_pixels]
        ranked_photos = (
            [] if prediction is None else [n for n in prediction.unmarked_photos if n in self._rows]
        )
        cameras = self._marks.cameras
        other_photos = [
            name for name in self._rows if name not in marked_pixels and name not in ranked_photos
        ]
        if cameras is not None and marked_pixels:
            # A second mark in the same component predicts the point in all photos of that
            # component.
            parts = {cameras.component_number(name) for name in marked_pixels}
            other_photos.sort(key=lambda name: cameras.component_number(name) not in parts)
        names = [*marked_photos, *ranked_photos, *other_photos]
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
            text, is_inaccurate = self._state_text(name, counts.get(name, 0))
            item.setText(f"{name.rpartition('/')[2]}\n{text}")
            item.setToolTip(escape_markup(f"{name}\n{text}"))
            color = theme.error_color() if is_inaccurate else self.palette().text().color()
            item.setForeground(color)

    def _state_text(self, name: str, count: int) -> tuple[str, bool]:
        label, is_inaccurate = self._label, False
        parts = []
        if label:
            prediction = self._marks.prediction(label)
            residual = prediction.residuals_px.get(name)
            if name in self._marks.marking.of(label):
                parts.append(tr("{label} marked", label=label))
                if residual is not None:
                    parts.append(f"{residual:.2f} px")
                worst_mark = prediction.worst_mark
                is_inaccurate = (
                    worst_mark is not None
                    and worst_mark[0] == name
                    and worst_mark[1] > MAX_GOOD_RESIDUAL_PX
                )
            elif name in prediction.expected:
                parts.append(tr("{label} predicted", label=label))
        elif count:
            parts.append(tr_n("{count} mark", "{count} marks", count))
        if self._rows[name].mask is not None:
            parts.append(tr("mask"))
        cameras = self._marks.cameras
        if cameras is not None:
            part = cameras.component_number(name)
            if part is None:
                parts.append(tr("not aligned"))
            elif part:
                parts.append(tr("component {number}", number=part + 1))
        return " · ".join(parts), is_inaccurate

    def open(self, name: str) -> None:
        self.setCurrentItem(self._items[name])

    def step(self, offset: int) -> None:
        """Open the photo that is `offset` rows further down, wrapping around at the ends."""
        if count := self.count():
            self.setCurrentRow((max(self.currentRow(), 0) + offset) % count)

    def _emit_photo_opened(self, item: QListWidgetItem | None) -> None:
        if item is not None:
            self.opened.emit(item.data(Qt.ItemDataRole.UserRole))
