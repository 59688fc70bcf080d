"""List of photos that show a target, with GSD and viewing angle."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QSignalBlocker, QSize, Qt, Signal
from PySide6.QtGui import QIcon, QImage, QPixmap
from PySide6.QtWidgets import QListView, QListWidget, QListWidgetItem

from vomstudio.core.words import tr
from vomstudio.ui.base.controls import escape_markup
from vomstudio.ui.base.photo_images import THUMBNAIL_SIZE, PhotoImages

if TYPE_CHECKING:
    from vomstudio.photogrammetry.inspect.photo_views import Sighting


class SightingList(QListWidget):
    """List of photos in which a target is visible.

    Attributes
    ----------
    photo_selected : Signal
        Emitted with the name of a photo that the user selected.
    list_changed : Signal
        Emitted when the list has changed.
    """

    photo_selected = Signal(str)
    list_changed = Signal()

    def __init__(self, images: PhotoImages) -> None:
        super().__init__()
        self._images = images
        self._rows: list[tuple[str, str]] = []
        self._paths: dict[str, str] = {}
        self.setObjectName("photos_that_show_it")
        self.setIconSize(THUMBNAIL_SIZE)
        self.setUniformItemSizes(True)
        self.setTextElideMode(Qt.TextElideMode.ElideRight)
        self.setViewMode(QListView.ViewMode.ListMode)
        self.setMinimumWidth(210)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.currentRowChanged.connect(self._emit_selection)
        images.thumbnail_loaded.connect(self._show_thumbnail)

    @property
    def names(self) -> list[str]:
        """Names of the photos in the list."""
        return [self.item(i).data(Qt.ItemDataRole.UserRole) for i in range(self.count())]

    def show_rows(
        self, rows: list[tuple[str, str]], find_path: Callable[[str], Path | None]
    ) -> None:
        """Show photos given by name and text; `find_path` returns the file of a photo, or None."""
        paths = {str(path): name for name, _ in rows if (path := find_path(name)) is not None}
        if rows == self._rows and paths == self._paths and self.count() == len(rows):
            return
        self._rows, self._paths = rows, paths
        files = {name: path for path, name in paths.items()}
        blank_pixmap = QPixmap(THUMBNAIL_SIZE)
        blank_pixmap.fill(Qt.GlobalColor.transparent)
        with QSignalBlocker(self):
            self.clear()
            for name, text in rows:
                item = QListWidgetItem(
                    QIcon(blank_pixmap), f"{name.rpartition('/')[2]}\n{text}".strip()
                )
                item.setData(Qt.ItemDataRole.UserRole, name)
                item.setSizeHint(QSize(0, THUMBNAIL_SIZE.height() + 6))
                item.setToolTip(escape_markup(self._tip(name, text)))
                self.addItem(item)
                file = files.get(name)
                if file is not None and (image := self._images.thumbnail(Path(file))) is not None:
                    item.setIcon(_photo_icon(image))
        self.list_changed.emit()

    def select_photo(self, name: str | None) -> None:
        """Select a photo without emitting `photo_selected`."""
        names = self.names
        with QSignalBlocker(self):
            self.setCurrentRow(names.index(name) if name in names else -1)

    def step(self, offset: int) -> None:
        """Select the photo that is `offset` rows further down, wrapping around at the ends."""
        if count := self.count():
            self.setCurrentRow((max(self.currentRow(), 0) + offset) % count)

    def _emit_selection(self, row: int) -> None:
        if row >= 0:
            self.photo_selected.emit(self.item(row).data(Qt.ItemDataRole.UserRole))

    def _tip(self, name: str, text: str) -> str:
        explanation = tr("GSD · angle between line of sight and surface normal")
        return f"{name}\n{text}\n({explanation})" if text else name

    def _show_thumbnail(self, key: str, image: QImage) -> None:
        name = self._paths.get(key)
        if name is not None and not image.isNull():
            for i, listed_name in enumerate(self.names):
                if listed_name == name:
                    self.item(i).setIcon(_photo_icon(image))


def sighting_text(sighting: Sighting, is_metric: bool) -> str:
    """Format the GSD (metric models only), the angle to the normal and the visible share."""
    parts = []
    if is_metric:
        gsd = sighting.gsd_m
        parts.append(f"{gsd * 1000:.1f} mm/px" if gsd < 0.01 else f"{gsd * 100:.1f} cm/px")
    if sighting.obliquity_deg is not None:
        parts.append(f"{sighting.obliquity_deg:.0f}°")
    if sighting.share < 0.995:
        parts.append(tr("{share:.0f} % visible", share=100 * sighting.share))
    return "\n".join([" · ".join(parts[:2]), *parts[2:]])


def _photo_icon(image: QImage) -> QIcon:
    return QIcon(QPixmap.fromImage(image))
