"""The photos that are looked at, as the document holds them: points, marks and masks are records.

Whatever changes them is an edit of the one history of the program; tables and masks beside the
photos are exports (`photo_exports`).
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from vomstudio.core.errors import VomError
from vomstudio.core.files.regular import is_folder
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.photogrammetry.georeferencing.mark_prediction import Marking
from vomstudio.project.edit import Edit
from vomstudio.project.imports.sidecar_import import stored_path
from vomstudio.project.photo_edits import (
    PointState,
    marks_of,
    masks_of,
    photo_sets,
    points_of,
    set_masks,
    set_points,
)
from vomstudio.project.records import Asset, ImageMark, MarkedPoint, Mask, PhotoSet, Record
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.photos.photo_row import PhotoRow

_TOGETHER_S = 1.5
_OWN = (PhotoSet, MarkedPoint, ImageMark, Mask)


class PhotoDocument(QObject):
    """The records of one folder of photos.

    points_changed : points or marks of these photos; masks_changed : a frozenset of the names of
    photos whose mask has changed, an empty one where only the project has moved
    """

    points_changed = Signal()
    masks_changed = Signal(object)

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self.folder: Path | None = None
        self._last: tuple[object, int, float] | None = None
        self._masks: dict[str, Asset] = {}
        self._home: Path | None = None
        studio.edited.connect(self._edited)
        studio.history_changed.connect(self._follow_project)

    def look_at(self, folder: Path | None) -> None:
        """From now on show the records of this folder; None for none."""
        self.folder = folder
        self._last = None
        self._masks = self.masks()
        self.points_changed.emit()

    # --- looking -----------------------------------------------------------------------------
    @property
    def photo_set(self) -> PhotoSet | None:
        """The record of the folder; None as long as it was not taken in."""
        if self.folder is None:
            return None
        stored = stored_path(self._studio.project.folder, self.folder)
        return next((s for s in photo_sets(self._studio.records) if s.path == stored), None)

    def last_folder(self) -> Path | None:
        """The photos that were added last, where they are to be found."""
        sets = reversed(list(photo_sets(self._studio.records)))
        return next((f for each in sets if (f := self.folder_of(each)) is not None), None)

    def folder_of(self, photo_set: PhotoSet) -> Path | None:
        """Where a set of photos is to be found; None where it is gone."""
        home = self._studio.project.folder
        # A project may have been moved together with its photos.
        places = (home / photo_set.path, home.parent / photo_set.name)
        return next((place for place in places if is_folder(place)), None)

    def moved_from(self) -> PhotoSet | None:
        """The record of a folder of this name that is not where it was: it is this one, moved."""
        if self.folder is None or self.photo_set is not None:
            return None
        home = self._studio.project.folder
        sets = [s for s in photo_sets(self._studio.records) if s.name == self.folder.name]
        gone = [s for s in sets if not is_folder(home / s.path)]
        return gone[0] if len(gone) == 1 else None

    @property
    def taken_in(self) -> bool:
        return self.photo_set is not None

    def marking(self) -> Marking:
        """Points and marks as the records say."""
        found = self.photo_set
        if found is None:
            return Marking()
        records = self._studio.records
        points = points_of(records, found.id)
        marks = marks_of(records, found.id)
        marked = {point.id for point, _ in marks}
        return Marking(
            tuple(
                ControlPoint(p.label, p.position, p.sigma_m, p.check)
                for p in points
                if p.position is not None
            ),
            tuple(Mark(point.label, mark.photo, mark.x, mark.y) for point, mark in marks),
            tuple(p.label for p in points if p.position is None and p.id not in marked),
        )

    def masks(self) -> dict[str, Asset]:
        """The file of each photo's mask, by the name of the photo."""
        found = self.photo_set
        if found is None:
            return {}
        return {name: m.file for name, m in masks_of(self._studio.records, found.id).items()}

    def mask_path(self, photo: str) -> Path | None:
        """Where a photo's mask is. Raises InputError where it is gone."""
        file = self._masks.get(photo)
        return None if file is None else self._studio.project.assets.path(file)

    def states(self) -> tuple[list[PointState], dict[tuple[str, str], tuple[float, float]]]:
        """Points and marks as edits take them."""
        return _states(self.marking())

    @property
    def project_folder(self) -> Path:
        return self._studio.project.folder

    def _follow_project(self) -> None:
        """A project that is saved elsewhere takes its files along."""
        if self._home != self._studio.project.folder:
            self._home = self._studio.project.folder
            self.masks_changed.emit(frozenset())

    def give_masks(self, rows: Sequence[PhotoRow]) -> None:
        """Enter into each row where its mask and thumbnail are."""
        thumbnails = self._studio.project.cache / "thumbnails"
        for row in rows:
            if row.thumbnail is not None:
                row.thumbnail = str(thumbnails / Path(row.thumbnail).name)
            with contextlib.suppress(VomError):
                path = self.mask_path(row.name)
                row.mask = None if path is None else str(path)

    def written(self) -> dict[str, str]:
        """The SHA-256 of files beside the photos as they were last taken in or written."""
        found = self.photo_set
        kept = {} if found is None else self._studio.project.journal.view(f"exports {found.id}", {})
        return dict(kept) if isinstance(kept, dict) else {}

    def set_written(self, sums: Mapping[str, str]) -> None:
        if (found := self.photo_set) is not None:
            self._studio.project.journal.set_view(f"exports {found.id}", dict(sums))

    # --- changing ----------------------------------------------------------------------------
    def set_marking(
        self, words: str, made: Marking, join: object = None, crs: str | None = None
    ) -> bool:
        """Give the photos these points and marks, as one step of the history; steps that follow
        each other at once under the same `join` are one."""
        points, marks = _states(made)

        def make(records: Mapping[str, Record], set_id: str) -> Edit:
            return set_points(records, set_id, points, marks, words, crs=crs)

        return self._apply(make, join)

    def store_mask(self, png: bytes) -> Asset:
        """The file of a mask, for `set_masks`; from any thread. Raises TargetError."""
        return self._studio.project.assets.store(png, ".png")

    def set_masks(self, words: str, masks: Mapping[str, Asset | None]) -> bool:
        return self._apply(lambda records, set_id: set_masks(records, set_id, masks, words), None)

    def _apply(self, make: Callable[[Mapping[str, Record], str], Edit], join: object) -> bool:
        found = self.photo_set
        if found is None:
            return False
        last, now = self._last, time.monotonic()
        joins = None
        if last is not None and join is not None and last[0] == join:
            joins = last[1] if now - last[2] < _TOGETHER_S else None
        try:
            edit = make(self._studio.records, found.id)
            if not edit.after:
                return True
            number = self._studio.session.apply(edit, joins=joins)
        except VomError as error:
            self._studio.fail(error)
            return False
        self._last = None if join is None else (join, number, now)
        return True

    # --- one history -------------------------------------------------------------------------
    # A trace that is unfinished on the outcrop is not seen here, and stays as it is.
    @property
    def undo_label(self) -> str | None:
        return self._studio.session.undo_label

    @property
    def redo_label(self) -> str | None:
        return self._studio.session.redo_label

    def undo(self) -> None:
        self._studio.undo_edit()

    def redo(self) -> None:
        self._studio.redo_edit()

    def _edited(self, edit: Edit) -> None:
        changed = [r for id_ in edit.ids for r in (edit.before[id_], edit.after[id_])]
        if not any(isinstance(r, _OWN) for r in changed):
            return
        masks = self.masks()
        other = {n for n in {*masks, *self._masks} if masks.get(n) != self._masks.get(n)}
        self._masks = masks
        if any(isinstance(r, PhotoSet | MarkedPoint | ImageMark) for r in changed):
            self.points_changed.emit()
        if other:
            self.masks_changed.emit(frozenset(other))


def _states(
    made: Marking,
) -> tuple[list[PointState], dict[tuple[str, str], tuple[float, float]]]:
    points = [PointState(p.label, p.position, p.sigma_m, p.check) for p in made.control]
    points += [PointState(label) for label in made.labels if made.point(label) is None]
    return points, {(m.label, m.photo): (m.x, m.y) for m in made.marks}


def photo_of(edit: Edit) -> str:
    """The photo in which an edit of marks or masks is to be seen; "" where it is in none."""
    for id_ in edit.ids:
        record = edit.after[id_] or edit.before[id_]
        if isinstance(record, ImageMark | Mask):
            return record.photo
    return ""
