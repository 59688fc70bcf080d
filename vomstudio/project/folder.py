"""The project on disk: a folder NAME.vom that can be moved and zipped.

`journal.sqlite` is the truth; `project.gpkg` is derived; `models/` holds copies where the user
wants them, `reconstruction/` what was made of photos, `assets/` what is too large for a row of the
journal, `photos/` exports for photos whose own folder cannot be written; `cache/` may be
deleted. A project that has no name yet lives in the user's state folder and is offered back at the
next start.
"""

from __future__ import annotations

import shutil
import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from vomstudio.core.errors import DocumentError, InputError, TargetError, VomError
from vomstudio.core.files.containment import special_files
from vomstudio.core.files.disk_errors import failure_reason, write_error
from vomstudio.core.files.lock import ProjectLock
from vomstudio.core.files.regular import is_folder, is_regular, path_exists
from vomstudio.core.files.user_folders import state_folder
from vomstudio.core.findings import Finding, cause_of
from vomstudio.io.photos.cameras_file import FILE_NAME
from vomstudio.project import compaction
from vomstudio.project.assets import FOLDER as ASSETS
from vomstudio.project.assets import Assets
from vomstudio.project.comparisons import FOLDER as COMPARISONS
from vomstudio.project.imports.sidecar_import import PHOTO_TABLES
from vomstudio.project.journal.database import NAME as JOURNAL
from vomstudio.project.journal.database import SqliteJournal, read_replay
from vomstudio.project.journal.failures import is_lost
from vomstudio.project.reconstructions import (
    RECONSTRUCTIONS,
    copy_reconstructions,
    move_reconstructions,
)
from vomstudio.project.records import Feature, Mask, Model, Reconstruction
from vomstudio.project.repair import Repaired, repair
from vomstudio.project.session import Session

SUFFIX = ".vom"
MODELS = "models"
# Making the thumbnails of thousands of photos again would take minutes.
_ALONG = (MODELS, PHOTO_TABLES, ASSETS, COMPARISONS, "cache/thumbnails")


