"""Commands of the Photos panel: planning, photos and frames, and the model that they make."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QFileDialog, QWidget

from vomstudio.io.project.folder import SUFFIX, is_project
from vomstudio.ui.common.actions import Command
from vomstudio.ui.common.command_targets import start_folder
from vomstudio.ui.common.open_dialogs import OpenDialogs
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.common.window_protocols import Docks
from vomstudio.ui.photos.photo_survey import PhotoSurvey
from vomstudio.words import tr

_DOCK = "photos"
# Five photos with their thumbnails.
_HEIGHT = 320


def commands(
    studio: Studio, survey: PhotoSurvey, show: SurveyDialogs, open_folder: Callable[[Path], None]
) -> list[Command]:
    """open_folder : a folder of photos"""

    def choose() -> None:
        name = QFileDialog.getExistingDirectory(
            show.parent,
            tr("A folder of photos"),
            start_folder(studio),
            QFileDialog.Option.ShowDirsOnly,
        )
        if name:
            open_folder(Path(name))

    def nothing_to_make() -> str | None:
        if survey.making is not None:
            return "a model is being made"
        return None if survey.rows else "choose a folder of photos first"

    return [
        Command("choose_photos", "New model from &photos…", choose,
                "image-multiple-outline", "Ctrl+Shift+I",
                "A folder of photos: what they are worth, and the model they make"),
        Command("plan_survey", "&Plan a survey…", show.plan, "clipboard-text-outline", (),
                "Before going out: distance, positions, number of photos, control points, and a "
                "field sheet"),
        Command("video_frames", "Frames from a &video…", show.video, "movie-open-outline",
                (), "The sharp frames of a video, as photos of a model"),
        Command("make_settings", "&Settings of the model…", show.settings, "tune", (),
                "Quality, ground control, coordinate system, threads and memory",
                nothing_to_make),
        Command("make_model", "&Make the model", survey.make, "cube-scan", (),
                "Align the photos and make a dense, textured model, in the background",
                survey.why_not_make),
        Command("pause_model", "Pause", survey.pause, "pause", (),
                "Stop for now; what is finished is kept",
                lambda: None if survey.making else "no model is being made"),
    ]  # fmt: skip


class SurveyDialogs:
    """The dialogs about photos, beside the window. actions : of the window, as they are by then"""

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
        from vomstudio.ui.survey.planner_dialog import PlannerDialog

        self._dialogs.show(
            PlannerDialog, lambda: PlannerDialog(self.parent, self._studio, self._survey)
        )

    def video(self) -> None:
        from vomstudio.ui.survey.video_dialog import VideoDialog

        self._dialogs.show(
            VideoDialog, lambda: VideoDialog(self.parent, self._studio, self._open_folder)
        )

    def settings(self) -> None:
        from vomstudio.ui.survey.reconstruct_dialog import MakeDialog

        make = self._actions["make_model"]
        self._dialogs.show(MakeDialog, lambda: MakeDialog(self.parent, self._survey, make))


def is_photo_folder(path: Path) -> bool:
    """A folder that is no project."""
    return path.is_dir() and path.suffix != SUFFIX and not is_project(path)


def open_photos(survey: PhotoSurvey, docks: Docks, folder: Path) -> None:
    survey.open(folder)
    docks.bring_forward(_DOCK)
    docks.make_room(_DOCK, _HEIGHT)
