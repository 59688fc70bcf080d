"""Commands of the panel that shows the outcrop in its photos."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QFileDialog, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.studio.photos import PhotoLinks
from vomstudio.ui.base import file_filters
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.command_targets import current_model, missing_model_finding, start_folder
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_protocols import Docks
from vomstudio.ui.panels.in_photos.feature_photo import FeaturePhoto
from vomstudio.ui.panels.in_photos.sighting_list import SightingList

_DOCK_NAME = "in_photos"
_MIN_HEIGHT_PX = 400


def commands(
    studio: Studio,
    links: PhotoLinks,
    photos: SightingList,
    feature_photo: FeaturePhoto,
    docks: Docks,
    parent: QWidget,
) -> list[Command]:
    """Create the commands of the panel; `photos` lists the photos that show the selection."""

    def model_finding() -> Finding | None:
        return missing_model_finding(studio)

    def missing_photo_finding() -> Finding | None:
        return None if photos.count() else Finding("action.no-shown-photo")

    def show_panel() -> None:
        docks.bring_forward(_DOCK_NAME)
        # A tab that was never shown does not adopt the height of the dock until layout is complete.
        QTimer.singleShot(0, parent, lambda: docks.ensure_height(_DOCK_NAME, _MIN_HEIGHT_PX))

    def open_cameras() -> None:
        model = current_model(studio)
        name, _ = QFileDialog.getOpenFileName(
            parent,
            tr("Choose the cameras of the model"),
            start_folder(studio),
            file_filters.cameras(),
        )
        if name and model is not None:
            show_panel()
            links.open_cameras(model.id, Path(name))

    def find_photos() -> None:
        name = QFileDialog.getExistingDirectory(
            parent, tr("Choose the folder of the photos"), start_folder(studio)
        )
        models = links.models()
        if name and models:
            links.find_photos(models[0], Path(name))

    return [
        Command(
            "show_in_photos",
            tr("Show in &photos"),
            show_panel,
            icon="image-search-outline",
            shortcut="Ctrl+Shift+P",
            tip=tr("Show the photos of the selection, with the features drawn on them."),
            disabled_reason=model_finding,
        ),
        Command(
            "open_cameras",
            tr("Open &cameras…"),
            open_cameras,
            icon="camera-outline",
            tip=tr("Open the camera file exported by the program that made the model."),
            disabled_reason=model_finding,
        ),
        Command(
            "find_photos",
            tr("&Locate photos…"),
            find_photos,
            icon="folder-search-outline",
            tip=tr("Choose the folder that contains the photos of the model."),
            disabled_reason=lambda: None if links.models() else Finding("action.no-cameras"),
        ),
        Command(
            "previous_photo",
            tr("Previous photo"),
            lambda: photos.step(-1),
            icon="chevron-left",
            shortcut="Alt+Left",
            disabled_reason=missing_photo_finding,
        ),
        Command(
            "next_photo",
            tr("Next photo"),
            lambda: photos.step(1),
            icon="chevron-right",
            shortcut="Alt+Right",
            disabled_reason=missing_photo_finding,
        ),
        Command(
            "fit_photo",
            tr("Whole photo"),
            feature_photo.canvas.fit,
            icon="fit-to-screen-outline",
            shortcut="Ctrl+0",
            disabled_reason=missing_photo_finding,
        ),
    ]
