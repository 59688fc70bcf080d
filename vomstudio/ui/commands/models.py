"""Commands on the current model."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtWidgets import QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.records import Model
from vomstudio.studio.notices import CONVERT
from vomstudio.studio.photos import PhotoLinks
from vomstudio.studio.tools.control import ControlTool
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.command_targets import current_model
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_protocols import WorkspaceSwitcher
from vomstudio.ui.commands.model_copying import copy_into_project
from vomstudio.ui.commands.project_files import Files


def commands(
    studio: Studio, files: Files, links: PhotoLinks, parent: QWidget, workspaces: WorkspaceSwitcher
) -> list[Command]:
    """parent : of the dialogs"""

    def no_model() -> Finding | None:
        return None if studio.session.of(Model) else Finding("action.no-model")

    def cannot_copy() -> Finding | None:
        model = current_model(studio)
        if model is None:
            return Finding("action.no-model")
        if studio.project.untitled:
            return Finding("action.project-untitled")
        if model.id not in studio.models:
            return Finding("model.not-open")
        return None if Path(model.path).is_absolute() else Finding("action.model-in-project")

    def register() -> None:
        workspaces.switch("register")
        studio.activate(ControlTool.name)

    def copy() -> None:
        model = current_model(studio)
        if model is not None:
            copy_into_project(parent, studio, links, model)

    def cannot_export() -> Finding | None:
        model = current_model(studio)
        if model is None:
            return Finding("action.no-model")
        return None if model.id in studio.models else Finding("model.not-open")

    def not_missing() -> Finding | None:
        model = current_model(studio)
        if model is None:
            return Finding("action.no-model")
        return Finding("action.model-located") if model.id in studio.models else None

    def cannot_convert() -> Finding | None:
        offered = studio.workspace.models.convertible
        return Finding("action.no-refused-model") if offered is None else None

    return [
        Command(
            "declare_frame",
            tr("&Declare frame…"),
            files.declare_frame,
            "axis-arrow",
            (),
            tr(
                "Up axis, unit, and CRS or local frame. Orientations are geographic only in "
                "a declared frame."
            ),
            no_model,
        ),
        Command(
            "register_model",
            tr("&Register by points"),
            register,
            "vector-point-select",
            (),
            tr(
                "Places the model by points that are clicked on it or come in a table, and "
                "their coordinates, with residuals and the error in degrees."
            ),
            no_model,
        ),
        Command(
            CONVERT,
            tr("Convert to &metric CRS"),
            studio.workspace.models.convert,
            "map-marker-path",
            (),
            tr("Opens the refused model as a copy in a CRS whose metres are true."),
            cannot_convert,
        ),
        Command(
            "locate",
            tr("&Locate file…"),
            files.locate_model,
            "file-search-outline",
            (),
            tr("Choose the file of a model that has been moved or renamed."),
            not_missing,
        ),
        Command(
            "copy_model",
            tr("&Copy into project"),
            copy,
            "content-copy",
            (),
            tr(
                "Copies the model with its materials, textures and cameras, and its photos if "
                "wanted, so that the project folder can be moved or zipped."
            ),
            cannot_copy,
        ),
        Command(
            "export_model",
            tr("&Export model as…"),
            files.export_model,
            "export",
            (),
            tr("In World coordinates, as OBJ, PLY, GLB, LAS/LAZ, XYZ, SHP or DXF."),
            cannot_export,
        ),
        Command("remove_model", tr("&Remove model"), files.remove_model, "close", (), "", no_model),
    ]
