"""Image and view of the open photo."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from vomstudio.core.words import tr
from vomstudio.photogrammetry.georeferencing.mark_prediction import Pixel
from vomstudio.ui.base.photo_images import PhotoImages, PhotoPyramid
from vomstudio.ui.panels.photos.mark_canvas import MarkCanvas
from vomstudio.ui.panels.photos.photo_row import PhotoRow


class OpenedPhoto(QObject):
    """Controller that shows one photo at a time on a canvas.

    Attributes
    ----------
    orientation_changed : Signal
        Emitted when the orientation of the photo has been read after the photo was opened.
    """

    orientation_changed = Signal()

    def __init__(self, rows: Mapping[str, PhotoRow], canvas: MarkCanvas) -> None:
        super().__init__()
        self.rows, self._canvas = rows, canvas
        self._images = PhotoImages()
        self.name = ""
        self._has_picture = False
        self._viewed_label = ""
        self._images.picture_loaded.connect(self._show_picture)

    @property
    def row(self) -> PhotoRow | None:
        return self.rows.get(self.name)

    def show(self, name: str) -> None:
        """Open the photo with this name, reading it if it is not cached."""
        row = self.rows[name]
        self.name, self._viewed_label = name, ""
        self._canvas.set_used(None)
        self._canvas.set_photo(row.width, row.height)
        picture = self._images.picture(Path(row.path))
        self._has_picture = picture is not None
        self._canvas.message = "" if picture else tr("Reading {photo}…", photo=name)
        if picture is not None:
            self._canvas.set_picture(picture)

    def _show_picture(self, key: str, picture: PhotoPyramid | str) -> None:
        row = self.row
        if row is None or row.path != key:
            return
        if isinstance(picture, PhotoPyramid):
            self._canvas.message = ""
            self._canvas.set_picture(picture)
            if not self._has_picture:
                # The full image follows later and must not change the view.
                self._has_picture = True
                self.orientation_changed.emit()
        else:
            self._canvas.message = tr(
                "{photo} cannot be shown: {reason}", photo=row.name, reason=picture
            )
            self._canvas.update()

    # --- view --------------------------------------------------------------------------------
    def is_viewing_point(self, label: str) -> bool:
        """Return whether the view was last moved to this point."""
        return self._viewed_label == label

    def zoom_to_point(self, label: str, pixel: Pixel) -> None:
        """Zoom to the pixel where a point is marked or predicted."""
        self._viewed_label = label
        self._canvas.zoom_to_pixel(pixel)

    def set_viewed_point(self, label: str) -> None:
        """Record that the point is already in view."""
        self._viewed_label = label

    def close(self) -> None:
        self._images.close()
