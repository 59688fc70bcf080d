"""The photo that is open: its picture, and where it is looked at."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from vomstudio.core.words import tr
from vomstudio.photogrammetry.georeferencing.mark_prediction import Pixel
from vomstudio.ui.base.photo_images import PhotoImages, Picture
from vomstudio.ui.panels.photos.mark_canvas import MarkCanvas
from vomstudio.ui.panels.photos.photo_row import PhotoRow


class OpenedPhoto(QObject):
    """Shows one photo at a time in a canvas. turned : the orientation of the photo that was opened
    last has only now been read."""

    orientation_changed = Signal()

    def __init__(self, rows: Mapping[str, PhotoRow], canvas: MarkCanvas) -> None:
        super().__init__()
        self.rows, self._canvas = rows, canvas
        self._images = PhotoImages()
        self.name = ""
        self._has_picture = False
        self._viewed_label = ""
        self._images.pictured.connect(self._show_picture)

    @property
    def row(self) -> PhotoRow | None:
        return self.rows.get(self.name)

    def show(self, name: str) -> None:
        """Open the photo of this name, and read it if it is not at hand."""
        row = self.rows[name]
        self.name, self._viewed_label = name, ""
        self._canvas.set_used(None)
        self._canvas.set_photo(row.width, row.height)
        picture = self._images.picture(Path(row.path))
        self._has_picture = picture is not None
        self._canvas.message = "" if picture else tr("Reading {photo}…", photo=name)
        if picture is not None:
            self._canvas.set_picture(picture)

    def _show_picture(self, key: str, picture: Picture | str) -> None:
        row = self.row
        if row is None or row.path != key:
            return
        if isinstance(picture, Picture):
            self._canvas.message = ""
            self._canvas.set_picture(picture)
            if not self._has_picture:
                # The whole picture, which comes later, leaves the view to the user.
                self._has_picture = True
                self.orientation_changed.emit()
        else:
            self._canvas.message = tr(
                "{photo} cannot be shown: {reason}", photo=row.name, reason=picture
            )
            self._canvas.update()

    # --- where it is looked at ---------------------------------------------------------------
    def is_viewing_point(self, label: str) -> bool:
        """Whether the view went to this point last."""
        return self._viewed_label == label

    def zoom_to_point(self, label: str, place: Pixel) -> None:
        """Go close to a pixel at which a point is marked or predicted."""
        self._viewed_label = label
        self._canvas.look_closely(place)

    def set_viewed_point(self, label: str) -> None:
        """The user looks at the point already."""
        self._viewed_label = label

    def close(self) -> None:
        self._images.close()
