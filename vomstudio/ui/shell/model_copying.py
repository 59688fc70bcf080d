"""A model brought into the project's folder, with its cameras and, where wanted, its photos."""

from __future__ import annotations

from PySide6.QtWidgets import QMessageBox, QWidget

from vomstudio.document.records import Model
from vomstudio.io.models.model_copy import photos_of
from vomstudio.ui.common.studio import Studio
from vomstudio.words import tr
from vomstudio.workspace.photos import PhotoLinks


def copy_into_project(parent: QWidget, studio: Studio, links: PhotoLinks, model: Model) -> None:
    path = studio.project.find_model(model)
    if path is None:
        return
    cameras = links.cameras_path(model.id)
    count, size = (0, 0) if cameras is None else photos_of(path, cameras)
    photos = False
    if count:
        box = QMessageBox(parent)
        box.setIcon(QMessageBox.Icon.Question)
        box.setText(tr("Copy the {count} photos of {model} too?", count=count, model=model.name))
        box.setInformativeText(
            tr(
                "They take {size:,.0f} MB. With them the project's folder can be moved to "
                "another computer and still shows features in the photos; without, it finds "
                "them where they are now.",
                size=size / 1000000.0,
            )
        )
        button = QMessageBox.StandardButton
        box.setStandardButtons(button.Yes | button.No | button.Cancel)
        answer = box.exec()
        if answer == button.Cancel:
            return
        photos = answer == button.Yes
    studio.copy_model(model.id, cameras, photos, lambda: links.forget_choices(model.id))
