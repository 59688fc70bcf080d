"""The points that are marked in a folder of photos: kept as tables beside them as they change."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PySide6.QtCore import QObject, Signal

from vomstudio.errors import InputError, TargetError, VomError
from vomstudio.files.backup import set_aside
from vomstudio.io.control.control_files import crs_of, read_control, read_marks
from vomstudio.io.control.points import CONTROL, MARKS
from vomstudio.io.control.writing import write_control, write_marks
from vomstudio.photogrammetry.place.mark_prediction import (
    NOTHING,
    Marking,
    PlacedPhotos,
    Sight,
    missing,
)
from vomstudio.ui.photos.edit_history import EditHistory, Step

Array = npt.NDArray[np.float64]


class MarkFiles:
    """Where the tables of a folder of photos are: beside them, or else in `spare`, a folder of the
    project, for photos whose folder cannot be written. As long as there are none, what `control`
    and `marks` hold is taken over, which are never written: the files that the model is placed by.
    """

    def __init__(
        self,
        photos: Path,
        spare: Callable[[], Path],
        control: Path | None = None,
        marks: Path | None = None,
    ) -> None:
        self.photos, self._spare = photos, spare
        self._given = {CONTROL: control, MARKS: marks}

    @property
    def spare(self) -> Path:
        """A project that is saved under another name takes it along."""
        return self._spare()

    @property
    def own(self) -> bool:
        return any(self.found(name) for name in (CONTROL, MARKS))

    def to_read(self, name: str) -> Path | None:
        return self.found(name) if self.own else self._given[name]

    def found(self, name: str) -> Path | None:
        for folder in (self.photos, self.spare):
            if (folder / name).is_file():
                return folder / name
        return None


class PhotoMarks(QObject):
    """changed : points, marks, or cameras. said : a sentence for the user, and its level."""

    changed = Signal()
    said = Signal(str, str)

    def __init__(self, files: MarkFiles, photos: Sequence[str], history: EditHistory) -> None:
        super().__init__()
        self.files, self.photos, self._history = files, photos, history
        self.marking = Marking()
        self.crs: str | None = None
        """Of the control points, "EPSG:n", where their file states it."""
        self.unsaved = ""
        """Why the last change is not on the disk."""
        self._cameras: PlacedPhotos | None = None
        self._sights: dict[str, tuple[object, Sight]] = {}
        self._missing: list[str] | None = None
        self._damaged: set[str] = set()
        self._on_disk = Marking()
        self._taken_over: Marking | None = None

    # --- reading -----------------------------------------------------------------------------
    def read(self) -> None:
        """Take what the tables hold; of one that cannot be read nothing is lost."""
        made = Marking()
        own = self.files.own
        for name in (CONTROL, MARKS):
            path = self.files.to_read(name)
            if path is None:
                continue
            try:
                if name == CONTROL:
                    points, self.crs = read_control(path), crs_of(path)
                    made = Marking(tuple(points))
                else:
                    made, strangers = made.with_marks(read_marks(path), self.photos)
                    if strangers:
                        self.said.emit(_not_there(strangers), "warning")
            except VomError as error:
                self._damaged.add(name)
                self.said.emit(
                    self.tr("{0} (it is put aside when something is marked anew)").format(error),
                    "warning",
                )
        self.marking = made
        # What was taken over is written as a whole, and with the first change only.
        self._on_disk = made if own else Marking()
        self._taken_over = None if own else made
        self._renew()

    def set_cameras(self, cameras: PlacedPhotos | None) -> None:
        self._cameras = cameras
        self._sights.clear()
        self._renew()

    def _renew(self) -> None:
        self._missing = None
        self.changed.emit()

    # --- looking -----------------------------------------------------------------------------
    @property
    def cameras(self) -> PlacedPhotos | None:
        return self._cameras

    def sight(self, label: str) -> Sight:
        if self._cameras is None:
            return NOTHING
        marking = self.marking
        own = tuple(marking.of(label).items())
        # What is not marked twice is found by the other points.
        rest = marking if marking.point(label) is not None else None
        kept = self._sights.get(label)
        if kept is None or kept[0] != (own, rest):
            kept = (own, rest), self._cameras.sight(marking, label)
            self._sights[label] = kept
        return kept[1]

    def course(self, label: str, photo: str) -> Array:
        """(k, 2) where in a photo a point must lie that is marked in one other photo."""
        if self._cameras is None or not label:
            return np.zeros((0, 2))
        return self._cameras.course(self.marking, label, photo)

    def missing(self) -> list[str]:
        if self._missing is None:
            self._missing = missing(self.marking, self._cameras)
        return self._missing

    # --- changing ----------------------------------------------------------------------------
    def change(
        self, words: str, photo: str, made: Marking, join: object = None, *, goes_on: bool = False
    ) -> None:
        """Take another state of the points, which can be taken back; it is written at once, unless
        a drag goes on."""
        if made != self.marking:
            before = self.marking

            def swap() -> None:
                nonlocal before
                before, now = self.marking, before
                self._set(now)
                self._write()

            self._history.add(Step(words, photo, swap, join))
            self._set(made)
        if not goes_on:
            self._write()

    def import_points(self, path: Path) -> int:
        """Take the points of a table, in place of those with the same label. Raises InputError."""
        points, crs = read_control(path), crs_of(path)
        if self.marking.control and None not in (crs, self.crs) and crs != self.crs:
            raise InputError(
                f"is in {crs}, the points that are here are in {self.crs}: bring them into one CRS",
                file=path,
            )
        self.crs = crs or self.crs
        made = self.marking
        for point in points:
            made = made.placed(point)
        self.change(self.tr("Import {0}").format(path.name), "", made)
        return len(points)

    def import_marks(self, path: Path) -> tuple[int, str]:
        """Take the marks of a table, in place of those of the same point and photo; how many, and
        what is remarkable. Raises InputError."""
        marks = read_marks(path)
        made, strangers = self.marking.with_marks(marks, self.photos)
        self.change(self.tr("Import {0}").format(path.name), "", made)
        return len(marks), _not_there(strangers) if strangers else ""

    def _set(self, made: Marking) -> None:
        self.marking = made
        self._renew()

    # --- writing -----------------------------------------------------------------------------
    def _write(self) -> None:
        """What is not on the disk as it is here."""
        now, there = self.marking, self._on_disk
        if now == self._taken_over:
            return
        self._taken_over = None
        try:
            if now.control != there.control:
                self._write_one(CONTROL)
                self._on_disk = replace(self._on_disk, control=now.control)
            if now.marks != there.marks:
                self._write_one(MARKS)
                self._on_disk = replace(self._on_disk, marks=now.marks)
            self.unsaved = ""
        except TargetError as error:
            self.unsaved = str(error)
            self.said.emit(
                self.tr("The marks are not saved: {0} They are tried again with every change.")
                .format(error), "error",
            )  # fmt: skip

    def save_again(self) -> bool:
        """Try once more; whether all is on the disk."""
        self._write()
        return not self.unsaved

    def _write_one(self, name: str) -> None:
        """Raises TargetError."""
        there = self.files.found(name)
        place = self.files.photos / name if there is None else there
        try:
            self._write_to(place)
        except TargetError as error:
            if place.parent == self.files.spare:
                raise
            try:
                self.files.spare.mkdir(parents=True, exist_ok=True)
                self._write_to(self.files.spare / name)
            except (OSError, TargetError):
                raise error from None
            self.said.emit(
                self.tr(
                    "The photos' folder cannot be written: {0} is kept in the project, {1}"
                ).format(name, self.files.spare),
                "warning",
            )

    def _write_to(self, path: Path) -> None:
        kept = None
        try:
            if path.name in self._damaged and path.exists():
                kept = set_aside(path)
                path.unlink()
                self._damaged.discard(path.name)
            if path.name == CONTROL:
                kept = write_control(path, self.marking.control, self.crs) or kept
            else:
                kept = write_marks(path, self.marking.marks) or kept
        except OSError as error:
            raise TargetError(f"it cannot be written ({error.strerror}).", file=path) from error
        if kept is not None:
            self.said.emit(
                self.tr("{0} held more than is kept here; it was put aside as {1}").format(
                    path.name, kept.name
                ),
                "info",
            )


def _not_there(photos: Sequence[str]) -> str:
    shown = ", ".join(photos[:3]) + (f" and {len(photos) - 3} more" if len(photos) > 3 else "")
    return f"Marks in photos that are not here are kept: {shown}"