class Project:
    """An open project: its folder, its session, its lock."""

    def __init__(
        self,
        folder: Path,
        journal: SqliteJournal,
        lock: ProjectLock | None,
        *,
        settings: Callable[[], Mapping[str, Any]] = dict,
    ) -> None:
        """lock : None where the folder cannot be written"""
        self.folder = folder
        self._lock = lock
        self._cache = folder / "cache" if lock is not None else _passing_folder(folder / "cache")
        self._report_failure: Callable[[Finding | None], object] | None = None
        self.assets = Assets(lambda: self.folder, lambda: self.journal.is_in_place)
        self._take(journal)
        self._settings = settings
        self.session = Session(journal, settings)
        self._compacted: compaction.Compacted | None = None
        self.problems: list[Finding] = list(self.session.problems)
        """What could not be read."""

    def _take(self, journal: SqliteJournal) -> None:
        self.journal = journal
        if self._report_failure is not None:
            journal.wait_in_memory(self._report_failure, self._hold_again, self._write_first)

    def wait_in_memory(self, tell: Callable[[Finding | None], object]) -> None:
        """From now on steps that cannot be written wait in memory, as `SqliteJournal` has it; for
        programs that stay open, and say so. Where nothing can be written that is told at once."""
        self._report_failure = tell
        self._take(self.journal)
        self.assets.hold_all()
        self.session.changed.connect(self.assets.hold)
        self.journal.try_writing()

    def _hold_again(self) -> None:
        """The folder is back, with a lock file of its own. Raises InputError, TargetError."""
        lock = ProjectLock(self.folder / "lock")
        self._release()
        self._lock = lock

    def _write_first(self) -> None:
        """What must be there before a row is written: the lock, which a folder that could not be
        written has not taken, and the files that rows name. Raises VomError."""
        if self._lock is None:
            self._lock = ProjectLock(self.folder / "lock")
        self.assets.write_waiting()

    def _release(self) -> None:
        if self._lock is not None:
            self._lock.release()

    @property
    def write_failure(self) -> Finding | None:
        """Why the next step cannot be written, as far as that is known."""
        return self.journal.write_failure()

    @property
    def _is_there(self) -> bool:
        """The folder at the project's place is this project's."""
        failure = self.write_failure
        return failure is None or not is_lost(failure)

    @classmethod
    def create(cls, folder: Path, *, settings: Callable[[], Mapping[str, Any]] = dict) -> Project:
        """A new project in `folder`, which must not hold one. Raises TargetError."""
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise TargetError(
                Finding("folder.not-created", reason=failure_reason(folder.parent, error)),
                file=folder,
            ) from error
        if (folder / JOURNAL).exists():
            raise TargetError(Finding("project.exists"), file=folder)
        return cls._held(folder, settings, create=True)

    @classmethod
    def open(
        cls,
        folder: Path,
        *,
        settings: Callable[[], Mapping[str, Any]] = dict,
        without_lock: bool = False,
    ) -> Project:
        """without_lock : also where the folder cannot be written, and so cannot be locked: for
        programs that let steps wait in memory then (`wait_in_memory`). Raises InputError where it
        is no project, damaged, newer, or open elsewhere, TargetError where it cannot be locked."""
        whole = project_folder(folder)
        return cls._held(whole, settings, create=False, without_lock=without_lock)

    @classmethod
    def _held(
        cls,
        folder: Path,
        settings: Callable[[], Mapping[str, Any]],
        *,
        create: bool,
        without_lock: bool = False,
    ) -> Project:
        """The lock is given up again where the journal cannot be had."""
        lock: ProjectLock | None = None
        try:
            lock = ProjectLock(folder / "lock")
        except TargetError:
            if not without_lock:
                raise
        try:
            journal = SqliteJournal(folder / JOURNAL, create=create)
            return cls(folder, journal, lock, settings=settings)
        except BaseException:
            if lock is not None:
                lock.release()
            raise

    @property
    def name(self) -> str:
        return self.folder.name.removesuffix(SUFFIX)

    @property
    def untitled(self) -> bool:
        return self.folder.parent == untitled_folder()

    @property
    def cache(self) -> Path:
        """May be deleted; of a folder that cannot be written it lies elsewhere until it is
        closed."""
        return self._cache

    def _leave_cache(self) -> None:
        if self._cache.parent != self.folder:
            shutil.rmtree(self._cache, ignore_errors=True)

    @property
    def has_reconstructions(self) -> bool:
        """Hours of work may be in them, though nothing was measured yet."""
        made = self.folder / RECONSTRUCTIONS
        stages = made.glob("*/work/*")
        return any(made.glob(f"*/{FILE_NAME}")) or any(
            stage.is_dir() and stage.suffix != ".part" for stage in stages
        )

    @property
    def has_photo_tables(self) -> bool:
        return any(path.is_file() for path in (self.folder / PHOTO_TABLES).glob("*/*"))

    def compaction(self) -> compaction.Plan:
        """What compacting would take away."""
        return compaction.plan(self.folder, self.session, self.journal)

    @property
    def is_compacted(self) -> bool:
        """Since it was opened, so that it can be taken back."""
        return self._compacted is not None

    def compact(self) -> None:
        """Take away rows and files that nothing can reach any more; until the project is closed
        `take_back_compaction` brings them back. Raises DocumentError, TargetError."""
        made = compaction.compact(self.folder, self.session, self.journal)
        self._compacted = made

    def take_back_compaction(self) -> None:
        """Raises DocumentError where the project was not compacted since it was opened."""
        if self._compacted is None:
            raise DocumentError(Finding("compaction.none"))
        compaction.take_back(self.folder, self.session, self.journal, self._compacted)
        self._compacted = None

    def repair(self) -> Repaired:
        """Write a journal with damaged rows anew. Raises DocumentError, TargetError."""
        made = repair(self.folder, self.session, self.journal)
        self.problems = []
        return made

    def save_as(self, folder: Path) -> list[Finding]:
        """Move to another folder: history, copies and reconstructions go along.

        A project with a name stays behind as it was last saved; an untitled one is deleted. If the
        folder is gone or was replaced, what is in memory goes along, and findings report what does
        not. No job may be at work in its folder. Raises TargetError.
        """
        if folder.exists() and not folder.is_dir():
            raise TargetError(Finding("output.exists"), file=folder)
        if folder.exists() and any(folder.iterdir()):
            raise TargetError(Finding("folder.not-empty"), file=folder)
        part = folder.with_name(folder.name + ".part")
        there, left, untitled = self._is_there, self.folder, self.untitled
        failed = self.write_failure is not None
        try:
            shutil.rmtree(part, ignore_errors=True)
            part.mkdir(parents=True)
            numbers = self._copy_journal(part / JOURNAL)
            moves = self._copy_files(part) if there else False
            self.assets.write(part)
            if folder.exists():
                folder.rmdir()
            part.rename(folder)
        except OSError as error:
            shutil.rmtree(part, ignore_errors=True)
            raise write_error(folder, error) from error
        except VomError as error:
            shutil.rmtree(part, ignore_errors=True)
            raise TargetError(cause_of(error), file=folder) from error
        lock, journal = _taken_hold(folder)
        was_dirty = self.session.dirty
        old = self.session.use_journal(journal, numbers)
        if was_dirty and not untitled and self.write_failure is None:
            left_behind = Session(old)
            left_behind.discard_unsaved()
        old.close()
        self._release()
        self._leave_cache()
        self.folder, self._lock, self._cache = folder, lock, folder / "cache"
        self._take(journal)
        self.session.mark_saved()
        if self._report_failure is not None and failed:
            self._report_failure(None)
        if moves:
            move_reconstructions(left, folder)
        if untitled and there:
            shutil.rmtree(left, ignore_errors=True)
        return [] if there else self._left_behind()

    def _left_behind(self) -> list[Finding]:
        """Report what could not be copied from a folder that is gone or was replaced."""
        made = self.folder / RECONSTRUCTIONS
        missing = [
            *(m.name for m in self.session.of(Model) if self.find_model(m) is None),
            *(m.photo for m in self.session.of(Mask) if not is_regular(self.folder / m.file.path)),
            *(r.name for r in self.session.of(Reconstruction) if not is_folder(made / r.folder)),
        ]
        if not missing:
            return []
        return [Finding("project.files-left-behind", names=missing)]

    def _copy_journal(self, path: Path) -> Mapping[int, int] | None:
        """The history in a new file; the numbers of its rows by those of now where they differ.
        Raises TargetError."""
        failure = self.write_failure
        if failure is None or failure.code != "journal.replaced":
            try:
                self.journal.copy_to(path)
                return None
            except TargetError:
                if failure is None:
                    raise
        # What is at its place cannot be read, or is another: all that can be reached is known.
        return compaction.write_anew(path, self.session, None, self._settings())

    def _copy_files(self, part: Path) -> bool:
        """What lies beside the journal; whether the reconstructions are to be moved instead. Raises
        OSError."""
        for name in _ALONG:
            if (self.folder / name).is_dir():
                shutil.copytree(self.folder / name, part / name, ignore=special_files)
        if self.untitled and _same_disk(self.folder, part):
            return True
        copy_reconstructions(self.folder, part)
        return False

    def close(self) -> None:
        """An untitled project that never held a feature, a reconstruction or marks in photos leaves
        nothing behind; another one keeps its history, from which discarded work can be
        brought back."""
        session = self.session
        empty = not session.ever_held(Feature) and not session.draft
        empty = empty and not self.has_reconstructions and not self.has_photo_tables
        worthless = self.untitled and empty
        there = self._is_there
        self.session.close()
        self.assets.close()
        if there:
            compaction.forget(self.folder)
        self._release()
        self._leave_cache()
        if not there:
            return
        if worthless:
            shutil.rmtree(self.folder, ignore_errors=True)
        elif self.untitled:
            shutil.rmtree(self.cache, ignore_errors=True)

    def model_path(self, path: Path) -> str:
        """How the path of a model is written down: relative inside the folder, else absolute."""
        full = path.resolve()
        if full.is_relative_to(self.folder.resolve()):
            return full.relative_to(self.folder.resolve()).as_posix()
        return str(full)

    def find_model(self, model: Model) -> Path | None:
        """The file of a model: where it was, or of the same name in the folder, its `models`, or
        beside the folder (a project that was moved together with its models)."""
        stored = Path(model.path)
        places = [self.folder / stored] if not stored.is_absolute() else [stored]
        places += [
            self.folder / stored.name,
            self.folder / MODELS / stored.name,
            self.folder.parent / stored.name,
        ]
        return next((place for place in places if is_regular(place)), None)


