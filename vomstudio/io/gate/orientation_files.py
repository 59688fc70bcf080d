"""Reading of planes, lines and fault slips from text tables, GIS layers and workbooks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from vomstudio.core.errors import UsageError
from vomstudio.core.files.file_kinds import find_file_kind
from vomstudio.core.findings import Finding
from vomstudio.io.text.column_mapping import name_columns
from vomstudio.io.text.file_text import MAX_OBJECTS
from vomstudio.io.text.orientation_columns import Azimuth, has_orientations
from vomstudio.io.text.orientation_reading import OrientationTable, extract_orientations
from vomstudio.io.text.rows import split_cells
from vomstudio.io.text.slip_reading import SlipTable, extract_slips, has_fault_rows
from vomstudio.io.text.tables import TextTable, read_table

LAYER_KINDS = frozenset({"geojson", "geopackage", "shapefile", "xlsx", "ods"})
"""Kinds of files whose layers or sheets are read as tables."""
LAYER_EXTENSIONS = (".gpkg", ".geojson", ".json", ".shp", ".xlsx", ".ods")
"""Usual extensions of such files, for file dialogs."""
NO_COLUMNS: Mapping[str, str] = {}


def is_layer_file(path: str | Path) -> bool:
    """Return whether a file is read as a layer or as a workbook, from its content.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    bool
    """
    kind = find_file_kind(path)
    return kind is not None and kind.key in LAYER_KINDS


def read_any_table(
    path: str | Path, layer: str | None = None, *, has_header: bool = False
) -> TextTable:
    """Read a text table, or the attributes of a GIS layer or the sheet of a workbook.

    Parameters
    ----------
    path : str or Path
        Text table, GeoPackage, GeoJSON, shapefile or workbook.
    layer : str, optional
        Name of the layer or sheet, required if several contain orientations.
    has_header : bool
        As for `vomstudio.io.text.rows.read_rows`.

    Raises
    ------
    InputError
        If the file cannot be read.
    UsageError
        If the layer is missing (as in a text table), or several layers contain orientations.
    """
    path = Path(path)
    if is_layer_file(path):
        kind = find_file_kind(path)
        assert kind is not None
        # Most tables are text and do not need the libraries of GIS files.
        from vomstudio.io.gate.attribute_tables import read_layer_table

        return read_layer_table(path, kind, layer)
    if layer is not None:
        raise UsageError(Finding("table.no-layers", layer=layer), file=path, field="--layer")
    return _use_commented_header(read_table(path, has_header=has_header, max_lines=MAX_OBJECTS))


def _use_commented_header(table: TextTable) -> TextTable:
    """Use the last comment such as #Strike Dip as the header of a table without a header.

    Tables that have a header or no such comment are unchanged.
    """
    if table.names is not None:
        return table
    for comment in reversed(table.comments):
        names = tuple(split_cells(comment, table.delimiter))
        if len(names) == table.width and all(names) and has_orientations(names):
            return replace(table, names=names)
    return table


def read_orientations(
    path: str | Path,
    azimuth: Azimuth | None = None,
    *,
    columns: Mapping[str, str] = NO_COLUMNS,
    layer: str | None = None,
    repeats: bool = False,
    azimuth_only: bool = False,
) -> OrientationTable:
    """Read planes and lines from a table, a point layer or a workbook.

    Parameters
    ----------
    path : str or Path
        Text table, GeoPackage, GeoJSON, shapefile or workbook.
    azimuth : {"strike", "dipdir"}, optional
        Meaning of a column named `azimuth`, or of the first column in a table without a header.
    columns : mapping of str to str
        Meaning of columns by name or number; see `vomstudio.io.text.column_mapping`.
    layer : str, optional
        Layer or sheet that contains the table.
    repeats : bool
        Whether to include rows that repeat another pick according to the column `repeat_of`.
    azimuth_only : bool
        Whether a table may contain azimuths without dips or plunges, which become NaN.

    Raises
    ------
    InputError
        If the table or its angles are not valid; states file, line and column.
    UsageError
        If an option is required but not given, or does not match the file.
    """
    table = name_columns(read_any_table(path, layer), columns)
    return extract_orientations(table, azimuth, repeats=repeats, azimuth_only=azimuth_only)


def read_slips(
    path: str | Path,
    azimuth: Azimuth | None = None,
    *,
    columns: Mapping[str, str] = NO_COLUMNS,
    layer: str | None = None,
) -> SlipTable:
    """Read a table of faults with slip.

    Parameters
    ----------
    path, azimuth, columns, layer
        As for `read_orientations`.

    Raises
    ------
    InputError
        If columns are missing, angles or senses of slip are not valid, or no row is complete;
        states file, line and column.
    UsageError
        As for `read_orientations`.
    """
    # Rows without a header may contain a word for the sense of slip.
    table = read_any_table(path, layer, has_header=True)
    if table.names is None and not columns and not has_fault_rows(table):
        table = read_any_table(path, layer)
    return extract_slips(name_columns(table, columns), azimuth)
