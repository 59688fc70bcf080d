"""Project on disk: a folder NAME.vom that can be moved and zipped.

`journal.sqlite` is authoritative, and `project.gpkg` is derived from it. `models/` contains copies
of models if the user wants them, `reconstruction/` the results of photogrammetry, `assets/` data
that are too large for a journal row, and `photos/` exports for photos whose own folder is
read-only. `cache/` may be deleted. A project without a name is stored in the user's state folder
and offered again at the next start.
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
from vomstudio.core.files.regular import is_folder, is_regular_file, path_exists
from vomstudio.core.files.user_folders import state_folder
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.io.photos.cameras_file import FILE_NAME
from vomstudio.project import compaction
from vomstudio.project.assets import FOLDER as ASSETS
from vomstudio.project.assets import Assets
from vomstudio.project.comparisons import FOLDER as COMPARISONS
from vomstudio.project.imports.sidecar_import import PHOTO_TABLES
from vomstudio.project.journal.database import SqliteJournal, read_replay
from vomstudio.project.journal.failures import is_lost
from vomstudio.project.paths import JOURNAL_NAME, PROJECT_SUFFIX
from vomstudio.project.reconstructions import (
    RECONSTRUCTIONS,
    copy_reconstructions,
    move_reconstructions,
)
from vomstudio.project.records import Feature, Mask, Model, ReconstructionRecord
from vomstudio.project.repair import RepairResult, repair
from vomstudio.project.session import Session

MODELS = "models"
# Recreating the thumbnails of thousands of photos would take minutes.
_COPIED_FOLDERS = (MODELS, PHOTO_TABLES, ASSETS, COMPARISONS, "cache/thumbnails")


class ProjectFolder:
    """Open project with its folder, session and lock."""

    def __init__(
        self,
        folder: Path,
        journal: SqliteJournal,
        lock: ProjectLock | None,
        *,
        settings: Callable[[], Mapping[str, Any]] = dict,
    ) -> None:
        """Open the session, without a `lock` if the folder is not writable."""
        self.folder = folder
        self._lock = lock
        self._cache = folder / "cache" if lock is not None else _temporary_folder(folder / "cache")
        self._report_failure: Callable[[Finding | None], object] | None = None
        self.assets = Assets(lambda: self.folder, lambda: self.journal.is_in_place)
        self._use_journal(journal)
        self._settings = settings
        self.session = Session(journal, settings)
        self._compaction_result: compaction.CompactionResult | None = None
        self.problems: list[Finding] = list(self.session.problems)
        """Problems of journal rows that could not be read."""

    def _use_journal(self, journal: SqliteJournal) -> None:
        self.journal = journal
        if self._report_failure is not None:
            journal.buffer_unwritten_steps(
                self._report_failure, self._lock_again, self._write_dependencies
            )

    def buffer_unwritten_steps(self, report: Callable[[Finding | None], object]) -> None:
        """Keep unwritable steps in memory (see `SqliteJournal.buffer_unwritten_steps`).

        This is for programs that stay open and display this state. `report` is called immediately
        if nothing can be written.
        """
        self._report_failure = report
        self._use_journal(self.journal)
        self.assets.cache_all()
        self.session.changed.connect(self.assets.cache_edit)
        self.journal.try_writing()

    def _lock_again(self) -> None:
        """Lock the folder after it has reappeared. Raises InputError and TargetError."""
        lock = ProjectLock(self.folder / "lock")
        self._release()
        self._lock = lock

    def _write_dependencies(self) -> None:
        """Write the dependencies of a row: the lock, if not yet acquired, and referenced files.

        Raises VomError.
        """
        if self._lock is None:
            self._lock = ProjectLock(self.folder / "lock")
        self.assets.write_pending()

    def _release(self) -> None:
        if self._lock is not None:
            self._lock.release()

    @property
    def write_failure(self) -> Finding | None:
        """Reason why the next step cannot be written, or None if no reason is known."""
        return self.journal.write_failure()

    @property
    def _owns_folder(self) -> bool:
        """Whether the folder at the project's path still belongs to this project."""
        failure = self.write_failure
        return failure is None or not is_lost(failure)

    @classmethod
    def create(
        cls, folder: Path, *, settings: Callable[[], Mapping[str, Any]] = dict
    ) -> ProjectFolder:
        """Create a project in `folder`, which must not contain one. Raises TargetError."""
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise TargetError(
                Finding("folder.not-created", reason=failure_reason(folder.parent, error)),
                file=folder,
            ) from error
        if (folder / JOURNAL_NAME).exists():
            raise TargetError(Finding("project.exists"), file=folder)
        return cls._open_locked(folder, settings, create=True)

    @classmethod
    def open(
        cls,
        folder: Path,
        *,
        settings: Callable[[], Mapping[str, Any]] = dict,
        allow_unlocked: bool = False,
    ) -> ProjectFolder:
        """Open the project in a folder.

        Parameters
        ----------
        folder : Path
            Folder NAME.vom.
        settings : callable, optional
            Function that returns the settings of a new session.
        allow_unlocked : bool
            Whether to also open a project whose folder is not writable and therefore cannot be
            locked. This is for programs that keep unwritable steps in memory
            (`buffer_unwritten_steps`).

        Raises
        ------
        InputError
            If the folder is not a project, is damaged, was written by a newer version, or is open
            elsewhere.
        TargetError
            If the folder cannot be locked.
        """
        full_folder = project_folder(folder)
        return cls._open_locked(full_folder, settings, create=False, allow_unlocked=allow_unlocked)

    @classmethod
    def _open_locked(
        cls,
        folder: Path,
        settings: Callable[[], Mapping[str, Any]],
        *,
        create: bool,
        allow_unlocked: bool = False,
    ) -> ProjectFolder:
        """Open a project, and release the lock if the journal cannot be opened."""
        lock: ProjectLock | None = None
        try:
            lock = ProjectLock(folder / "lock")
        except TargetError:
            if not allow_unlocked:
                raise
        try:
            journal = SqliteJournal(folder / JOURNAL_NAME, is_new=create)
            return cls(folder, journal, lock, settings=settings)
        except BaseException:
            if lock is not None:
                lock.release()
            raise

    @property
    def name(self) -> str:
        return self.folder.name.removesuffix(PROJECT_SUFFIX)

    @property
    def is_untitled(self) -> bool:
        return self.folder.parent == untitled_folder()

    @property
    def cache(self) -> Path:
        """Cache folder, which may be deleted.

        For a read-only project, this is a temporary folder that is deleted on closing.
        """
        return self._cache

    def _delete_temporary_cache(self) -> None:
        if self._cache.parent != self.folder:
            shutil.rmtree(self._cache, ignore_errors=True)

    @property
    def has_reconstructions(self) -> bool:
        """Whether there are complete or partial reconstructions, possibly hours of work."""
        folder = self.folder / RECONSTRUCTIONS
        stages = folder.glob("*/work/*")
        return any(folder.glob(f"*/{FILE_NAME}")) or any(
            stage.is_dir() and stage.suffix != ".part" for stage in stages
        )

    @property
    def has_photo_tables(self) -> bool:
        return any(path.is_file() for path in (self.folder / PHOTO_TABLES).glob("*/*"))

    def compaction(self) -> compaction.CompactionPlan:
        """Return the rows and files that a compaction would remove."""
        return compaction.plan(self.folder, self.session, self.journal)

    @property
    def is_compacted(self) -> bool:
        """Whether there is a compaction that can be undone until the project is closed."""
        return self._compaction_result is not None

    def compact(self) -> None:
        """Remove unreachable rows and files, which `undo_compaction` can restore until closing.

        Raises DocumentError and TargetError.
        """
        compacted = compaction.compact(self.folder, self.session, self.journal)
        self._compaction_result = compacted

    def undo_compaction(self) -> None:
        """Undo the compaction. Raises DocumentError if the project has not been compacted."""
        if self._compaction_result is None:
            raise DocumentError(Finding("compaction.none"))
        compaction.undo_compaction(self.folder, self.session, self.journal, self._compaction_result)
        self._compaction_result = None

    def repair(self) -> RepairResult:
        """Rewrite a journal that has damaged rows. Raises DocumentError and TargetError."""
        result = repair(self.folder, self.session, self.journal)
        self.problems = []
        return result

    def save_as(self, folder: Path) -> list[Finding]:
        """Save the project in another folder, with its history and files, and continue there.

        A named project stays in its old folder as it was last saved; an untitled one is deleted
        there. If the old folder is gone or has been replaced, the state in memory is written, and
        findings report the missing files. No job may be running in the project folder. Raises
        TargetError.
        """
        if folder.exists() and not folder.is_dir():
            raise TargetError(Finding("output.exists"), file=folder)
        if folder.exists() and any(folder.iterdir()):
            raise TargetError(Finding("folder.not-empty"), file=folder)
        part = folder.with_name(folder.name + ".part")
        owns_folder, old_folder, is_untitled = self._owns_folder, self.folder, self.is_untitled
        is_failed = self.write_failure is not None
        try:
            shutil.rmtree(part, ignore_errors=True)
            part.mkdir(parents=True)
            seq_map = self._copy_journal(part / JOURNAL_NAME)
            is_moved = self._copy_files(part) if owns_folder else False
            self.assets.write(part)
            if folder.exists():
                folder.rmdir()
            part.rename(folder)
        except OSError as error:
            shutil.rmtree(part, ignore_errors=True)
            raise write_error(folder, error) from error
        except VomError as error:
            shutil.rmtree(part, ignore_errors=True)
            raise TargetError(cause_finding(error), file=folder) from error
        lock, journal = _open_saved(folder)
        was_modified = self.session.dirty
        old_journal = self.session.use_journal(journal, seq_map)
        if was_modified and not is_untitled and self.write_failure is None:
            old_session = Session(old_journal)
            old_session.discard_unsaved()
        old_journal.close()
        self._release()
        self._delete_temporary_cache()
        self.folder, self._lock, self._cache = folder, lock, folder / "cache"
        self._use_journal(journal)
        self.session.mark_saved()
        if self._report_failure is not None and is_failed:
            self._report_failure(None)
        if is_moved:
            move_reconstructions(old_folder, folder)
        if is_untitled and owns_folder:
            shutil.rmtree(old_folder, ignore_errors=True)
        return [] if owns_folder else self._report_missing_files()

    def _report_missing_files(self) -> list[Finding]:
        """Report the files that could not be copied from a missing or replaced folder."""
        folder = self.folder / RECONSTRUCTIONS
        missing_names = [
            *(m.name for m in self.session.of(Model) if self.find_model(m) is None),
            *(
                m.photo
                for m in self.session.of(Mask)
                if not is_regular_file(self.folder / m.file.path)
            ),
            *(
                reconstruction.name
                for reconstruction in self.session.of(ReconstructionRecord)
                if not is_folder(folder / reconstruction.folder)
            ),
        ]
        if not missing_names:
            return []
        return [Finding("project.files-left-behind", names=missing_names)]

    def _copy_journal(self, path: Path) -> Mapping[int, int] | None:
        """Write the history to a new file, and return the new row numbers or None if unchanged.

        Raises TargetError.
        """
        failure = self.write_failure
        if failure is None or failure.code != "journal.replaced":
            try:
                self.journal.copy_to(path)
                return None
            except TargetError:
                if failure is None:
                    raise
        # The file cannot be read or is a different file, so write all reachable steps from memory.
        return compaction.write_compacted_journal(path, self.session, None, self._settings())

    def _copy_files(self, part: Path) -> bool:
        """Copy the files next to the journal; return whether to move the reconstructions instead.

        Raises OSError.
        """
        for name in _COPIED_FOLDERS:
            if (self.folder / name).is_dir():
                shutil.copytree(self.folder / name, part / name, ignore=special_files)
        if self.is_untitled and _is_same_disk(self.folder, part):
            return True
        copy_reconstructions(self.folder, part)
        return False

    def close(self) -> None:
        """Close the project.

        An untitled project is deleted if it never contained features, reconstructions or marks in
        photos. Any other project keeps its history, from which discarded work can be restored.
        """
        session = self.session
        is_empty = not session.has_ever_contained(Feature) and not session.draft
        is_empty = is_empty and not self.has_reconstructions and not self.has_photo_tables
        is_disposable = self.is_untitled and is_empty
        owns_folder = self._owns_folder
        self.session.close()
        self.assets.close()
        if owns_folder:
            compaction.discard_backup(self.folder)
        self._release()
        self._delete_temporary_cache()
        if not owns_folder:
            return
        if is_disposable:
            shutil.rmtree(self.folder, ignore_errors=True)
        elif self.is_untitled:
            shutil.rmtree(self.cache, ignore_errors=True)

    def model_path(self, path: Path) -> str:
        """Return the path to store for a model, relative if it is inside the project folder."""
        resolved_path = path.resolve()
        if resolved_path.is_relative_to(self.folder.resolve()):
            return resolved_path.relative_to(self.folder.resolve()).as_posix()
        return str(resolved_path)

    def find_model(self, model: Model) -> Path | None:
        """Return the file of a model, or None if it is not found.

        The file is searched at its stored path, and by name in the project folder, in its `models`
        folder and next to the project (in case the project was moved together with its models).
        """
        stored_path = Path(model.path)
        positions = [self.folder / stored_path] if not stored_path.is_absolute() else [stored_path]
        positions += [
            self.folder / stored_path.name,
            self.folder / MODELS / stored_path.name,
            self.folder.parent / stored_path.name,
        ]
        return next((position for position in positions if is_regular_file(position)), None)


