"""Commands for the current model."""

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
from vomstudio.ui.base.command_targets import closed_model_finding, current_model
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_protocols import WorkspaceSwitcher
from vomstudio.ui.commands.model_copying import copy_into_project
from vomstudio.ui.commands.project_files import Files


def commands(
    studio: Studio, files: Files, links: PhotoLinks, parent: QWidget, workspaces: WorkspaceSwitcher
) -> list[Command]:
    """Create the commands for the current model."""

    def missing_model_finding() -> Finding | None:
        return None if studio.session.of(Model) else Finding("action.no-model")

    def copy_problem() -> Finding | None:
        model = current_model(studio)
        if model is not None and studio.project.is_untitled:
            return Finding("action.project-untitled")
        if model is None or model.id not in studio.models:
            return closed_model_finding(studio)
        return None if Path(model.path).is_absolute() else Finding("action.model-in-project")

    def register() -> None:
        workspaces.switch("model")
        studio.activate(ControlTool.name)

    def copy() -> None:
        model = current_model(studio)
        if model is not None:
            copy_into_project(parent, studio, links, model)

    def locate_problem() -> Finding | None:
        model = current_model(studio)
        if model is None:
            return Finding("action.no-model")
        return Finding("action.model-located") if model.id in studio.models else None

    def convert_problem() -> Finding | None:
        conversion_available = studio.workspace.models.conversion_available
        return Finding("action.no-refused-model") if conversion_available is None else None

    return [
        Command(
            "declare_frame",
            tr("&Declare frame…"),
            files.declare_frame,
            icon="axis-arrow",
            tip=tr("Specify up axis, unit and CRS, so that orientations are geographic."),
            disabled_reason=missing_model_finding,
        ),
        Command(
            "register_model",
            tr("&Register by points"),
            register,
            icon="vector-point-select",
            tip=tr("Register the model using points with known coordinates."),
            disabled_reason=missing_model_finding,
        ),
        Command(
            CONVERT,
            tr("Convert to &metric"),
            studio.workspace.models.convert,
            icon="map-marker-path",
            tip=tr("Open a copy of the rejected model in a metric CRS."),
            disabled_reason=convert_problem,
        ),
        Command(
            "locate",
            tr("&Locate file…"),
            files.locate_model,
            icon="file-search-outline",
            tip=tr("Choose the file of a model that was moved or renamed."),
            disabled_reason=locate_problem,
        ),
        Command(
            "copy_model",
            tr("&Copy into project"),
            copy,
            icon="content-copy",
            tip=tr("Copy the model with textures, cameras and photos into the project folder."),
            disabled_reason=copy_problem,
        ),
        Command(
            "export_model",
            tr("&Export model as…"),
            files.export_model,
            icon="export",
            tip=tr("Export in World coordinates (OBJ, PLY, GLB, LAS/LAZ, XYZ, SHP, DXF)."),
            disabled_reason=lambda: closed_model_finding(studio),
        ),
        Command(
            "remove_model",
            tr("&Remove model"),
            files.remove_model,
            icon="close",
            disabled_reason=missing_model_finding,
        ),
    ]
