"""Commands for project, model and export files."""

from __future__ import annotations

from collections.abc import Callable

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.commands.project_files import Files


def commands(studio: Studio, files: Files, quit_program: Callable[[], object]) -> list[Command]:
    """Create the file commands; `quit_program` ends the program."""

    def missing_features_finding() -> Finding | None:
        return None if studio.session.features() else Finding("export.no-features")

    def open_sample() -> None:
        from vomstudio.project.sample import sample_model

        files.open_path(sample_model())

    return [
        Command(
            "new", tr("&New project"), files.new_project, icon="file-outline", shortcut="Ctrl+N"
        ),
        Command(
            "open",
            tr("&Open model…"),
            files.choose_model,
            icon="folder-open-outline",
            shortcut="Ctrl+O",
            tip=tr("Open a mesh, point cloud or height model."),
        ),
        Command(
            "open_sample",
            tr("Open sample outcrop"),
            open_sample,
            icon="image-filter-hdr",
            tip=tr("Open a synthetic cliff with known bedding."),
        ),
        Command(
            "open_project",
            tr("Open &project…"),
            files.choose_project,
            icon="folder-outline",
            shortcut="Ctrl+Shift+O",
        ),
        Command(
            "save",
            tr("&Save"),
            files.save,
            icon="content-save-outline",
            shortcut="Ctrl+S",
            tip=tr("Save the project and write its GIS layers."),
        ),
        Command("save_as", tr("Save &as…"), files.save_as, shortcut="Ctrl+Shift+S"),
        Command(
            "export_csv",
            tr("Export &table…"),
            lambda: files.export("csv"),
            icon="table-arrow-right",
            shortcut="Ctrl+E",
            tip=tr("Export the orientation table as CSV, with errors and verdicts."),
            disabled_reason=missing_features_finding,
        ),
        Command(
            "export_gpkg",
            tr("Export &GIS layers…"),
            lambda: files.export("gpkg"),
            icon="layers-outline",
            tip=tr("Export all features as layers of a GeoPackage."),
            disabled_reason=missing_features_finding,
        ),
        Command(
            "export_shp",
            tr("Export &shapefiles…"),
            lambda: files.export("shp"),
            tip=tr("Export all features as shapefiles, one per layer."),
            disabled_reason=missing_features_finding,
        ),
        Command(
            "export_dxf",
            tr("Export &DXF…"),
            lambda: files.export("dxf"),
            tip=tr("Export all features for CAD, one layer per type."),
            disabled_reason=missing_features_finding,
        ),
        Command(
            "export_program",
            tr("Export to &program…"),
            files.export_for_program,
            tip=tr(
                "Stereonet, Orient, FaultKin, Win-Tensor, GemPy, LoopStructural, "
                "GeMS, KML, GeoJSON."
            ),
            disabled_reason=missing_features_finding,
        ),
        Command(
            "project_report",
            tr("Write &report…"),
            files.write_report,
            icon="file-document-outline",
            tip=tr("Write all results of the project as an HTML page."),
            disabled_reason=missing_features_finding,
        ),
        Command(
            "copy_export",
            tr("&Copy export command"),
            files.copy_export_command,
            icon="console",
            tip=tr("Copy the shell command that repeats the last export."),
            disabled_reason=files.missing_export_finding,
        ),
        Command("quit", tr("&Quit"), quit_program, shortcut="Ctrl+Q"),
    ]