def _passing_folder(otherwise: Path) -> Path:
    """Among the temporary files, while there is room for one."""
    try:
        return Path(tempfile.mkdtemp(prefix="vomstudio-cache-"))
    except OSError:
        return otherwise


def _taken_hold(folder: Path) -> tuple[ProjectLock, SqliteJournal]:
    """Of a project that was just made and is marked as saved; it goes again where that fails.
    Raises InputError, TargetError."""
    lock: ProjectLock | None = None
    journal: SqliteJournal | None = None
    try:
        lock = ProjectLock(folder / "lock")
        journal = SqliteJournal(folder / JOURNAL)
        journal.append("save")
        return lock, journal
    except VomError as error:
        if journal is not None:
            journal.close()
        if lock is not None:
            lock.release()
        shutil.rmtree(folder, ignore_errors=True)
        raise write_error(folder, error.__cause__ or error) from error


def _same_disk(one: Path, other: Path) -> bool:
    return one.stat().st_dev == other.stat().st_dev


def project_folder(path: Path) -> Path:
    """The folder of a project named by its folder or by a file in it. Raises InputError."""
    if is_regular(path) and path.parent.suffix == SUFFIX:
        path = path.parent
    if not path_exists(path):
        raise InputError(Finding("project.missing"), file=path)
    if not is_regular(path / JOURNAL):
        raise InputError(
            Finding("project.not-a-project"),
            file=path,
        )
    return path


