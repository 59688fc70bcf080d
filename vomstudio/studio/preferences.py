"""User settings, which are saved while the program runs."""

from __future__ import annotations

from pathlib import Path

from vomstudio.core.errors import VomError
from vomstudio.core.signals import Signal
from vomstudio.io.settings import Settings, SettingsFile
from vomstudio.studio.notices import Notices
from vomstudio.studio.owner_thread import FIRST_PICTURE_DELAY_S, Post, TimerFactory


class Preferences:
    """User settings; `keep` emits `changed`, and `remember` emits `recent_changed`."""

    def __init__(
        self, settings: Settings, notices: Notices, post: Post, later: TimerFactory
    ) -> None:
        self.changed: Signal[()] = Signal()
        self.recent_changed: Signal[()] = Signal()
        self.settings = settings
        self._notices = notices
        self._file = SettingsFile(settings, lambda error: post(lambda: notices.warn(error)))
        self._recent_timer = later(FIRST_PICTURE_DELAY_S, self._write_soon)

    def keep(self) -> None:
        """Write the settings to their file now."""
        self._recent_timer.stop()
        try:
            self._file.write(self.settings)
        except VomError as error:
            self._notices.warn(error)
        self.changed.emit()

    def remember(self, path: Path) -> None:
        """Add a path to the list of recent files."""
        self.settings.add_recent_project(path.resolve())
        self.recent_changed.emit()
        self._recent_timer.start()

    def remember_results(self, folder: Path) -> None:
        """Save the folder in which a result is written, for later projects."""
        if str(folder) != self.settings.results_folder:
            self.settings.results_folder = str(folder)
            self._write_soon()

    def store_window(self, window: dict[str, str]) -> None:
        """Save the position and panels of the window soon, so that they survive a crash."""
        if window != self.settings.window:
            self.settings.window = window
            self._write_soon()

    def mark_open(self, folder: Path, is_open: bool) -> None:
        """Record whether a project is open, so that it is offered after a crash."""
        name = str(folder.resolve())
        other_paths = [path for path in self.settings.unclosed if path != name]
        unclosed_paths = [*other_paths, name] if is_open else other_paths
        if unclosed_paths != self.settings.unclosed:
            self.settings.unclosed = unclosed_paths
            self._write_soon()

    def _write_soon(self) -> None:
        self._recent_timer.stop()
        self._file.write_soon(self.settings)
