"""The points that are marked in a set of photos, as the window works with them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PySide6.QtCore import QObject, Signal

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.control.control_files import crs_of, read_control, read_marks
from vomstudio.photogrammetry.georeferencing.mark_prediction import (
    NO_PREDICTION,
    Marking,
    MarkPrediction,
    PlacedPhotos,
    missing,
)
from vomstudio.ui.base.texts import abbreviate_names
from vomstudio.ui.panels.photos.photo_document import PhotoDocument


class PhotoMarks(QObject):
    """Points, marks, and where aligned cameras predict them.

    changed : points, marks, or cameras. message : a sentence for the user, and its level
    """

    changed = Signal()
    message = Signal(object, str)

    def __init__(self, document: PhotoDocument, photos: Sequence[str]) -> None:
        super().__init__()
        self._document, self.photos = document, photos
        self.marking = document.marking()
        self._cameras: PlacedPhotos | None = None
        self._predictions: dict[str, tuple[object, MarkPrediction]] = {}
        self._missing: list[Finding] | None = None
        document.points_changed.connect(self._read)

    def close(self) -> None:
        self._document.points_changed.disconnect(self._read)

    def _read(self) -> None:
        self.marking = self._document.marking()
        self._renew()

    def set_cameras(self, cameras: PlacedPhotos | None) -> None:
        self._cameras = cameras
        self._predictions.clear()
        self._renew()

    def _renew(self) -> None:
        self._missing = None
        self.changed.emit()

    # --- looking -----------------------------------------------------------------------------
    @property
    def cameras(self) -> PlacedPhotos | None:
        return self._cameras

    @property
    def crs(self) -> str | None:
        """Of the control points, "EPSG:n", where their file stated it."""
        found = self._document.photo_set
        return found.crs or None if found is not None else None

    def prediction(self, label: str) -> MarkPrediction:
        """Predicted positions and residuals of a point; NO_PREDICTION before the alignment."""
        if self._cameras is None:
            return NO_PREDICTION
        marking = self.marking
        own = tuple(marking.of(label).items())
        # What is not marked twice is found by the other points.
        rest = marking if marking.point(label) is not None else None
        kept = self._predictions.get(label)
        if kept is None or kept[0] != (own, rest):
            kept = (own, rest), self._cameras.predict(marking, label)
            self._predictions[label] = kept
        return kept[1]

    def epipolar_line(self, label: str, photo: str) -> FloatArray:
        """(k, 2) pixels of a photo on which a point must lie that is marked in one other photo;
        (0, 2) where it is marked in none or in several."""
        if self._cameras is None or not label:
            return np.zeros((0, 2))
        return self._cameras.epipolar_line(self.marking, label, photo)

    def missing(self) -> list[Finding]:
        """Return what is still needed before the points can place the model."""
        if self._missing is None:
            self._missing = missing(self.marking, self._cameras)
        return self._missing

    # --- changing ----------------------------------------------------------------------------
    def change(
        self, words: str, made: Marking, join: object = None, *, goes_on: bool = False
    ) -> None:
        """Take another state of the points, as a step of the history, unless a drag goes on."""
        if goes_on:
            self.marking = made
            self._renew()
        elif not self._document.set_marking(words, made, join):
            # It could not be written: what is shown is what is kept.
            self._read()

    def import_points(self, path: Path) -> int:
        """Take the points of a table, in place of those with the same label. Raises InputError."""
        points, crs = read_control(path), crs_of(path)
        if self.marking.control and None not in (crs, self.crs) and crs != self.crs:
            raise InputError(
                Finding("control.other-crs", crs=crs, project_crs=self.crs),
                file=path,
            )
        made = self.marking
        for point in points:
            made = made.placed(point)
        self._document.set_marking(tr("Import {file}", file=path.name), made, crs=crs)
        return len(points)

    def import_marks(self, path: Path) -> tuple[int, Finding | None]:
        """Take the marks of a table, in place of those of the same point and photo. Their number,
        and a warning or None. Raises InputError."""
        marks = read_marks(path)
        made, strangers = self.marking.add_marks(marks, self.photos)
        self.change(tr("Import {file}", file=path.name), made)
        return len(marks), unknown_photos(strangers) if strangers else None


def unknown_photos(photos: Sequence[str]) -> Finding:
    """Return the warning about marks in photos which the folder does not contain."""
    return Finding("marks.other-photos", photos=abbreviate_names(photos))
