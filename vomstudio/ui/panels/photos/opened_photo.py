"""The photo that is open: its picture, and where it is looked at."""

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
    """Shows one photo at a time in a canvas. turned : the orientation of the photo that was opened
    last has only now been read."""

    turned = Signal()

    def __init__(self, rows: Mapping[str, PhotoRow], canvas: MarkCanvas) -> None:
        super().__init__()
        self.rows, self._canvas = rows, canvas
        self._images = PhotoImages()
        self.name = ""
        self._pictured_once = False
        self._looked_at = ""
        self._images.pictured.connect(self._pictured)

    @property
    def row(self) -> PhotoRow | None:
        return self.rows.get(self.name)

    def show(self, name: str) -> None:
        """Open the photo of this name, and read it if it is not at hand."""
        row = self.rows[name]
        self.name, self._looked_at = name, ""
        self._canvas.set_used(None)
        self._canvas.set_photo(row.width, row.height)
        picture = self._images.picture(Path(row.path))
        self._pictured_once = picture is not None
        self._canvas.message = "" if picture else tr("Reading {photo}…", photo=name)
        if picture is not None:
            self._canvas.set_picture(picture)

    def _pictured(self, key: str, picture: PhotoPyramid | str) -> None:
        row = self.row
        if row is None or row.path != key:
            return
        if isinstance(picture, PhotoPyramid):
            self._canvas.message = ""
            self._canvas.set_picture(picture)
            if not self._pictured_once:
                # The whole picture, which comes later, leaves the view to the user.
                self._pictured_once = True
                self.turned.emit()
        else:
            self._canvas.message = tr(
                "{photo} cannot be shown: {reason}", photo=row.name, reason=picture
            )
            self._canvas.update()

    # --- where it is looked at ---------------------------------------------------------------
    def looks_at(self, label: str) -> bool:
        """Whether the view went to this point last."""
        return self._looked_at == label

    def look_at(self, label: str, place: Pixel) -> None:
        """Go close to a pixel at which a point is marked or predicted."""
        self._looked_at = label
        self._canvas.look_closely(place)

    def stay_at(self, label: str) -> None:
        """The user looks at the point already."""
        self._looked_at = label

    def close(self) -> None:
        self._images.close()