def _temporary_folder(fallback: Path) -> Path:
    """Create a temporary folder, or return `fallback` if that fails."""
    try:
        return Path(tempfile.mkdtemp(prefix="vomstudio-cache-"))
    except OSError:
        return fallback


def _open_saved(folder: Path) -> tuple[ProjectLock, SqliteJournal]:
    """Lock and open a new project and mark it as saved; delete it if this fails.

    Raises InputError and TargetError.
    """
    lock: ProjectLock | None = None
    journal: SqliteJournal | None = None
    try:
        lock = ProjectLock(folder / "lock")
        journal = SqliteJournal(folder / JOURNAL_NAME)
        journal.append("save")
        return lock, journal
    except VomError as error:
        if journal is not None:
            journal.close()
        if lock is not None:
            lock.release()
        shutil.rmtree(folder, ignore_errors=True)
        raise write_error(folder, error.__cause__ or error) from error


def _is_same_disk(first_path: Path, second_path: Path) -> bool:
    return first_path.stat().st_dev == second_path.stat().st_dev


def project_folder(path: Path) -> Path:
    """Return the project folder from its path or that of a file in it. Raises InputError."""
    if is_regular_file(path) and path.parent.suffix == PROJECT_SUFFIX:
        path = path.parent
    if not path_exists(path):
        raise InputError(Finding("project.missing"), file=path)
    if not is_regular_file(path / JOURNAL_NAME):
        raise InputError(
            Finding("project.not-a-project"),
            file=path,
        )
    return path


