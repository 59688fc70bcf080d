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

    def why_no_features() -> Finding | None:
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
            tip=tr("A mesh, point cloud or height model. Files can be dropped on the window."),
        ),
        Command(
            "open_sample",
            tr("Open sample outcrop"),
            open_sample,
            icon="image-filter-hdr",
            tip=tr("A synthetic cliff whose bedding is known exactly."),
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
            tip=tr(
                "All work is in the journal already. Saving marks a state and writes the GIS "
                "layers."
            ),
        ),
        Command("save_as", tr("Save &as…"), files.save_as, shortcut="Ctrl+Shift+S"),
        Command(
            "export_csv",
            tr("Export &table…"),
            lambda: files.export("csv"),
            icon="table-arrow-right",
            shortcut="Ctrl+E",
            tip=tr("The orientation table as CSV, with errors, verdicts and reasons."),
            why_not=why_no_features,
        ),
        Command(
            "export_gpkg",
            tr("Export &GIS layers…"),
            lambda: files.export("gpkg"),
            icon="layers-outline",
            tip=tr("All features as layers of a GeoPackage."),
            why_not=why_no_features,
        ),
        Command(
            "export_shp",
            tr("Export &shapefiles…"),
            lambda: files.export("shp"),
            tip=tr("All features as shapefiles, one for each layer."),
            why_not=why_no_features,
        ),
        Command(
            "export_dxf",
            tr("Export &DXF…"),
            lambda: files.export("dxf"),
            tip=tr("All features for CAD, one layer for each feature type."),
            why_not=why_no_features,
        ),
        Command(
            "export_program",
            tr("Export for &another program…"),
            files.export_for_program,
            tip=tr(
                "Stereonet, Orient, FaultKin, Win-Tensor, GemPy, LoopStructural, "
                "GeMS, KML, GeoJSON."
            ),
            why_not=why_no_features,
        ),
        Command(
            "copy_export",
            tr("&Copy last export as command"),
            files.copy_export,
            icon="console",
            tip=tr("The line for the shell that exports the same."),
            why_not=files.why_no_export,
        ),
        Command("quit", tr("&Quit"), quit_program, shortcut="Ctrl+Q"),
    ]
