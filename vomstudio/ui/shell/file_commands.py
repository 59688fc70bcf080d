"""Commands on projects, models and exports as files."""

from __future__ import annotations

from collections.abc import Callable

from vomstudio.ui.common.actions import Command
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.shell.project_files import Files


def commands(studio: Studio, files: Files, leave: Callable[[], object]) -> list[Command]:
    """leave : ends the program"""

    def no_features() -> str | None:
        return None if studio.session.features() else "there is nothing yet; pick a trace first"

    def open_sample() -> None:
        from vomstudio.io.project.sample import sample_model

        files.open_path(sample_model())

    return [
        Command("new", "&New project", files.new_project, "file-outline", "Ctrl+N"),
        Command("open", "&Open model…", files.choose_model, "folder-open-outline", "Ctrl+O",
                "Meshes, clouds and height models; or drop a file onto the window"),
        Command("open_sample", "Try the sample outcrop", open_sample,
                "image-filter-hdr", (), "A generated cliff whose bedding is known exactly"),
        Command("open_project", "Open &project…", files.choose_project, "folder-outline",
                "Ctrl+Shift+O"),
        Command("save", "&Save", files.save, "content-save-outline", "Ctrl+S",
                "Work is in the journal already; saving marks it and writes the GIS layers"),
        Command("save_as", "Save &as…", files.save_as, None, "Ctrl+Shift+S"),
        Command("export_csv", "Export &table…", lambda: files.export("csv"), "table-arrow-right",
                "Ctrl+E", "The orientation table as CSV, with every error and its reason",
                no_features),
        Command("export_gpkg", "Export &GIS layers…", lambda: files.export("gpkg"),
                "layers-outline", (), "Planes and traces as GeoPackage", no_features),
        Command("export_shp", "Export &shapefiles…", lambda: files.export("shp"), None, (),
                "Planes, traces and the rest as shapefiles, one for each layer", no_features),
        Command("export_dxf", "Export &DXF…", lambda: files.export("dxf"), None, (),
                "Planes, traces and the rest for CAD, a layer for each feature type", no_features),
        Command("quit", "&Quit", leave, None, "Ctrl+Q"),
    ]  # fmt: skip