def untitled_folder() -> Path:
    """Return the folder that contains projects without a name."""
    return state_folder() / "untitled"


def create_untitled(settings: Callable[[], Mapping[str, Any]] = dict) -> ProjectFolder:
    """Create a project without a name in the folder of untitled projects."""
    time_text = time.strftime("%Y%m%d-%H%M%S")
    folder = untitled_folder() / f"{time_text}{PROJECT_SUFFIX}"
    suffix = 1
    while folder.exists():
        suffix += 1
        folder = untitled_folder() / f"{time_text}-{suffix}{PROJECT_SUFFIX}"
    return ProjectFolder.create(folder, settings=settings)


def is_free(folder: Path) -> bool:
    """Return whether a project exists and is not open in another window."""
    if not is_regular_file(folder / JOURNAL_NAME):
        return False
    try:
        ProjectLock(folder / "lock").release()
    except (InputError, TargetError):
        return False
    return True


def untitled_projects(*, finished: bool) -> list[Path]:
    """Return the untitled projects that are not open, newest first.

    Parameters
    ----------
    finished : bool
        True for projects whose changes were discarded on closing, False for projects left unsaved
        by a crash or power failure.
    """
    folders = []
    journals = untitled_folder().glob(f"*{PROJECT_SUFFIX}/{JOURNAL_NAME}")
    for folder in (
        journal.parent for journal in sorted(journals, key=_modification_time, reverse=True)
    ):
        if not is_free(folder):
            continue
        try:
            replay = read_replay(folder)
            is_finished = replay.top == replay.saved_top and replay.draft is None
        except InputError:
            # Opening the project reports the error; if the project were hidden, it would be lost.
            is_finished = False
        if is_finished == finished:
            folders.append(folder)
    return folders


def _modification_time(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0
