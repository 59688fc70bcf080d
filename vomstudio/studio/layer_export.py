"""Export of a project's GIS layers by a worker process while the user is idle."""

from __future__ import annotations

import contextlib
from pathlib import Path

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.signals import Signal
from vomstudio.core.words import tr
from vomstudio.studio.jobs.events import Failed
from vomstudio.studio.jobs.job import Lane
from vomstudio.studio.jobs.layer_tasks import WRITE_LAYERS, LayersRequest
from vomstudio.studio.notices import Notices
from vomstudio.studio.owner_thread import TimerFactory
from vomstudio.studio.projects import Projects
from vomstudio.studio.running_jobs import Jobs

LAYERS = "project.gpkg"
IDLE_TIME_S = 2.0
RETRY_DELAY_S = 30.0
FINISH_TIMEOUT_S = 10.0


def update_layers(folder: Path, has_features: bool) -> list[Finding]:
    """Write the layers of a project now, or delete them if it has no features.

    Returns findings about failures.
    """
    if not has_features:
        remove_layers(folder)
        return []
    from vomstudio.project.exports.export import export_project

    try:
        export_project(folder, "gpkg", folder / LAYERS, writes_map=False, force=True)
    except VomError as error:
        return [Finding("project.layers-outdated", reason=error, reason_code=error.code)]
    return []


def remove_layers(folder: Path) -> None:
    """Delete the layers, because outdated layers would be misleading."""
    with contextlib.suppress(OSError):
        (folder / LAYERS).unlink(missing_ok=True)


class GisLayers:
    """GIS layers of a project; `written` emits the file, or "" if an update failed."""

    def __init__(
        self, projects: Projects, jobs: Jobs, notices: Notices, later: TimerFactory
    ) -> None:
        self.written: Signal[str] = Signal()
        self._projects, self._jobs, self._notices = projects, jobs, notices
        self._timer = later(IDLE_TIME_S, self.write)

    def write_soon(self) -> None:
        """Schedule an update of the layers at the next pause in editing."""
        if not self._projects.project.is_untitled:
            self._timer.start()

    def write_pending(self) -> None:
        """Start to write the layers now if an update is scheduled."""
        if self._timer.is_active:
            self.write()

    def finish(self) -> None:
        """Wait until the layers are written, for at most `FINISH_TIMEOUT_S`."""
        self._jobs.finish(Lane.FILES, FINISH_TIMEOUT_S)

    def write(self) -> None:
        """Start a job that writes the layers, or delete them if the project has no features."""
        self._timer.stop()
        if self._projects.project.is_untitled or not self._projects.is_written:
            return
        folder = self._projects.project.folder
        path = folder / LAYERS
        if not self._projects.session.features():
            remove_layers(folder)
            return

        def handle_failure(event: Failed) -> None:
            self.written.emit("")
            self._notices.warn(
                Finding(
                    "project.layers-outdated",
                    reason=event.message,
                    reason_code=event.to_error().code,
                )
            )
            self._timer.start(RETRY_DELAY_S)

        self._jobs.submit(
            WRITE_LAYERS,
            LayersRequest(folder),
            title=tr("Writing GIS layers"),
            on_done=lambda _: self.written.emit(str(path)),
            on_failed=handle_failure,
            is_quiet=True,
        )
