"""Copying of a model into the project folder, with its cameras and optionally its photos."""

from __future__ import annotations

from PySide6.QtWidgets import QMessageBox, QWidget

from vomstudio.core.words import tr, tr_n
from vomstudio.io.models.model_copy import count_photos
from vomstudio.project.records import Model
from vomstudio.studio.photos import PhotoLinks
from vomstudio.ui.base.controls import escape_markup
from vomstudio.ui.base.studio import Studio


def copy_into_project(parent: QWidget, studio: Studio, links: PhotoLinks, model: Model) -> None:
    """Ask whether the photos should be copied too, and start the copy job."""
    path = studio.project.find_model(model)
    if path is None:
        return
    cameras = links.cameras_path(model.id)
    photo_count, size_bytes = (0, 0) if cameras is None else count_photos(path, cameras)
    copy_photos = False
    if photo_count:
        box = QMessageBox(parent)
        box.setIcon(QMessageBox.Icon.Question)
        box.setText(
            tr_n(
                "Copy the {count} photo of {model} as well?",
                "Copy the {count} photos of {model} as well?",
                photo_count,
                model=escape_markup(model.name),
            )
        )
        box.setInformativeText(
            tr(
                "Size: {size:,.0f} MB. With the photos, the project folder works on other"
                " computers. Without them, the project refers to their current location.",
                size=size_bytes / 1e6,
            )
        )
        button = QMessageBox.StandardButton
        box.setStandardButtons(button.Yes | button.No | button.Cancel)
        answer = box.exec()
        if answer == button.Cancel:
            return
        copy_photos = answer == button.Yes
    studio.copy_model(model.id, cameras, copy_photos, lambda: links.forget_choices(model.id))
