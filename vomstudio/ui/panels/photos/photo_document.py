"""Records of a photo set: points, marks and masks.

Each change is an edit in the history of the project. The tables and masks beside the photos are
exports of these records (`photo_exports`).
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
from vomstudio.photogrammetry.georeferencing.mark_prediction import ControlMarks
from vomstudio.project.edit import Edit
from vomstudio.project.imports.sidecar_import import stored_path
from vomstudio.project.photo_edits import (
    PointState,
    get_masks,
    marks_of,
    photo_sets,
    points_of,
    set_masks,
    set_points,
)
from vomstudio.project.records import Asset, ImageMark, MarkedPoint, Mask, PhotoSet, Record
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.photos.photo_row import PhotoRow

_MAX_MERGE_DELAY_S = 1.5
_RECORD_TYPES = (PhotoSet, MarkedPoint, ImageMark, Mask)


class PhotoDocument(QObject):
    """Records of a folder of photos.

    Attributes
    ----------
    points_changed : Signal
        Emitted when points or marks of these photos have changed.
    masks_changed : Signal
        Emitted with a frozenset of the names of photos whose masks have changed; it is empty if
        only the folder of the project has changed.
    """

    points_changed = Signal()
    masks_changed = Signal(object)

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self.folder: Path | None = None
        self._last_edit: tuple[object, int, float] | None = None
        self._masks: dict[str, Asset] = {}
        self._project_folder: Path | None = None
        studio.edited.connect(self._follow_edit)
        studio.history_changed.connect(self._follow_project)

    def set_folder(self, folder: Path | None) -> None:
        """Show the records of a folder, or no records if no folder is given."""
        self.folder = folder
        self._last_edit = None
        self._masks = self.masks()
        self.points_changed.emit()

    # --- state -------------------------------------------------------------------------------
    @property
    def photo_set(self) -> PhotoSet | None:
        """Record of the folder, or None before the folder is imported."""
        if self.folder is None:
            return None
        path = stored_path(self._studio.project.folder, self.folder)
        return next((s for s in photo_sets(self._studio.records) if s.path == path), None)

    def last_folder(self) -> Path | None:
        """Return the most recently added photo folder that still exists, or None."""
        sets = reversed(list(photo_sets(self._studio.records)))
        return next((f for item in sets if (f := self.find_folder(item)) is not None), None)

    def find_folder(self, photo_set: PhotoSet) -> Path | None:
        """Return the folder of a photo set, or None if the folder is missing."""
        project_folder = self._studio.project.folder
        # The project may have been moved together with its photos.
        paths = (project_folder / photo_set.path, project_folder.parent / Path(photo_set.path).name)
        return next((path for path in paths if is_folder(path)), None)

    def find_moved_set(self) -> PhotoSet | None:
        """Return the photo set whose missing folder has the name of this folder.

        The result is None if this folder already has a photo set, or unless exactly one set
        matches.
        """
        if self.folder is None or self.photo_set is not None:
            return None
        project_folder = self._studio.project.folder
        sets = [
            s for s in photo_sets(self._studio.records) if Path(s.path).name == self.folder.name
        ]
        missing_sets = [s for s in sets if not is_folder(project_folder / s.path)]
        return missing_sets[0] if len(missing_sets) == 1 else None

    @property
    def is_imported(self) -> bool:
        return self.photo_set is not None

    def marking(self) -> ControlMarks:
        """Return the points and marks in the records."""
        photo_set = self.photo_set
        if photo_set is None:
            return ControlMarks()
        records = self._studio.records
        points = points_of(records, photo_set.id)
        marks = marks_of(records, photo_set.id)
        marked_ids = {point.id for point, _ in marks}
        return ControlMarks(
            tuple(
                ControlPoint(p.label, p.position, p.sigma_m, p.check)
                for p in points
                if p.position is not None
            ),
            tuple(Mark(point.label, mark.photo, mark.x, mark.y) for point, mark in marks),
            tuple(p.label for p in points if p.position is None and p.id not in marked_ids),
        )

    def masks(self) -> dict[str, Asset]:
        """Return the mask files by photo name."""
        photo_set = self.photo_set
        if photo_set is None:
            return {}
        return {name: m.file for name, m in get_masks(self._studio.records, photo_set.id).items()}

    def mask_path(self, photo: str) -> Path | None:
        """Return the path of a photo's mask, or None if the photo has no mask.

        Raises InputError if the file is missing.
        """
        file = self._masks.get(photo)
        return None if file is None else self._studio.project.assets.path(file)

    def states(self) -> tuple[list[PointState], dict[tuple[str, str], tuple[float, float]]]:
        """Return the points and marks in the form that edits require.

        Returns
        -------
        list of PointState
            Control points and labels without coordinates.
        dict
            Pixel (x, y) of each mark, by point label and photo name.
        """
        return _states(self.marking())

    @property
    def project_folder(self) -> Path:
        return self._studio.project.folder

    def _follow_project(self) -> None:
        """Emit `masks_changed` if the project has been saved in another folder."""
        if self._project_folder != self._studio.project.folder:
            self._project_folder = self._studio.project.folder
            self.masks_changed.emit(frozenset())

    def fill_mask_paths(self, rows: Sequence[PhotoRow]) -> None:
        """Set the paths of the mask and the thumbnail in each row."""
        thumbnails = self._studio.project.cache / "thumbnails"
        for row in rows:
            if row.thumbnail is not None:
                row.thumbnail = str(thumbnails / Path(row.thumbnail).name)
            with contextlib.suppress(VomError):
                path = self.mask_path(row.name)
                row.mask = None if path is None else str(path)

    def export_hashes(self) -> dict[str, str]:
        """Return the SHA-256 hashes of the files beside the photos, as last imported or written."""
        photo_set = self.photo_set
        hashes = (
            {}
            if photo_set is None
            else self._studio.project.journal.view(f"exports {photo_set.id}", {})
        )
        return dict(hashes) if isinstance(hashes, dict) else {}

    def set_export_hashes(self, hashes: Mapping[str, str]) -> None:
        if (photo_set := self.photo_set) is not None:
            self._studio.project.journal.set_view(f"exports {photo_set.id}", dict(hashes))

    # --- edits -------------------------------------------------------------------------------
    def set_marking(
        self, title: str, marking: ControlMarks, merge_key: object = None, crs: str | None = None
    ) -> bool:
        """Set points and marks as one edit.

        Parameters
        ----------
        title : str
            Title of the edit.
        marking : ControlMarks
        merge_key : object, optional
            Consecutive edits with equal `merge_key` are merged into one.
        crs : str, optional
            CRS of the control points.

        Returns
        -------
        bool
            Whether the edit was applied.
        """
        points, marks = _states(marking)

        def build_edit(records: Mapping[str, Record], set_id: str) -> Edit:
            return set_points(records, set_id, points, marks, title, crs=crs)

        return self._apply(build_edit, merge_key)

    def store_mask(self, png: bytes) -> Asset:
        """Store a mask and return its file. Thread-safe. Raises TargetError."""
        return self._studio.project.assets.store(png, ".png")

    def set_masks(self, title: str, masks: Mapping[str, Asset | None]) -> bool:
        return self._apply(lambda records, set_id: set_masks(records, set_id, masks, title), None)

    def _apply(
        self, build_edit: Callable[[Mapping[str, Record], str], Edit], merge_key: object
    ) -> bool:
        photo_set = self.photo_set
        if photo_set is None:
            return False
        last_edit, current_time = self._last_edit, time.monotonic()
        joins = None
        if last_edit is not None and merge_key is not None and last_edit[0] == merge_key:
            joins = last_edit[1] if current_time - last_edit[2] < _MAX_MERGE_DELAY_S else None
        try:
            edit = build_edit(self._studio.records, photo_set.id)
            if not edit.after:
                return True
            number = self._studio.session.apply(edit, joins=joins)
        except VomError as error:
            self._studio.fail(error)
            return False
        self._last_edit = None if merge_key is None else (merge_key, number, current_time)
        return True

    # --- history -----------------------------------------------------------------------------
    # Undo in a photo does not change an unfinished trace on the outcrop.
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

    def _follow_edit(self, edit: Edit) -> None:
        records = [r for id_ in edit.ids for r in (edit.before[id_], edit.after[id_])]
        if not any(isinstance(r, _RECORD_TYPES) for r in records):
            return
        masks = self.masks()
        changed_photos = {n for n in {*masks, *self._masks} if masks.get(n) != self._masks.get(n)}
        self._masks = masks
        if any(isinstance(r, PhotoSet | MarkedPoint | ImageMark) for r in records):
            self.points_changed.emit()
        if changed_photos:
            self.masks_changed.emit(frozenset(changed_photos))


def _states(
    marking: ControlMarks,
) -> tuple[list[PointState], dict[tuple[str, str], tuple[float, float]]]:
    points = [PointState(p.label, p.position, p.sigma_m, p.check) for p in marking.control]
    points += [PointState(label) for label in marking.labels if marking.point(label) is None]
    return points, {(m.label, m.photo): (m.x, m.y) for m in marking.marks}


def edited_photo(edit: Edit) -> str:
    """Return the photo in which an edit of marks or masks is visible, or an empty string."""
    for id_ in edit.ids:
        record = edit.after[id_] or edit.before[id_]
        if isinstance(record, ImageMark | Mask):
            return record.photo
    return ""
