"""Attributes of GIS layers and sheets of workbooks as text tables."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.files.file_kinds import FileKind, other_kind_error
from vomstudio.core.findings import Finding
from vomstudio.io.gate.frame_options import FrameOptions
from vomstudio.io.gate.points import points_to_world
from vomstudio.io.gate.stated_crs import StatedCrs, table_crs
from vomstudio.io.gis.axis_units import MAX_DEGREES, stated_axes, suggested_zone
from vomstudio.io.gis.layer_reading import SPREADSHEETS, is_geojson_without_crs
from vomstudio.io.gis.vector_layers import VectorLayer, list_layers, read_layers
from vomstudio.io.text.column_names import normalise_name
from vomstudio.io.text.orientation_columns import has_orientations
from vomstudio.io.text.rows import is_header
from vomstudio.io.text.tables import COORDINATES, TextTable, table_from_cells

_OWN_LAYERS = ("planes", "lines")
"""Layers of the exports of this program that contain orientations."""
_HIDDEN_LAYERS = {"layer_styles"}
"""Tables of a GeoPackage without measurements."""
_MAX_DIFFERENCE_M = 1e-3


def read_layer_table(path: Path, kind: FileKind, layer: str | None) -> TextTable:
    """Read the attributes of a layer, or a sheet of a workbook, as a table.

    The layers `planes` and `lines` of a file that this program has written are joined.

    Parameters
    ----------
    path : Path
    kind : FileKind
        Kind of the file.
    layer : str or None
        Name of the layer or sheet, required if several others contain orientations.

    Raises
    ------
    InputError
        If the file cannot be read or contains no rows.
    UsageError
        If the layer is missing, or several layers contain orientations.
    """

    def reading_error() -> InputError:
        return other_kind_error(path, kind)

    listed_layers = list_layers(path, reading_error, has_sheets=True)
    names = [layer.name for layer in listed_layers if layer.name not in _HIDDEN_LAYERS]
    if layer is not None and layer not in names:
        finding = Finding("drawing.unknown-layer", layer=layer, layers=names)
        raise UsageError(finding, file=path, field="--layer")
    points = [
        layer.name for layer in listed_layers if layer.name in names and _may_have_points(layer)
    ]
    requested_names = (points or names) if layer is None else [layer]
    layers = read_layers(path, requested_names, None, reading_error, is_flat=False, has_sheets=True)
    build_table = _sheet_table if kind.key in SPREADSHEETS else _attribute_table
    tables = {layer.name: build_table(path, layer) for layer in layers}
    tables = {name: table for name, table in tables.items() if table.width and len(table)}
    if not tables:
        raise InputError(Finding("table.no-rows"), file=path)
    return _select_table(path, tables)


def _may_have_points(layer: VectorLayer) -> bool:
    return layer.kind is None or "Point" in layer.kind or "Unknown" in layer.kind


def _select_table(path: Path, tables: Mapping[str, TextTable]) -> TextTable:
    """Return the table with orientations, or the first table if none has orientations.

    The tables `planes` and `lines` of this program are joined. Raises UsageError if several other
    tables have orientations.
    """
    candidates = {
        name: table
        for name, table in tables.items()
        if table.names is not None and has_orientations(table.names)
    }
    if len(candidates) > 1 and (layers := [n for n in _OWN_LAYERS if n in candidates]):
        return _join_tables([candidates[name] for name in layers])
    if len(candidates) > 1:
        finding = Finding("drawing.several-layers", layers=list(candidates))
        raise UsageError(finding, file=path, field="--layer")
    return next(iter(candidates.values() or tables.values()))


def _join_tables(tables: list[TextTable]) -> TextTable:
    """Join the rows of several tables; the cells of missing columns are empty."""
    names = tuple(dict.fromkeys(name for table in tables for name in table.names or ()))
    rows = [
        [cells.get(name, "") for name in names]
        for table in tables
        for row in table.rows
        for cells in [dict(zip(table.names or (), row, strict=True))]
    ]
    first_table = tables[0]
    return table_from_cells(
        names, rows, str(first_table.path), first_table.comments, first_table.notes
    )


def _sheet_table(path: Path, sheet: VectorLayer) -> TextTable:
    """Return a sheet of a workbook as a table; the first row with content may be a header."""
    columns = [[_cell(value) for value in values] for values in (sheet.columns or {}).values()]
    rows = [list(row) for row in zip(*columns, strict=True)]
    numbers = [number for number, row in enumerate(rows, 1) if any(row)]
    rows = [row for row in rows if any(row)]
    width = max((i + 1 for row in rows for i, cell in enumerate(row) if cell), default=0)
    rows = [row[:width] for row in rows]
    names = None
    if rows and is_header([cell for cell in rows[0] if cell], ","):
        names, rows, numbers = rows[0], rows[1:], numbers[1:]
    return table_from_cells(names, rows, str(path), numbers=numbers)


def _attribute_table(path: Path, layer: VectorLayer) -> TextTable:
    """Return the attributes of a layer, with the coordinates of its points."""
    columns = {
        name: [_cell(value) for value in values] for name, values in (layer.columns or {}).items()
    }
    crs, points, notes = _positions(path, layer)
    if points is not None:
        _add_coordinates(columns, points)
    rows = [list(row) for row in zip(*columns.values(), strict=True)]
    return table_from_cells(tuple(columns), rows, str(path), (f"CRS: {crs or 'local'}",), notes)


def _positions(
    path: Path, layer: VectorLayer
) -> tuple[str | None, FloatArray | None, tuple[Finding, ...]]:
    """Return the CRS, the coordinates (n, 3) in metres, and findings of a layer's points.

    Degrees are converted to the UTM zone of the points. CRS and coordinates are None if there are
    no points or if they cannot be used. In the latter case a finding is returned
    instead of an error, because the orientations do not depend on the positions.
    """
    import shapely

    if layer.shapes is None or not len(layer.shapes):
        return None, None, ()
    shapes = shapely.from_wkb(layer.shapes, on_invalid="ignore")
    is_point = shapely.get_type_id(shapes) == 0
    if not is_point.any():
        return None, None, ()
    points = np.column_stack(
        [get_coordinate(shapes) for get_coordinate in (shapely.get_x, shapely.get_y, shapely.get_z)]
    )
    points[is_point & np.isnan(points[:, 2]), 2] = 0.0
    finite_points = points[np.isfinite(points).all(axis=1), :2]
    if not len(finite_points):
        return None, None, ()
    bounds = np.array([finite_points.min(axis=0), finite_points.max(axis=0)])
    stated_crs = StatedCrs(layer.crs) if layer.crs is not None else table_crs(path, ())[0]
    if is_geojson_without_crs(path) and np.abs(bounds).max() > MAX_DEGREES:
        stated_crs = StatedCrs()
    try:
        options = FrameOptions()
        if stated_axes(stated_crs.text).kind == "geographic":
            options = FrameOptions(to_crs=suggested_zone(bounds))
        world_points = points_to_world(points, file=path, stated_crs=stated_crs, options=options)
    except InputError as error:
        return None, None, (Finding("table.places-unused", reason=str(error)),)
    notes = tuple(item for item in world_points.findings if item.code != "frame.assumed")
    return world_points.crs, world_points.points, notes


def _add_coordinates(columns: dict[str, list[str]], points: FloatArray) -> None:
    """Add the columns x, y and z; attributes with these names and other values are renamed."""
    for axis, values in zip("xyz", points.T, strict=True):
        cells = ["" if np.isnan(value) else repr(float(value)) for value in values]
        accepted_names = {axis, *COORDINATES[axis]}
        duplicates = [name for name in columns if normalise_name(name) in accepted_names]
        if len(duplicates) == 1 and _is_equal(columns[duplicates[0]], values):
            continue
        for name in duplicates:
            columns[f"{name}_attribute"] = columns.pop(name)
        columns[axis] = cells


def _is_equal(cells: Collection[str], values: FloatArray) -> bool:
    try:
        numbers = np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return False
    return bool(np.allclose(numbers, values, rtol=0.0, atol=_MAX_DIFFERENCE_M, equal_nan=True))


def _cell(value: Any) -> str:
    """Return the text of an attribute; "" if it is missing."""
    if value is None or value != value:
        return ""
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, float | np.floating):
        return f"{float(value):.15g}"
    text = str(value).strip()
    return "" if text == "NaT" else text
