"""Commands of the Photos panel: survey planning, photos, video frames and reconstruction."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QFileDialog, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.folder import SUFFIX, is_project
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.command_targets import start_folder
from vomstudio.ui.base.open_dialogs import OpenDialogs
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_protocols import Docks
from vomstudio.ui.panels.photos.photo_survey import PhotoSurvey

_DOCK = "photos"
# Five photos with their thumbnails.
_HEIGHT = 320


def commands(
    studio: Studio,
    survey: PhotoSurvey,
    show: SurveyDialogs,
    open_folder: Callable[[Path], None],
    has_place: Callable[[str], bool],
) -> list[Command]:
    """open_folder : called with the folder of photos that was chosen. has_place : whether a model
    of the photos in a folder of this name can be made in the project, which asks for its place
    where it has none"""

    def choose() -> None:
        name = QFileDialog.getExistingDirectory(
            show.parent,
            tr("Choose a folder of photos"),
            start_folder(studio),
            QFileDialog.Option.ShowDirsOnly,
        )
        if name:
            open_folder(Path(name))

    def make() -> None:
        # Hours of work must not come to lie where the user never looks.
        if survey.folder is not None and has_place(survey.folder.name):
            survey.make()

    def nothing_to_make() -> Finding | None:
        if survey.making is not None:
            return Finding("action.reconstruction-running")
        return None if survey.rows else Finding("action.no-photos")

    return [
        Command(
            "choose_photos",
            tr("New model from &photos…"),
            choose,
            "image-multiple-outline",
            "Ctrl+Shift+I",
            tr("Open a folder of photos, check the survey, and reconstruct."),
        ),
        Command(
            "plan_survey",
            tr("&Plan a survey…"),
            show.plan,
            "clipboard-text-outline",
            (),
            tr(
                "Distance, camera positions, number of photos and control points, and a field "
                "sheet."
            ),
        ),
        Command(
            "video_frames",
            tr("Frames from a &video…"),
            show.video,
            "movie-open-outline",
            (),
            tr("Extract the sharp frames of a video as photos."),
        ),
        Command(
            "make_settings",
            tr("Reconstruction &settings…"),
            show.settings,
            "tune",
            (),
            tr("Quality, ground control, coordinate reference system, threads and memory."),
            nothing_to_make,
        ),
        Command(
            "make_model",
            tr("&Reconstruct"),
            make,
            "cube-scan",
            (),
            tr("Align the photos and make a dense, textured model, in the background."),
            survey.why_not_make,
        ),
        Command(
            "pause_model",
            tr("Pause"),
            survey.pause,
            "pause",
            (),
            tr("Stop the reconstruction; finished stages are kept."),
            lambda: None if survey.making else Finding("action.no-reconstruction"),
        ),
    ]


class SurveyDialogs:
    """Opens the dialogs about photos. actions : of the window, looked up when they are needed"""

    def __init__(
        self,
        parent: QWidget,
        studio: Studio,
        survey: PhotoSurvey,
        dialogs: OpenDialogs,
        actions: Mapping[str, QAction],
        open_folder: Callable[[Path], None],
    ) -> None:
        self.parent = parent
        self._studio, self._survey = studio, survey
        self._dialogs, self._actions, self._open_folder = dialogs, actions, open_folder

    def plan(self) -> None:
        """Open the survey planner."""
        from vomstudio.ui.dialogs.planner.planner_dialog import PlannerDialog

        self._dialogs.show(
            PlannerDialog, lambda: PlannerDialog(self.parent, self._studio, self._survey)
        )

    def video(self) -> None:
        """Open the extraction of frames from a video."""
        from vomstudio.ui.dialogs.video_dialog import VideoDialog

        self._dialogs.show(
            VideoDialog, lambda: VideoDialog(self.parent, self._studio, self._open_folder)
        )

    def settings(self) -> None:
        """Open the reconstruction settings."""
        from vomstudio.ui.dialogs.reconstruct_dialog import ReconstructDialog

        make = self._actions["make_model"]
        self._dialogs.show(
            ReconstructDialog, lambda: ReconstructDialog(self.parent, self._survey, make)
        )


def is_photo_folder(path: Path) -> bool:
    """Whether a path is a folder that is no project."""
    return path.is_dir() and path.suffix != SUFFIX and not is_project(path)


def open_photos(survey: PhotoSurvey, docks: Docks, folder: Path) -> None:
    """Open a folder of photos and bring the Photos panel forward."""
    survey.open(folder)
    docks.bring_forward(_DOCK)
    docks.ensure_height(_DOCK, _HEIGHT)
