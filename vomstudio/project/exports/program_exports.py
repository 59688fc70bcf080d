"""Export of a project for another program: only accepted features, in its own columns."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate as _
from vomstudio.core.words import tr
from vomstudio.io.exchange import fault_slips, geological_models, orientation_programs
from vomstudio.io.exchange.columns import sibling_path, write_tables
from vomstudio.io.exchange.geojson import geojson_files
from vomstudio.io.exchange.kml import kml_text
from vomstudio.io.exchange.orientation_programs import is_plane
from vomstudio.io.gis.layers import Layer
from vomstudio.project import catalogue
from vomstudio.project.figures import Figure
from vomstudio.project.kinds import KINDS
from vomstudio.project.records import FeatureType, Record
from vomstudio.project.tables.orientation_table import Row
from vomstudio.project.tables.project_table import ProjectTable

# Reasons for one feature and for all features.
_NO_ORIENTATION = (_("it has no orientation"), _("none of its features has an orientation"))
_NO_POSITION = (_("it has no position"), _("none of its features has a position"))
_NO_PLANE = (
    _("it is not a plane with a position"),
    _("none of its features is a plane with a position"),
)
_NO_SLIP = (
    _("it is not a line on a plane with known slip"),
    _("none of its features is a line on a plane with known slip"),
)
_NO_FAULT = (
    _("it is not a line on a plane"),
    _("none of its features is a line on a plane"),
)


def write_for_program(
    format_: str,
    out: Path,
    records: Mapping[str, Record],
    table: ProjectTable,
    layers: Sequence[Layer],
    crs: str | None,
    *,
    is_projected: bool = False,
    force: bool,
) -> ProjectTable:
    """Write the files for a program and return the written and the skipped rows.

    If `is_projected` is set, GeoJSON has the coordinates of the project in place of degrees.
    Raises InputError if the program does not accept any of the features, and TargetError.
    """
    if format_ == "geojson":
        texts = geojson_files(out, layers, crs, is_projected=is_projected)
        warnings = (Finding("geojson.no-crs"),) if crs is None else ()
        return replace(table, files=tuple(write_tables(texts, force=force)), warnings=warnings)
    if format_ == "kml":
        colors = {
            record.name.casefold(): record.color
            for record in records.values()
            if isinstance(record, FeatureType)
        }
        text = kml_text(out, layers, crs, colors, out.stem, describe=_describe)
        return replace(table, files=tuple(write_tables({out: text}, force=force)))
    is_accepted, (row_reason, empty_reason) = _ACCEPTED_ROWS[format_]
    rows = [row for row in table.rows if is_accepted(row)]
    rejected_rows = [row for row in table.rows if not is_accepted(row)]
    if not rows:
        raise InputError(
            Finding("export.nothing-to-write", program=format_, reason=tr(empty_reason)),
            file=out,
        )
    texts = _format_rows(format_, out, rows, layers)
    skipped_features = [
        {"id": str(row["id"]), "name": str(row["name"] or row["id"]), "reason": tr(row_reason)}
        for row in rejected_rows
    ]
    files = tuple(write_tables(texts, force=force))
    return replace(table, rows=rows, skipped=[*table.skipped, *skipped_features], files=files)


def _describe(column: str, value: Any) -> tuple[str, str]:
    """Return the title of a column and its value with as many digits as in the window."""
    figure = _figures().get(column)
    if figure is None or figure.form in ("text", "flag") or not isinstance(value, int | float):
        return (column if figure is None else tr(figure.title)), str(value)
    return tr(figure.title), f"{value:.3f}" if column in "xyz" else figure.value_text(value)


@cache
def _figures() -> Mapping[str, Figure]:
    """Return all figures of layers by the names of their columns."""
    layers = [kind.layer for kind in KINDS if kind.layer is not None]
    figures = (*catalogue.ORIENTATION, *(figure for layer in layers for figure in layer.figures))
    return {figure.name: figure for figure in figures}


def _format_rows(
    format_: str, out: Path, rows: Sequence[Row], layers: Sequence[Layer]
) -> dict[Path, str]:
    if format_ == "stereonet":
        return _stereonet(out, rows)
    if format_ == "gempy":
        points = sibling_path(out, "surface_points")
        return {
            out: geological_models.gempy_orientations(rows),
            points: geological_models.gempy_points(layers),
        }
    if format_ == "loopstructural":
        return {out: geological_models.loopstructural_table(rows, layers)}
    write = {
        "orient": orientation_programs.orient_table,
        "gems": orientation_programs.gems_table,
        "faultkin": fault_slips.faultkin_table,
        "wintensor": fault_slips.wintensor_table,
    }[format_]
    return {out: write(rows)}


def _stereonet(out: Path, rows: Sequence[Row]) -> dict[Path, str]:
    """Return one file of planes and one of lines; `out` contains the planes if there are any."""
    planes = [row for row in rows if is_plane(row)]
    lines = [row for row in rows if not is_plane(row)]
    texts = {}
    if planes:
        texts[out] = orientation_programs.stereonet_planes(planes)
    if lines:
        path = sibling_path(out, "lines") if planes else out
        texts[path] = orientation_programs.stereonet_lines(lines)
    return texts


def _select_all(row: Mapping[str, Any]) -> bool:
    return True


def _has_position(row: Mapping[str, Any]) -> bool:
    return row["x"] is not None


def _is_positioned_plane(row: Mapping[str, Any]) -> bool:
    return is_plane(row) and _has_position(row)


def _has_slip(row: Mapping[str, Any]) -> bool:
    return fault_slips.is_line_on_plane(row) and row["slip_rake_deg"] is not None


_ACCEPTED_ROWS: Mapping[str, tuple[Callable[[Mapping[str, Any]], bool], tuple[str, str]]] = {
    "stereonet": (_select_all, _NO_ORIENTATION),
    "orient": (_select_all, _NO_ORIENTATION),
    "faultkin": (_has_slip, _NO_SLIP),
    "wintensor": (fault_slips.is_line_on_plane, _NO_FAULT),
    "gempy": (_is_positioned_plane, _NO_PLANE),
    "loopstructural": (_is_positioned_plane, _NO_PLANE),
    "gems": (_has_position, _NO_POSITION),
}
"""Rows of the table that a program accepts, and the reason for skipping other rows."""