def is_project(path: Path) -> bool:
    return is_regular(path / JOURNAL) or (is_regular(path) and path.parent.suffix == SUFFIX)


def untitled_folder() -> Path:
    """Where projects without a name live."""
    return state_folder() / "untitled"


def create_untitled(settings: Callable[[], Mapping[str, Any]] = dict) -> Project:
    stamp = time.strftime("%Y%m%d-%H%M%S")
    folder = untitled_folder() / f"{stamp}{SUFFIX}"
    number = 1
    while folder.exists():
        number += 1
        folder = untitled_folder() / f"{stamp}-{number}{SUFFIX}"
    return Project.create(folder, settings=settings)


def is_free(folder: Path) -> bool:
    """A project that is there and that no window holds."""
    if not is_regular(folder / JOURNAL):
        return False
    try:
        ProjectLock(folder / "lock").release()
    except (InputError, TargetError):
        return False
    return True


def untitled_projects(*, finished: bool) -> list[Path]:
    """Untitled projects that no window holds, the newest first: those whose changes were discarded
    on closing (finished), or those that a crash or a power cut has left behind."""
    found = []
    journals = untitled_folder().glob(f"*{SUFFIX}/{JOURNAL}")
    for folder in (j.parent for j in sorted(journals, key=_time_of, reverse=True)):
        if not is_free(folder):
            continue
        try:
            kept = read_replay(folder)
            done = kept.top == kept.saved_top and kept.draft is None
        except InputError:
            # Opening it says what is wrong; hiding it would lose it.
            done = False
        if done == finished:
            found.append(folder)
    return found


def _time_of(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0
