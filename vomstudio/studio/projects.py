"""Creation, opening, saving and closing of projects."""

from __future__ import annotations

from collections.abc import Collection
from contextlib import ExitStack
from pathlib import Path
from typing import Any, TypeVar

from vomstudio.core.files.regular import is_regular_file
from vomstudio.core.files.user_folders import is_home_writable
from vomstudio.core.findings import Finding
from vomstudio.core.signals import Signal
from vomstudio.project.edit import Edit
from vomstudio.project.folder import ProjectFolder, create_untitled, is_free, untitled_projects
from vomstudio.project.garbage_collection import pause_collection
from vomstudio.project.journal.failures import is_lost
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.paths import JOURNAL_NAME
from vomstudio.project.record_map import RecordMap
from vomstudio.project.session import Session
from vomstudio.studio.notices import SAVE_AS, Notice, Notices
from vomstudio.studio.owner_thread import BlockingRunner, run_immediately
from vomstudio.studio.preferences import Preferences

T = TypeVar("T")
LARGE_JOURNAL_BYTES = 1_000_000
"""Journal size above which reading takes several tenths of a second."""


class Projects:
    """Owner of the open project, which can be replaced by another one.

    Attributes
    ----------
    leaving : Signal
        Emitted before the open project is closed.
    opened : Signal
        Emitted when another project has replaced it.
    edited, history_changed : Signal
        Forwarded signals of the open project.
    saved : Signal
        Emitted after the project has been saved, even under another name.
    """

    def __init__(
        self,
        preferences: Preferences,
        notices: Notices,
        run_blocking: BlockingRunner = run_immediately,
    ) -> None:
        self.leaving: Signal[()] = Signal()
        self.opened: Signal[()] = Signal()
        self.edited: Signal[Edit] = Signal()
        self.history_changed: Signal[()] = Signal()
        self.saved: Signal[()] = Signal()
        self.measurements: Measurements | None = None
        """Measurements of a project that has just been opened, or None if they are not
        computed."""
        self._preferences, self._notices, self._run_blocking = preferences, notices, run_blocking
        self._is_opening = False
        self._project: ProjectFolder | None = None
        self._has_warned = False

    # --- access -------------------------------------------------------------------------------
    @property
    def is_open(self) -> bool:
        """Whether a project is open."""
        return self._project is not None

    @property
    def project(self) -> ProjectFolder:
        """Open project. Raises RuntimeError before the first project is opened."""
        if self._project is None:
            raise RuntimeError("no project is open yet")
        return self._project

    @property
    def session(self) -> Session:
        """Session of the open project."""
        return self.project.session

    @property
    def records(self) -> RecordMap:
        """Records of the open project, keyed by id."""
        return self.session.records

    def of(self, cls: type[T]) -> list[T]:
        """Return the records of one class, in the order of their creation."""
        return self.session.of(cls)

    def get_name(self, id_: str) -> str:
        """Return the name of a record, or its id if it has no name or is missing."""
        return getattr(self.records.get(id_), "name", id_)

    def view(self, key: str, default: Any = None) -> Any:
        """Return a value of the view state that is stored with the project."""
        journal = self.project.journal
        return journal.view(key, default)

    def store_view(self, key: str, value: Any) -> None:
        """Store a value of the view state with the project."""
        journal = self.project.journal
        journal.set_view(key, value)

    # --- opening and closing ------------------------------------------------------------------
    def new(self) -> None:
        """Create an untitled project and open it."""
        self._adopt(create_untitled(self._preferences.settings.recorded_settings))
        if not self._has_warned and not is_home_writable():
            self._has_warned = True
            self._notices.warn(
                Finding("project.home-not-writable", folder=self.project.folder.parent)
            )

    def open(self, folder: Path) -> None:
        """Open a project. If it raises a VomError, the present project stays open."""
        current_project = self._project
        if current_project is not None and folder.resolve() == current_project.folder.resolve():
            return
        if self._is_opening:
            self._notices.warn(Finding("project.opening"))
            return
        self._is_opening = True
        try:
            project, measurements = self._read_folder(folder)
        finally:
            self._is_opening = False
        self._adopt(project, measurements)
        if not self.project.is_untitled:
            self._preferences.remember(self.project.folder)

    def _read_folder(self, folder: Path) -> tuple[ProjectFolder, Measurements | None]:
        journal = folder / JOURNAL_NAME
        if not is_regular_file(journal) or journal.stat().st_size < LARGE_JOURNAL_BYTES:
            return self._lock(folder), None
        read: list[tuple[ProjectFolder, Measurements]] = []

        def work() -> None:
            project = self._lock(folder)
            try:
                measurements = Measurements(self._preferences.settings.thresholds)
                measurements.of(project.session.records, [f.id for f in project.session.features()])
            except BaseException:
                # Otherwise the lock would remain until the program ends.
                project.close()
                raise
            read.append((project, measurements))

        def work_without_gc() -> None:
            with pause_collection(is_long_lived=True):
                work()

        self._run_blocking(work_without_gc)
        return read[0]

    def _lock(self, folder: Path) -> ProjectFolder:
        settings = self._preferences.settings
        return ProjectFolder.open(folder, settings=settings.recorded_settings, allow_unlocked=True)

    def unclosed(self, excluded_folders: Collection[Path] = ()) -> list[Path]:
        """Return the projects that a crash left open, except those in `excluded_folders`."""
        unclosed_paths = [Path(path) for path in self._preferences.settings.unclosed]
        folders = (*(f for f in unclosed_paths if is_free(f)), *untitled_projects(finished=False))
        excluded_paths = {path.resolve() for path in (self.project.folder, *excluded_folders)}
        return [
            f for f in folders if not excluded_paths & {f.resolve(), f.resolve() / JOURNAL_NAME}
        ]

    def _adopt(self, project: ProjectFolder, measurements: Measurements | None = None) -> None:
        if self._project is not None:
            self.leave()
        self._project, self.measurements = project, measurements
        project.buffer_unwritten_steps(self._report_failure)
        project.session.changed.connect(self.edited.emit)
        project.session.history_changed.connect(lambda _: self.history_changed.emit())
        self._mark_open(True)
        self.opened.emit()

    def leave(self) -> None:
        """Close the project despite errors, so that another window can open it."""
        with ExitStack() as steps:
            steps.callback(self.project.close)
            steps.callback(self.leaving.emit)
            steps.callback(self._mark_open, False)

    def _mark_open(self, is_open: bool) -> None:
        project = self.project
        self._preferences.mark_open(project.folder, is_open and not project.is_untitled)

    # --- write errors -------------------------------------------------------------------------
    def _report_failure(self, failure: Finding | None) -> None:
        if failure is None:
            self._notices.post(Notice(Finding("project.on-disk-again"), "warning"))
            return
        finding = Finding(
            "project.steps-in-memory",
            file=self.project.folder,
            reason=failure.message,
            reason_code=failure.code,
        )
        self._notices.post(Notice(finding, "error", SAVE_AS))

    @property
    def is_written(self) -> bool:
        """Whether all steps are on disk and the next step can be written."""
        return self.project.write_failure is None

    @property
    def is_complete_on_disk(self) -> bool:
        """Whether all steps are on disk in the original folder."""
        failure = self.project.write_failure
        return failure is None or not (is_lost(failure) or self.project.journal.has_pending_rows)

    # --- saving -------------------------------------------------------------------------------
    def save(self) -> None:
        """Mark the present state as saved. Raises VomError."""
        self.session.save()
        self.saved.emit()
        self._notices.info(Finding("project.saved", project=self.project.name))

    def save_as(self, folder: Path) -> None:
        """Save under another name. Raises TargetError."""
        self._mark_open(False)
        try:
            skipped_files = self.project.save_as(folder)
        finally:
            self._mark_open(True)
        self._preferences.remember(folder)
        # The records are the same, so the views need not be rebuilt.
        self.history_changed.emit()
        self.saved.emit()
        self._notices.info(Finding("project.saved-as", folder=folder))
        for finding in skipped_files:
            self._notices.warn(finding)

    def discard(self) -> None:
        """Undo all unsaved changes, which stay in the history. Raises VomError.

        Does nothing while the project cannot be written.
        """
        # If this cannot be written, the changes remain unsaved and are restored at the next
        # start.
        if self.session.dirty and self.is_written:
            self.session.discard_unsaved()

    @property
    def unsaved_reconstructions(self) -> bool:
        """Whether the project is untitled and contains reconstructions."""
        return self.project.is_untitled and self.project.has_reconstructions
