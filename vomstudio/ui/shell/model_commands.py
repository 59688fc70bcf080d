"""Commands on the current model."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtWidgets import QWidget

from vomstudio.document.records import Model
from vomstudio.ui.common.actions import Command
from vomstudio.ui.common.command_targets import current_model
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.shell.model_copying import copy_into_project
from vomstudio.ui.shell.project_files import Files
from vomstudio.workspace.photos import PhotoLinks

_NO_MODEL = "open a model first"


def commands(studio: Studio, files: Files, links: PhotoLinks, parent: QWidget) -> list[Command]:
    """parent : of the dialogs"""

    def no_model() -> str | None:
        return None if studio.session.of(Model) else _NO_MODEL

    def cannot_copy() -> str | None:
        model = current_model(studio)
        if model is None:
            return _NO_MODEL
        if studio.project.untitled:
            return "save the project first"
        if model.id not in studio.models:
            return "the model's file is not open"
        return None if Path(model.path).is_absolute() else "the model is in the project already"

    def copy() -> None:
        model = current_model(studio)
        if model is not None:
            copy_into_project(parent, studio, links, model)

    def cannot_export() -> str | None:
        model = current_model(studio)
        if model is None:
            return _NO_MODEL
        return None if model.id in studio.models else "the model's file is not open"

    def not_missing() -> str | None:
        model = current_model(studio)
        if model is None:
            return _NO_MODEL
        return "the model's file is where it should be" if model.id in studio.models else None

    return [
        Command("declare_frame", "&Declare frame…", files.declare_frame, "axis-arrow",
                (), "Up axis, unit, and CRS or local: what makes angles geographic", no_model),
        Command("locate", "&Locate file…", files.locate_model, "file-search-outline", (),
                "Say where the file of a model is now", not_missing),
        Command("copy_model", "&Copy into the project", copy, "content-copy", (),
                "The model, its materials, images and cameras, and its photos if wanted, so that "
                "the folder can be moved and zipped",
                cannot_copy),
        Command("export_model", "&Export model as…", files.export_model, "export", (),
                "In World, as OBJ, PLY, GLB, LAS/LAZ, XYZ, SHP or DXF", cannot_export),
        Command("remove_model", "&Remove model", files.remove_model, "close", (), "", no_model),
    ]  # fmt: skip
