"""Tables of points and marks, and masks, written beside the photos for the command line and other
programs. The records of the project are the truth; these files follow them."""

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
from vomstudio.core.files.regular import is_regular, open_regular
from vomstudio.core.findings import Finding
from vomstudio.io.control.points import CONTROL, MARKS
from vomstudio.io.photos.drawn_masks import load_mask, mask_path, store_mask
from vomstudio.photogrammetry.georeferencing.mark_prediction import Marking
from vomstudio.project.imports.sidecar_import import SidecarData, fallback_folder, read_sidecars
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.panels.photos.photo_document import PhotoDocument
from vomstudio.ui.panels.photos.photo_row import PhotoRow

_SOON_MS = 300


class PhotoExports(QObject):
    """Keeps the files beside the photos as the records are.

    message : a sentence for the user, and its level. tables_written : control.csv or marks.csv has
    been written; mask_written : the name of a photo, and the file of its mask or None
    """

    message = Signal(object, str)
    tables_written = Signal()
    mask_written = Signal(str, object)

    def __init__(self, document: PhotoDocument) -> None:
        super().__init__()
        self._document = document
        self._background = QtBackground(self)
        self._on_disk = Marking()
        self._given: Marking | None = None
        self._known: dict[str, str] = {}
        """The SHA-256 of the files as they were last taken in or written, by their names: others
        are somebody else's, and put aside before they are replaced."""
        self.foreign: list[str] = []
        self._places: dict[str, Path] = {}
        self._rows: dict[str, PhotoRow] = {}
        self._found: dict[str, Path] = {}
        self._waiting: dict[str, None] = {}
        self._writing: _OnceDone | None = None
        self._one_at_a_time = Lock()
        self.problem: Finding | None = None
        """Why the files beside the photos are not up to date; None if they are."""
        document.points_changed.connect(self._points_changed)
        document.masks_changed.connect(self._masks_changed)
        self._soon = QTimer(self)
        self._soon.setSingleShot(True)
        self._soon.setInterval(_SOON_MS)
        self._soon.timeout.connect(self._next_mask)

    def begin(
        self, rows: Sequence[PhotoRow], *, given: bool, just_read: SidecarData | None = None
    ) -> None:
        """The photos are taken in: from now on their files follow the records. given: the points
        came from files elsewhere, which are never written; with the first change all are written.
        just_read: what lies beside the photos, where it has been taken in now"""
        self._rows = {row.name: row for row in rows}
        paths = [Path(row.path) for row in rows]
        self._places = {row.name: mask_path(Path(row.path), paths) for row in rows}
        self._found = {row.name: Path(row.found_mask) for row in rows if row.found_mask}
        self._waiting.clear()
        self.problem = None
        now = self._document.marking()
        self._given = now if given else None
        self._on_disk = Marking() if given else now
        self._known = self._document.written()
        if just_read is None:
            self.foreign = self._foreign()
        else:
            self._seen(just_read.unread)

    def _foreign(self) -> list[str]:
        """Names of files beside the photos that are neither what was taken in nor what was written
        here: another program, or a person, has changed them since."""
        files = self._document.masks()
        names = self._foreign_tables()
        for row in self._rows.values():
            file = files.get(row.name)
            own = {
                self._known.get(_key(row.found_mask)),
                "" if file is None else Path(file.path).stem,
            }
            if row.found_mask and row.found_sha256 not in own:
                names.append(Path(row.found_mask).name)
        return names

    def _foreign_tables(self) -> list[str]:
        """Names of tables whose content differs from the records, whoever wrote them."""
        tables = {name: self.table(name) for name in (CONTROL, MARKS)}
        others = [
            name
            for name, path in tables.items()
            if path is not None and _sum(path) != self._known.get(name)
        ]
        if not others:
            return []
        home, photos = self._document.project_folder, list(self._rows)
        there = read_sidecars(home, tables[CONTROL], tables[MARKS], {}, photos)
        points, marks = self._document.states()
        own = self._document.photo_set
        same = {
            CONTROL: set(there.points) == {p for p in points if p.position is not None}
            and there.crs == ("" if own is None else own.crs),
            MARKS: there.pixels == marks,
        }
        for name in [each for each in others if same[each] and each not in there.unread]:
            self._known[name] = _sum(tables[name])
            others.remove(name)
        return others

    def _seen(self, unread: Sequence[str]) -> None:
        """What lies beside the photos now was taken in, but for tables that cannot be read."""
        for name in {CONTROL, MARKS} - set(unread):
            self._known[name] = _sum(self.table(name))
        for row in self._rows.values():
            if row.found_mask:
                self._known[_key(row.found_mask)] = row.found_sha256
        self._document.set_written(self._known)
        self.foreign = []

    def end(self) -> None:
        """Other photos are looked at: what waits is written first."""
        self.finish()
        self._rows, self._places, self._found = {}, {}, {}

    # --- tables ------------------------------------------------------------------------------
    @property
    def _folders(self) -> tuple[Path, ...]:
        folder = self._document.folder
        if folder is None:
            return ()
        return folder, fallback_folder(self._document.project_folder, folder.resolve())

    def table(self, name: str) -> Path | None:
        """Where a table is: beside the photos, or in the project where that cannot be written."""
        places = (folder / name for folder in self._folders)
        return next((path for path in places if is_regular(path)), None)

    def _points_changed(self) -> None:
        if not self._rows or not self._document.taken_in:
            return
        now = self._document.marking()
        if now == self._given or _same(now, self._on_disk):
            return
        self._given = None
        try:
            if now.control != self._on_disk.control:
                self._write_one(CONTROL, now)
            if now.marks != self._on_disk.marks:
                self._write_one(MARKS, now)
            self._on_disk, self.problem = now, None
        except TargetError as error:
            self.problem = Finding("points.tables-outdated", reason=error, reason_code=error.code)
            self.message.emit(self.problem, "warning")
        self.tables_written.emit()

    def _write_one(self, name: str, now: Marking) -> None:
        """Raises TargetError."""
        beside, spare = self._folders
        place = self.table(name) or beside / name
        try:
            self._write_to(place, now)
        except TargetError as error:
            if place.parent == spare:
                raise
            try:
                make_folder(spare)
                self._write_to(spare / name, now)
            except (OSError, TargetError):
                raise error from None
            self.message.emit(
                Finding("points.table-in-project", table=name, folder=str(spare)), "warning"
            )

    def _write_to(self, path: Path, now: Marking) -> None:
        from vomstudio.io.control.writing import write_control, write_marks

        kept = None
        try:
            if path.exists() and _sum(path) != self._known.get(path.name):
                # Somebody else has changed it since it was read here.
                kept = back_up(path)
                path.unlink()
            found = self._document.photo_set
            if path.name == CONTROL:
                crs = None if found is None else found.crs or None
                kept = write_control(path, now.control, crs) or kept
            else:
                kept = write_marks(path, now.marks) or kept
        except OSError as error:
            raise write_error(path, error) from error
        self._known[path.name] = _sum(path)
        self._document.set_written(self._known)
        if kept is not None:
            self.message.emit(
                Finding("points.former-table", table=path.name, copy=kept.name), "info"
            )

    # --- masks -------------------------------------------------------------------------------
    def _masks_changed(self, photos: frozenset[str]) -> None:
        self._waiting |= dict.fromkeys(sorted(photos & self._rows.keys()))
        self._soon.start()

    @property
    def busy(self) -> bool:
        """Masks wait to be written."""
        return self._writing is not None or bool(self._waiting)

    def _next_mask(self) -> None:
        if self._writing is not None or not self._waiting:
            return
        name = next(iter(self._waiting))
        del self._waiting[name]
        task = _OnceDone(name, self._work(name))
        self._writing = task

        def arrived(made: object) -> None:
            if self._writing is task:
                self._writing = None
                self._written(name, made)
            self._next_mask()

        self._background.run(task.result, arrived)

    def _work(self, name: str) -> Callable[[], object]:
        row, place, found = self._rows[name], self._places[name], self._found.get(name)
        path = self._document.mask_path

        def work() -> object:
            # Whoever comes last writes what is newest then.
            with self._one_at_a_time:
                try:
                    mask = path(name)
                    used = (
                        np.ones((row.height, row.width), np.bool_)
                        if mask is None
                        else load_mask(mask, row.width, row.height)
                    )
                    return store_mask(place, used, found)
                except VomError as error:
                    return error

        return work

    def _written(self, name: str, made: Any) -> None:
        if isinstance(made, VomError):
            outdated = Finding("mask.files-outdated", reason=made)
            if outdated != self.problem:
                self.message.emit(outdated, "warning")
            self.problem = outdated
            return
        path, kept = made
        self.problem = None
        self._known[_key(str(self._places[name]))] = _sum(path)
        self._document.set_written(self._known)
        if kept is not None:
            self.message.emit(Finding("mask.former-file", copy=kept.name), "info")
        self.mask_written.emit(name, path)

    def finish(self) -> None:
        """Write what waits, at once."""
        self._soon.stop()
        if (task := self._writing) is not None:
            # Its result must be noted in this project: the next one may have other photos.
            self._writing = None
            self._written(task.name, task.result())
        for name in list(self._waiting):
            del self._waiting[name]
            self._written(name, self._work(name)())

    def close(self) -> None:
        self.finish()
        self._background.stop()


class _OnceDone:
    """Work that is done once, by a thread or by a caller that cannot wait for the thread."""

    def __init__(self, name: str, work: Callable[[], object]) -> None:
        self.name = name
        self._work: Callable[[], object] | None = work
        self._made: object = None
        self._lock = Lock()

    def result(self) -> object:
        """Do the work, or return what it gave."""
        with self._lock:
            if self._work is not None:
                self._made, self._work = self._work(), None
            return self._made


def _key(path: str | None) -> str:
    """Under which the sum of a mask is kept: names differ within a folder of photos, and in its
    folders too as a rule."""
    return "" if path is None else Path(path).name


def _same(one: Marking, other: Marking) -> bool:
    return (one.control, one.marks) == (other.control, other.marks)


def _sum(path: Path | None) -> str:
    """Of a file; "" for none."""
    try:
        if path is None:
            return ""
        with open_regular(path) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except (InputError, OSError):
        return ""
