"""Export of points, marks and masks to files beside the photos.

The command line and other programs use these files, which mirror the records of the project.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
from PySide6.QtCore import QObject, QTimer, Signal

from vomstudio.core.errors import InputError, TargetError, VomError
from vomstudio.core.files.backup import back_up
from vomstudio.core.files.containment import make_folder
from vomstudio.core.files.disk_errors import write_error
from vomstudio.core.files.regular import is_regular_file, open_regular_file
from vomstudio.core.findings import Finding
from vomstudio.io.control.points import CONTROL, MARKS
from vomstudio.io.photos.drawn_masks import load_mask, mask_path, store_mask
from vomstudio.photogrammetry.georeferencing.mark_prediction import ControlMarks
from vomstudio.project.imports.sidecar_import import SidecarData, fallback_folder, read_sidecars
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.panels.photos.photo_document import PhotoDocument
from vomstudio.ui.panels.photos.photo_row import PhotoRow

_WRITE_DELAY_MS = 300


class PhotoExports(QObject):
    """Exporter that keeps the files beside the photos consistent with the records.

    Attributes
    ----------
    message : Signal
        Emitted with a message for the user and its level.
    tables_written : Signal
        Emitted when control.csv or marks.csv has been written.
    mask_written : Signal
        Emitted with the name of a photo and the file of its mask, or None if it has no mask.
    problem : Finding or None
        Reason why the files are not up to date, or None if they are.
    foreign_files : list of str
        Names of the files beside the photos that other programs have changed.
    """

    message = Signal(object, str)
    tables_written = Signal()
    mask_written = Signal(str, object)

    def __init__(self, document: PhotoDocument) -> None:
        super().__init__()
        self._document = document
        self._background = QtBackground(self)
        self._disk_marking = ControlMarks()
        self._external_marking: ControlMarks | None = None
        self._hashes: dict[str, str] = {}
        """SHA-256 of each file, by name, when it was last imported or written.

        Files with a different hash are backed up before they are replaced.
        """
        self.foreign_files: list[str] = []
        self._mask_paths: dict[str, Path] = {}
        self._rows: dict[str, PhotoRow] = {}
        self._sidecar_masks: dict[str, Path] = {}
        self._pending_photos: dict[str, None] = {}
        self._task: _OneTimeTask | None = None
        self._write_lock = Lock()
        self.problem: Finding | None = None
        document.points_changed.connect(self._points_changed)
        document.masks_changed.connect(self._masks_changed)
        self._timer = QTimer(self, singleShot=True, interval=_WRITE_DELAY_MS)
        self._timer.timeout.connect(self._write_next_mask)

    def begin(
        self, rows: Sequence[PhotoRow], *, is_external: bool, sidecars: SidecarData | None = None
    ) -> None:
        """Begin to export the records of the imported photos.

        Parameters
        ----------
        rows : sequence of PhotoRow
        is_external : bool
            Whether the points were imported from files in other folders. Those files are never
            written, so the first change writes all tables beside the photos.
        sidecars : SidecarData, optional
            Data of the files beside the photos, if they have just been imported.
        """
        self._rows = {row.name: row for row in rows}
        paths = [Path(row.path) for row in rows]
        self._mask_paths = {row.name: mask_path(Path(row.path), paths) for row in rows}
        self._sidecar_masks = {row.name: Path(row.sidecar_mask) for row in rows if row.sidecar_mask}
        self._pending_photos.clear()
        self.problem = None
        marking = self._document.marking()
        self._external_marking = marking if is_external else None
        self._disk_marking = ControlMarks() if is_external else marking
        self._hashes = self._document.export_hashes()
        if sidecars is None:
            self.foreign_files = self._find_foreign_files()
        else:
            self._store_sidecar_hashes(sidecars.unread_files)

    def _find_foreign_files(self) -> list[str]:
        """Return the names of files that have changed since they were imported or written."""
        files = self._document.masks()
        names = self._find_foreign_tables()
        for row in self._rows.values():
            file = files.get(row.name)
            known_hashes = {
                self._hashes.get(_hash_key(row.sidecar_mask)),
                "" if file is None else Path(file.path).stem,
            }
            if row.sidecar_mask and row.found_sha256 not in known_hashes:
                names.append(Path(row.sidecar_mask).name)
        return names

    def _find_foreign_tables(self) -> list[str]:
        """Return the names of tables whose contents differ from the records."""
        tables = {name: self.table(name) for name in (CONTROL, MARKS)}
        names = [
            name
            for name, path in tables.items()
            if path is not None and _hash_file(path) != self._hashes.get(name)
        ]
        if not names:
            return []
        project_folder, photos = self._document.project_folder, list(self._rows)
        sidecars = read_sidecars(project_folder, tables[CONTROL], tables[MARKS], {}, photos)
        points, marks = self._document.states()
        photo_set = self._document.photo_set
        matches = {
            CONTROL: set(sidecars.points) == {p for p in points if p.position is not None}
            and sidecars.crs == ("" if photo_set is None else photo_set.crs),
            MARKS: sidecars.pixels == marks,
        }
        for name in [item for item in names if matches[item] and item not in sidecars.unread_files]:
            self._hashes[name] = _hash_file(tables[name])
            names.remove(name)
        return names

    def _store_sidecar_hashes(self, unread_names: Sequence[str]) -> None:
        """Store the hashes of the imported files, except for tables that cannot be read."""
        for name in {CONTROL, MARKS} - set(unread_names):
            self._hashes[name] = _hash_file(self.table(name))
        for row in self._rows.values():
            if row.sidecar_mask:
                self._hashes[_hash_key(row.sidecar_mask)] = row.found_sha256
        self._document.set_export_hashes(self._hashes)
        self.foreign_files = []

    def end(self) -> None:
        """Write pending files before other photos are opened."""
        self.finish()
        self._rows, self._mask_paths, self._sidecar_masks = {}, {}, {}

    # --- tables ------------------------------------------------------------------------------
    @property
    def _folders(self) -> tuple[Path, ...]:
        folder = self._document.folder
        if folder is None:
            return ()
        return folder, fallback_folder(self._document.project_folder, folder.resolve())

    def table(self, name: str) -> Path | None:
        """Return the file of a table, beside the photos or else in the project; None if missing."""
        paths = (folder / name for folder in self._folders)
        return next((path for path in paths if is_regular_file(path)), None)

    def _points_changed(self) -> None:
        if not self._rows or not self._document.is_imported:
            return
        marking = self._document.marking()
        if marking == self._external_marking or _is_same(marking, self._disk_marking):
            return
        self._external_marking = None
        try:
            if marking.control != self._disk_marking.control:
                self._write_table(CONTROL, marking)
            if marking.marks != self._disk_marking.marks:
                self._write_table(MARKS, marking)
            self._disk_marking, self.problem = marking, None
        except TargetError as error:
            self.problem = Finding("points.tables-outdated", reason=error, reason_code=error.code)
            self.message.emit(self.problem, "warning")
        self.tables_written.emit()

    def _write_table(self, name: str, marking: ControlMarks) -> None:
        """Write a table beside the photos or, if that is not possible, in the project.

        Raises TargetError.
        """
        folder, fallback = self._folders
        target = self.table(name) or folder / name
        try:
            self._write_file(target, marking)
        except TargetError as error:
            if target.parent == fallback:
                raise
            try:
                make_folder(fallback)
                self._write_file(fallback / name, marking)
            except (OSError, TargetError):
                raise error from None
            self.message.emit(
                Finding("points.table-in-project", table=name, folder=str(fallback)), "warning"
            )

    def _write_file(self, path: Path, marking: ControlMarks) -> None:
        from vomstudio.io.control.writing import write_control, write_marks

        backup = None
        try:
            if path.exists() and _hash_file(path) != self._hashes.get(path.name):
                # Another program has changed the file since it was read.
                backup = back_up(path)
                path.unlink()
            photo_set = self._document.photo_set
            if path.name == CONTROL:
                crs = None if photo_set is None else photo_set.crs or None
                backup = write_control(path, marking.control, crs) or backup
            else:
                backup = write_marks(path, marking.marks) or backup
        except OSError as error:
            raise write_error(path, error) from error
        self._hashes[path.name] = _hash_file(path)
        self._document.set_export_hashes(self._hashes)
        if backup is not None:
            self.message.emit(
                Finding("points.former-table", table=path.name, copy=backup.name), "info"
            )

    # --- masks -------------------------------------------------------------------------------
    def _masks_changed(self, photos: frozenset[str]) -> None:
        self._pending_photos |= dict.fromkeys(sorted(photos & self._rows.keys()))
        self._timer.start()

    @property
    def is_busy(self) -> bool:
        """Whether any masks still have to be written."""
        return self._task is not None or bool(self._pending_photos)

    def _write_next_mask(self) -> None:
        if self._task is not None or not self._pending_photos:
            return
        name = next(iter(self._pending_photos))
        del self._pending_photos[name]
        task = _OneTimeTask(name, self._mask_job(name))
        self._task = task

        def finish(result: object) -> None:
            if self._task is task:
                self._task = None
                self._finish_mask(name, result)
            self._write_next_mask()

        self._background.run(task.result, finish)

    def _mask_job(self, name: str) -> Callable[[], object]:
        row, target, sidecar = (
            self._rows[name],
            self._mask_paths[name],
            self._sidecar_masks.get(name),
        )
        find_mask = self._document.mask_path

        def write() -> object:
            # The last task to run writes the newest mask.
            with self._write_lock:
                try:
                    mask = find_mask(name)
                    used_tables = (
                        np.ones((row.height, row.width), np.bool_)
                        if mask is None
                        else load_mask(mask, row.width, row.height)
                    )
                    return store_mask(target, used_tables, sidecar)
                except VomError as error:
                    return error

        return write

    def _finish_mask(self, name: str, result: Any) -> None:
        if isinstance(result, VomError):
            problem = Finding("mask.files-outdated", reason=result)
            if problem != self.problem:
                self.message.emit(problem, "warning")
            self.problem = problem
            return
        path, backup = result
        self.problem = None
        self._hashes[_hash_key(str(self._mask_paths[name]))] = _hash_file(path)
        self._document.set_export_hashes(self._hashes)
        if backup is not None:
            self.message.emit(Finding("mask.former-file", copy=backup.name), "info")
        self.mask_written.emit(name, path)

    def finish(self) -> None:
        """Write all pending masks immediately."""
        self._timer.stop()
        if (task := self._task) is not None:
            # Its hash belongs to this project; the next project may have other photos.
            self._task = None
            self._finish_mask(task.name, task.result())
        for name in list(self._pending_photos):
            del self._pending_photos[name]
            self._finish_mask(name, self._mask_job(name)())

    def close(self) -> None:
        self.finish()
        self._background.stop()


class _OneTimeTask:
    """Task that runs only once, in a worker thread or in the first thread that needs it."""

    def __init__(self, name: str, work: Callable[[], object]) -> None:
        self.name = name
        self._work: Callable[[], object] | None = work
        self._result: object = None
        self._lock = Lock()

    def result(self) -> object:
        """Run the task unless it has already run, and return its result."""
        with self._lock:
            if self._work is not None:
                self._result, self._work = self._work(), None
            return self._result


def _hash_key(path: str | None) -> str:
    """Return the hash key of a mask: its file name, which is usually unique in a folder."""
    return "" if path is None else Path(path).name


def _is_same(first: ControlMarks, second: ControlMarks) -> bool:
    return (first.control, first.marks) == (second.control, second.marks)


def _hash_file(path: Path | None) -> str:
    """Return the SHA-256 of a file, or an empty string if it is missing or unreadable."""
    try:
        if path is None:
            return ""
        with open_regular_file(path) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except (InputError, OSError):
        return ""
