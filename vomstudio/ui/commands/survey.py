"""Commands of the Photos panel: survey planning, photos, video frames and reconstruction."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QFileDialog, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.paths import PROJECT_SUFFIX, is_project
from vomstudio.project.photo_edits import photo_set_name
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.command_targets import start_folder
from vomstudio.ui.base.open_dialogs import OpenDialogs
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_protocols import Docks
from vomstudio.ui.panels.photos.photo_survey import PhotoSurvey

_DOCK_NAME = "photos"
# Height of five rows with thumbnails.
_MIN_HEIGHT_PX = 320


def commands(
    studio: Studio,
    survey: PhotoSurvey,
    dialogs: SurveyDialogs,
    open_folder: Callable[[Path], None],
    choose_project_folder: Callable[[str], bool],
) -> list[Command]:
    """Create the commands of the Photos panel.

    Parameters
    ----------
    studio : Studio
    survey : PhotoSurvey
    dialogs : SurveyDialogs
    open_folder : callable
        Called with the selected folder of photos.
    choose_project_folder : callable
        Called with the name of the photos; returns whether the project has a folder for the
        model of these photos. The user is asked for one if the project is untitled.
    """

    def choose_folder() -> None:
        name = QFileDialog.getExistingDirectory(
            dialogs.parent,
            tr("Choose a folder of photos"),
            start_folder(studio),
            QFileDialog.Option.ShowDirsOnly,
        )
        if name:
            open_folder(Path(name))

    def reconstruct() -> None:
        # The results of hours of work must not be saved in a folder that the user does not know.
        if survey.folder is not None and choose_project_folder(photo_set_name(survey.folder)):
            survey.reconstruct()

    def settings_problem() -> Finding | None:
        if survey.reconstruction_job is not None:
            return Finding("action.reconstruction-running")
        return None if survey.rows else Finding("action.no-photos")

    return [
        Command(
            "choose_photos",
            tr("New model from &photos…"),
            choose_folder,
            icon="image-multiple-outline",
            shortcut="Ctrl+Shift+I",
            tip=tr("Open a folder of photos, check the survey, and reconstruct."),
        ),
        Command(
            "plan_survey",
            tr("&Plan survey…"),
            dialogs.show_planner,
            icon="clipboard-text-outline",
            tip=tr("Plan distance, camera positions and control points, with a field sheet."),
        ),
        Command(
            "video_frames",
            tr("&Video frames…"),
            dialogs.show_video,
            icon="movie-open-outline",
            tip=tr("Extract the sharp frames of a video as photos."),
        ),
        Command(
            "make_settings",
            tr("Reconstruction &settings…"),
            dialogs.show_settings,
            icon="tune",
            tip=tr("Quality, ground control, coordinate reference system, threads and memory."),
            disabled_reason=settings_problem,
        ),
        Command(
            "make_model",
            tr("&Reconstruct"),
            reconstruct,
            icon="cube-scan",
            tip=tr("Align the photos and reconstruct a textured model in the background."),
            disabled_reason=survey.reconstruction_problem,
        ),
        Command(
            "pause_model",
            tr("Pause"),
            survey.pause,
            icon="pause",
            tip=tr("Stop the reconstruction; finished stages are kept."),
            disabled_reason=lambda: (
                None if survey.reconstruction_job else Finding("action.no-reconstruction")
            ),
        ),
    ]


class SurveyDialogs:
    """Dialogs for photos, opened on request; the window fills `actions` later."""

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

    def show_planner(self) -> None:
        """Open the survey planner."""
        from vomstudio.ui.dialogs.planner.planner_dialog import PlannerDialog

        self._dialogs.show(
            PlannerDialog, lambda: PlannerDialog(self.parent, self._studio, self._survey)
        )

    def show_video(self) -> None:
        """Open the dialog that extracts frames from a video."""
        from vomstudio.ui.dialogs.video_dialog import VideoDialog

        self._dialogs.show(
            VideoDialog,
            lambda: VideoDialog(self.parent, self._studio, self._open_folder),
            is_general=True,
        )

    def show_settings(self) -> None:
        """Open the reconstruction settings."""
        from vomstudio.ui.dialogs.reconstruct_dialog import ReconstructDialog
        from vomstudio.ui.panels.photos.region_choice import RegionChoice

        reconstruct_action = self._actions["make_model"]
        choice = RegionChoice(self._studio, self._survey)
        self._dialogs.show(
            ReconstructDialog,
            lambda: ReconstructDialog(self.parent, self._survey, reconstruct_action, choice),
        )


def is_photo_folder(path: Path) -> bool:
    """Return whether a path is a folder that is not a project."""
    return path.is_dir() and path.suffix != PROJECT_SUFFIX and not is_project(path)


def open_photos(survey: PhotoSurvey, docks: Docks, folder: Path) -> None:
    """Open a folder of photos and bring the Photos panel forward."""
    survey.open(folder)
    docks.bring_forward(_DOCK_NAME)
    docks.ensure_height(_DOCK_NAME, _MIN_HEIGHT_PX)
