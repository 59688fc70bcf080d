"""Commands of the panel that shows the outcrop in its photos."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QFileDialog, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.studio.photos import PhotoLinks
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.command_targets import current_model, start_folder, why_no_model
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_protocols import Docks
from vomstudio.ui.panels.in_photos.feature_photo import FeaturePhoto
from vomstudio.ui.panels.in_photos.sighting_list import SightingList

_DOCK = "in_photos"
_HEIGHT = 400


def commands(
    studio: Studio,
    links: PhotoLinks,
    photos: SightingList,
    shown: FeaturePhoto,
    docks: Docks,
    parent: QWidget,
) -> list[Command]:
    """photos : in the list beside the one that is shown. parent : of the dialogs"""

    def no_model() -> Finding | None:
        return why_no_model(studio)

    def no_photo() -> Finding | None:
        return None if photos.count() else Finding("action.no-shown-photo")

    def show() -> None:
        docks.bring_forward(_DOCK)
        # A tab that was never in front has a height of its own until it is laid out.
        QTimer.singleShot(0, parent, lambda: docks.ensure_height(_DOCK, _HEIGHT))

    def open_cameras() -> None:
        model = current_model(studio)
        name, _ = QFileDialog.getOpenFileName(
            parent,
            tr("Choose the cameras of the model"),
            start_folder(studio),
            tr("Cameras (*.json)"),
        )
        if name and model is not None:
            show()
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
            show,
            "image-search-outline",
            "Ctrl+Shift+P",
            tr("The photos in which the selection is visible, with the features on them."),
            no_model,
        ),
        Command(
            "open_cameras",
            tr("Open &cameras…"),
            open_cameras,
            "camera-outline",
            (),
            tr("Open the cameras.json of the reconstruction of the model."),
            no_model,
        ),
        Command(
            "find_photos",
            tr("&Locate photos…"),
            find_photos,
            "folder-search-outline",
            (),
            tr("Choose the folder in which the photos of the model are now."),
            lambda: None if links.models() else Finding("action.no-cameras"),
        ),
        Command(
            "previous_photo",
            tr("Previous photo"),
            lambda: photos.step(-1),
            "chevron-left",
            "Alt+Left",
            "",
            no_photo,
        ),
        Command(
            "next_photo",
            tr("Next photo"),
            lambda: photos.step(1),
            "chevron-right",
            "Alt+Right",
            "",
            no_photo,
        ),
        Command(
            "fit_photo",
            tr("Whole photo"),
            shown.canvas.fit,
            "fit-to-screen-outline",
            "Ctrl+0",
            "",
            no_photo,
        ),
    ]
