"""Points marked in a photo set, and their predicted positions."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PySide6.QtCore import QObject, Signal

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.control.control_files import read_control, read_crs, read_marks
from vomstudio.photogrammetry.georeferencing.mark_prediction import (
    NO_PREDICTION,
    ControlMarks,
    MarkPrediction,
    PlacedPhotos,
    missing_marks_findings,
)
from vomstudio.ui.base.texts import abbreviate_names
from vomstudio.ui.panels.photos.photo_document import PhotoDocument


class PhotoMarks(QObject):
    """Points, marks and predicted positions of marks.

    Attributes
    ----------
    changed : Signal
        Emitted when points, marks or cameras have changed.
    message : Signal
        Emitted with a message for the user and its level.
    """

    changed = Signal()
    message = Signal(object, str)

    def __init__(self, document: PhotoDocument, photos: Sequence[str]) -> None:
        super().__init__()
        self._document, self.photos = document, photos
        self.marking = document.marking()
        self._cameras: PlacedPhotos | None = None
        self._predictions: dict[str, tuple[object, MarkPrediction]] = {}
        self._missing_items: list[Finding] | None = None
        document.points_changed.connect(self._reload)

    def close(self) -> None:
        self._document.points_changed.disconnect(self._reload)

    def _reload(self) -> None:
        self.marking = self._document.marking()
        self._notify()

    def set_cameras(self, cameras: PlacedPhotos | None) -> None:
        self._cameras = cameras
        self._predictions.clear()
        self._notify()

    def _notify(self) -> None:
        self._missing_items = None
        self.changed.emit()

    # --- state -------------------------------------------------------------------------------
    @property
    def cameras(self) -> PlacedPhotos | None:
        return self._cameras

    @property
    def crs(self) -> str | None:
        """CRS of the control points ("EPSG:n"), or None if it is unknown."""
        photo_set = self._document.photo_set
        return photo_set.crs or None if photo_set is not None else None

    def prediction(self, label: str) -> MarkPrediction:
        """Return the predicted positions and residuals of a point.

        Before the alignment the result is NO_PREDICTION.
        """
        if self._cameras is None:
            return NO_PREDICTION
        marking = self.marking
        pixels = tuple(marking.of(label).items())
        # A point with fewer than two marks is predicted from the other points.
        known_marking = marking if marking.point(label) is not None else None
        entry = self._predictions.get(label)
        if entry is None or entry[0] != (pixels, known_marking):
            entry = (pixels, known_marking), self._cameras.predict(marking, label)
            self._predictions[label] = entry
        return entry[1]

    def epipolar_line(self, label: str, photo: str) -> FloatArray:
        """Return the epipolar line of a point that is marked in exactly one other photo.

        Returns
        -------
        (k, 2) float64
            Pixels of the line; empty before the alignment, or if the point is marked in no other
            photo or in several.
        """
        if self._cameras is None or not label:
            return np.zeros((0, 2))
        return self._cameras.epipolar_line(self.marking, label, photo)

    def missing_items(self) -> list[Finding]:
        """Return findings about the points and marks still needed to place the model."""
        if self._missing_items is None:
            self._missing_items = missing_marks_findings(self.marking, self._cameras)
        return self._missing_items

    # --- edits -------------------------------------------------------------------------------
    def change(
        self,
        title: str,
        marking: ControlMarks,
        merge_key: object = None,
        *,
        is_ongoing: bool = False,
    ) -> None:
        """Apply a new state of the points as one edit, or only display it if `is_ongoing`."""
        if is_ongoing:
            self.marking = marking
            self._notify()
        elif not self._document.set_marking(title, marking, merge_key):
            # Writing has failed, so the state of the records is shown again.
            self._reload()

    def import_points(self, path: Path) -> int:
        """Import a table of points, which replace points with the same label.

        Returns
        -------
        int
            Number of points in the table.

        Raises
        ------
        InputError
            If the table cannot be read or has another CRS than the present control points.
        """
        points, crs = read_control(path), read_crs(path)
        if self.marking.control and None not in (crs, self.crs) and crs != self.crs:
            raise InputError(
                Finding("control.other-crs", crs=crs, project_crs=self.crs),
                file=path,
            )
        marking = self.marking
        for point in points:
            marking = marking.set_coordinates(point)
        self._document.set_marking(tr("Import {file}", file=path.name), marking, crs=crs)
        return len(points)

    def import_marks(self, path: Path) -> tuple[int, Finding | None]:
        """Import a table of marks, which replace marks of the same point and photo.

        Returns
        -------
        count : int
            Number of marks.
        warning : Finding or None
            Warning about marks in photos that the folder does not contain, or None.

        Raises
        ------
        InputError
            If the file is not a valid table of marks.
        """
        marks = read_marks(path)
        marking, unknown = self.marking.add_marks(marks, self.photos)
        self.change(tr("Import {file}", file=path.name), marking)
        return len(marks), unknown_photos(unknown) if unknown else None


def unknown_photos(photos: Sequence[str]) -> Finding:
    """Return the warning about marks in photos that the folder does not contain."""
    return Finding("marks.other-photos", photos=abbreviate_names(photos))
