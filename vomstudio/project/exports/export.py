"""Export of a project to files for other programs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.core.errors import InputError
from vomstudio.core.files.atomic import check_target
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.geology.profiles import Thresholds
from vomstudio.io.exchange.columns import sibling_path, write_tables
from vomstudio.io.gis.crs import world_crs
from vomstudio.project.exports.export_options import ExportFormat
from vomstudio.project.garbage_collection import pause_collection
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import Feature, Record
from vomstudio.project.tables.feature_lists import listed_tables
from vomstudio.project.tables.orientation_table import write_orientation_csv
from vomstudio.project.tables.project_table import ProjectTable, project_table
from vomstudio.project.tables.registration_comments import registration_lines

if TYPE_CHECKING:
    from vomstudio.io.gis.layers import Layer

_LAYER_FORMATS = ("gpkg", "shp", "geojson", "dxf", "kml")


def export_project(
    folder: Path,
    format_: str,
    out: Path,
    *,
    writes_map: bool = True,
    is_projected: bool = False,
    force: bool = False,
    progress: Progress | None = None,
) -> ProjectTable:
    """Export the project in `folder`, which may be open in a window.

    Parameters
    ----------
    folder : Path
        Project folder.
    format_ : str
        Name of the format.
    out : Path
        File to write.
    writes_map : bool
        Whether to also write the QGIS map of a GeoPackage.
    is_projected : bool
        Whether GeoJSON is written in the CRS of the project in place of WGS 84.
    force : bool, optional
        Whether to replace existing files.
    progress : Progress, optional

    Returns
    -------
    ProjectTable
        Exported table, including the paths of the written files.

    Raises
    ------
    InputError
        If the project cannot be read or contains no features.
    UsageError
        If the format is unknown.
    TargetError
        If `out` cannot be written.
    """
    # The block covers everything that is created; otherwise the collector would scan it before it
    # is freed.
    with pause_collection():
        return _export(
            folder, format_, out, writes_map, is_projected, force, progress or SilentProgress()
        )


def _export(
    folder: Path,
    format_: str,
    out: Path,
    writes_map: bool,
    is_projected: bool,
    force: bool,
    progress: Progress,
) -> ProjectTable:
    from vomstudio.project.journal.database import journal_files, read_replay

    format_ = _format_name(format_)
    check_target(out, force=force, inputs=journal_files(folder))
    progress.stage(tr("Reading {file}", file=folder.name))
    replay = read_replay(folder)
    progress.stage(tr("Writing {file}", file=out.name))
    refuse_empty(replay.records, folder)
    return export_records(
        replay.records,
        format_,
        out,
        writes_map=writes_map,
        is_projected=is_projected,
        force=force,
        thresholds=get_thresholds(replay.settings),
    )


def refuse_empty(records: Mapping[str, Record], folder: Path) -> None:
    """Raise InputError if the project contains nothing to export."""
    if not any(isinstance(record, Feature) for record in records.values()):
        raise InputError(
            Finding("export.no-features"),
            file=folder,
        )


def export_records(
    records: Mapping[str, Record],
    format_: str,
    out: Path,
    *,
    writes_map: bool = True,
    is_projected: bool = False,
    force: bool = False,
    thresholds: Thresholds | None = None,
) -> ProjectTable:
    """Export the features of a project. Raises the same errors as `export_project`."""
    format_ = _format_name(format_)
    measurements = Measurements(thresholds)
    table = project_table(records, measurements)
    if format_ != "csv":
        table = table.drop_repeats()
    crs = world_crs(table.crs, table.unit_m)
    if format_ == "csv":
        feature_lists = listed_tables(records, table, measurements)
        texts = {sibling_path(out, name): text for name, text in feature_lists.items()}
        for path in texts:
            check_target(path, force=force)
        result = write_csv(out, table, force=force)
        if not texts:
            return result
        return replace(result, files=(out, *write_tables(texts, force=force)))
    from vomstudio.project.tables.project_layers import project_layers

    layers = project_layers(records, table, measurements)
    if format_ in _LAYER_FORMATS:
        table = replace(
            table,
            layers={layer.name: len(layer.shapes) for layer in layers},
            features=max(len(table.rows), len(_exported_ids(layers))),
        )
    if format_ == "gpkg":
        from vomstudio.project.exports.geopackage import write_layers

        files = write_layers(out, records, table, layers, writes_map=writes_map, force=force)
        return replace(table, files=tuple(files))
    if format_ == "shp":
        from vomstudio.project.exports.gis_files import write_shapefiles

        return replace(table, files=tuple(write_shapefiles(out, layers, crs, force=force)))
    if format_ == "dxf":
        from vomstudio.project.exports.gis_files import write_dxf

        files = write_dxf(out, layers, records, crs, axes=table.axes, force=force)
        return replace(table, files=tuple(files))
    from vomstudio.project.exports.program_exports import write_for_program

    return write_for_program(
        format_, out, records, table, layers, crs, is_projected=is_projected, force=force
    )


def _exported_ids(layers: Iterable[Layer]) -> set[str]:
    """Return the IDs of the features on the layers; grids are not features."""
    from vomstudio.project.tables.grid_layer import LAYER as GRIDS

    return {id_ for layer in layers if layer.name != GRIDS for id_ in layer.columns["id"]}


def write_csv(out: Path, table: ProjectTable, *, force: bool = False) -> ProjectTable:
    """Write the orientation table as a text file. Raises TargetError."""
    crs = table.crs
    if table.crs is not None and table.unit_m != 1.0:
        crs = tr("{crs}, axes in metres", crs=table.crs)
    write_orientation_csv(
        out,
        table.rows,
        crs=crs,
        north=table.north,
        axes=table.axes,
        limits=table.limits,
        notes=registration_lines(table.registrations),
        extra_columns=table.extra_columns,
        force=force,
    )
    return replace(table, files=(out,))


def get_thresholds(settings: Mapping[str, Any]) -> Thresholds | None:
    """Return the verdict thresholds in the settings of the newest edit, or None.

    With these thresholds, the verdicts in exported tables match those in the window.
    """
    try:
        return Thresholds(**settings["thresholds"])
    except (KeyError, TypeError):
        return None


def _format_name(word: str) -> str:
    """Return the name of a format in lower case. Raises UsageError."""
    return ExportFormat(word.casefold()).to  # type: ignore[arg-type]
