"""Conversion between tables of orientations and DataFrames."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from vomstudio.api.checking import (
    check_choice,
    is_path,
    looks_like_radians,
    name_argument_in_errors,
    optional_text,
    required_text,
    to_array_pair,
    to_path,
    warn,
    wrong_type_error,
)
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Line, Plane
from vomstudio.io.gate import orientation_files
from vomstudio.io.gate.orientation_files import read_any_table
from vomstudio.io.text.column_mapping import parse_meaning
from vomstudio.io.text.column_names import normalise_name
from vomstudio.io.text.flags import parse_flag
from vomstudio.io.text.orientation_columns import ALIASES
from vomstudio.io.text.orientation_reading import OrientationTable, extract_orientations
from vomstudio.io.text.registration_comments import stated_registrations
from vomstudio.io.text.tables import TextTable, table_from_cells
from vomstudio.project import catalogue
from vomstudio.project.picks import read_picks
from vomstudio.project.tables.orientation_table import COLUMNS, Row, line_row, orientation_row
from vomstudio.project.tables.registration_comments import registration_lines

if TYPE_CHECKING:
    import pandas

    from vomstudio.api.argument_types import PathArgument

FORMS = {figure.name: figure.form for figure in catalogue.ORIENTATION}
TABLE_IN_MEMORY = "the table"
_ANGLE_MEANINGS = (
    "dip direction",
    "strike",
    "dip",
    "quadrant",
    "azimuth",
    "inclination",
    "trend",
    "plunge",
    "pole trend",
    "pole plunge",
    "attitude",
)

Azimuth = Literal["strike", "dipdir"]


def read_orientations(
    path: PathArgument,
    *,
    azimuth: Azimuth | None = None,
    columns: Mapping[str, str] | None = None,
    layer: str | None = None,
) -> pandas.DataFrame:
    """Read planes and lines from a table, a point layer or a workbook.

    Parameters
    ----------
    path : str or Path
        Text table with any delimiter, GeoPackage, GeoJSON, shapefile or workbook (.xlsx, .ods)
        with dip directions and dips, right-hand-rule strikes and dips (with or without a
        quadrant), trends and plunges of poles or lines, declinations and inclinations, normals,
        both angles in one cell, or the columns of this program.
    azimuth : {"strike", "dipdir"}, optional
        Meaning of a column named only ``azimuth``, or of the first column if there is no
        header: "strike" or "dipdir".
    columns : dict of str to str, optional
        Meaning of columns by name, or by number from 1, such as
        ``{"azi": "dip_direction", "inc": "dip"}``.
    layer : str, optional
        Layer of a GIS file, or sheet of a workbook, if several contain orientations.

    Returns
    -------
    DataFrame
        DataFrame with the columns of the orientation table (angles in degrees) and one row
        per plane or line, followed by the other columns of the file.
        ``.attrs["convention"]`` states how the columns were interpreted,
        ``.attrs["dropped_lines"]`` lists the lines without angles, and
        ``.attrs["warnings"]`` contains the warnings, which are also issued as Python
        warnings. ``.attrs["registrations"]`` contains the covariance of the rotation of each
        registration if the file states it.

    Raises
    ------
    vs.errors.InputError
        If an angle is invalid (such as a dip above 90; the error states the file, line and
        column), or the file does not contain a table.
    vs.errors.UsageError
        If the meaning of an azimuth must be stated by the caller.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> import vomstudio as vs
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "beds.csv"
    >>> _ = path.write_text("strike,dip" + chr(10) + "30,45" + chr(10) + "120,60")
    >>> beds = vs.read_orientations(path)
    >>> beds[["dip_direction_deg", "dip_deg", "strike_rhr_deg"]].values.tolist()
    [[120.0, 45.0, 30.0], [210.0, 60.0, 120.0]]
    >>> beds.attrs["convention"]
    "planes as strike (right-hand rule)/dip ('strike', 'dip')"
    """
    table = orientation_files.read_orientations(
        to_path(path, "path"),
        check_azimuth(azimuth),
        columns=check_columns(columns),
        layer=optional_text(layer, "layer"),
        repeats=True,
    )
    findings = _table_findings(table)
    warn(findings)
    return table_to_dataframe(table, findings)


def check_azimuth(azimuth: Any) -> Azimuth | None:
    """Check the option for the meaning of azimuths.

    Parameters
    ----------
    azimuth : object

    Returns
    -------
    Azimuth or None

    Raises
    ------
    InputError
        If the value is unknown.
    """
    if azimuth is None:
        return None
    check_choice(azimuth, ("strike", "dipdir"), "azimuth")
    return azimuth  # type: ignore[no-any-return]


def check_columns(columns: Any) -> dict[str, str]:
    """Check the stated meanings of columns.

    Parameters
    ----------
    columns : object

    Returns
    -------
    dict of str to str

    Raises
    ------
    InputError, UsageError
        If the value is not a mapping of texts, or a meaning is unknown.
    """
    if columns is None:
        return {}
    if not isinstance(columns, Mapping):
        raise wrong_type_error(columns, "dict[str, str]", "columns")
    with name_argument_in_errors("columns", "--columns"):
        return {
            str(name): parse_meaning(required_text(meaning, "columns"))
            for name, meaning in columns.items()
        }


def to_orientation_table(
    table: Any,
    azimuth: Azimuth | None = None,
    depth: int = 4,
    name: str = "table",
    *,
    repeats: bool = False,
    azimuth_only: bool = False,
) -> OrientationTable:
    """Convert a DataFrame, a file or a pair (dip direction, dip) to an orientation table.

    Warnings of the table are issued as Python warnings.

    Parameters
    ----------
    table : DataFrame, path or pair of array_like
    azimuth : {"dipdir", "strike"}, optional
        Meaning of the azimuths if the table does not state it.
    depth : int
        Stack level of the user's line for `checking.warn`.
    name : str
        Name of the argument.
    repeats, azimuth_only : bool
        As for `read_orientations` of `vomstudio.io.gate.orientation_files`.

    Returns
    -------
    OrientationTable

    Raises
    ------
    InputError, UsageError
    """
    azimuth = check_azimuth(azimuth)
    if is_path(table):
        rows = read_picks(to_path(table, name), azimuth, repeats=repeats, azimuth_only=azimuth_only)
    elif hasattr(table, "columns") and hasattr(table, "itertuples"):
        names, cells = _to_cells(_drop_stated_angles(table), name)
        registrations = registration_lines(getattr(table, "attrs", {}).get("registrations", ()))
        comments = (*registrations, f"CRS: {dataframe_crs(table) or 'local'}")
        text_table = table_from_cells(names, cells, TABLE_IN_MEMORY, comments)
        rows = extract_orientations(text_table, azimuth, repeats=repeats, azimuth_only=azimuth_only)
    else:
        rows = extract_orientations(_table_from_arrays(table, name), None)
    warn(_table_findings(rows), depth)
    return rows


def _drop_stated_angles(frame: Any) -> Any:
    """Drop the original angle columns if a DataFrame comes from `read_orientations`."""
    if not set(COLUMNS) <= set(frame.columns):
        return frame
    angles = {word for meaning in _ANGLE_MEANINGS for word in ALIASES[meaning]}
    original_columns = {
        c for c in frame.columns if c not in COLUMNS and normalise_name(str(c)) in angles
    }
    return frame.drop(columns=list(original_columns)) if original_columns else frame


def to_text_table(table: Any, name: str = "table") -> TextTable:
    """Convert a DataFrame or a file to a table of texts.

    Parameters
    ----------
    table : DataFrame or path
    name : str, optional
        Name of the argument.

    Returns
    -------
    TextTable

    Raises
    ------
    InputError
        If the value is not a table, is empty or cannot be read.
    """
    if is_path(table):
        return read_any_table(to_path(table, name))
    if not (hasattr(table, "columns") and hasattr(table, "itertuples")):
        raise wrong_type_error(table, "pandas.DataFrame, str, pathlib.Path", name)
    names, cells = _to_cells(table, name)
    return table_from_cells(
        names, cells, TABLE_IN_MEMORY, comments=(f"CRS: {dataframe_crs(table) or 'local'}",)
    )


def dataframe_crs(table: Any) -> str | None:
    """Return the CRS of a GeoDataFrame as single-line WKT.

    Parameters
    ----------
    table : object

    Returns
    -------
    str or None
        WKT, or None for any other table.
    """
    crs = getattr(table, "crs", None)
    return str(crs.to_wkt()) if crs is not None and hasattr(crs, "to_wkt") else None


def _table_findings(table: OrientationTable) -> list[Finding]:
    angles = (
        (table.dip_direction_deg, table.dip_deg),
        (table.trend_deg, table.plunge_deg),
    )
    has_radians = any(looks_like_radians(azimuth, angle) for azimuth, angle in angles)
    return [*table.warnings, *([Finding("compass.radians")] if has_radians else [])]


def _table_from_arrays(value: Any, name: str) -> Any:
    names = ("dip_direction", "dip")
    if isinstance(value, Mapping) or not isinstance(value, Sequence | np.ndarray):
        raise _not_a_table_error(value, name)
    if len(value) != 2:
        raise _not_a_table_error(value, name)
    azimuth, dip = to_array_pair(value[0], value[1], names)
    cells = [[repr(float(a)), repr(float(d))] for a, d in zip(azimuth, dip, strict=True)]
    return table_from_cells(names, cells, TABLE_IN_MEMORY)


def _not_a_table_error(value: Any, name: str) -> InputError:
    return wrong_type_error(
        value, "pandas.DataFrame, str, pathlib.Path, (dip_directions, dips)", name
    )


# --- DataFrame to cells ---------------------------------------------------------------------------
def _to_cells(frame: Any, argument: str) -> tuple[list[str], list[list[str]]]:
    """Return the names and cells of the columns of a DataFrame, without geometry columns."""
    names, columns = [], []
    for column_index, name in enumerate(frame.columns):
        values = frame.iloc[:, column_index].tolist()
        if any(hasattr(value, "geom_type") for value in values[:100]):
            continue
        names.append(str(name))
        columns.append([_cell_text(value) for value in values])
    if not names or not len(frame):
        raise InputError(Finding("argument.empty"), field=argument)
    return names, [list(row) for row in zip(*columns, strict=True)]


def _cell_text(value: Any) -> str:
    """Return the text of a cell; floats keep all digits."""
    if value is None or value != value:
        return ""
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, float | np.floating):
        return repr(float(value))
    text = str(value)
    return "" if text == "<NA>" else text


# --- rows to DataFrame ----------------------------------------------------------------------------
def frame(rows: Iterable[Mapping[str, Any]], columns: Sequence[str] = COLUMNS) -> Any:
    """Convert rows of the orientation table to a DataFrame.

    Numbers are float64, with NaN if not applicable. Counts are integers if all rows have a count.
    Missing texts are represented by None.

    Parameters
    ----------
    rows : iterable of mapping
    columns : sequence of str, optional

    Returns
    -------
    DataFrame
    """
    import pandas

    row_list = list(rows)
    dataframe = {
        name: _to_series([row.get(name) for row in row_list], FORMS.get(name, "text"))
        for name in columns
    }
    return pandas.DataFrame(dataframe, columns=list(columns))


def _to_series(values: list[Any], form: str) -> Any:
    import pandas

    if form == "text":
        return pandas.Series(values, dtype=object)
    if form == "flag":
        is_complete = all(value is not None for value in values)
        return pandas.Series(values, dtype=bool if is_complete and values else object)
    floats = np.array([np.nan if v is None else float(v) for v in values], np.float64)
    if form == "count" and len(floats) and np.isfinite(floats).all():
        return pandas.Series(floats.astype(np.int64))
    return pandas.Series(floats)


def table_to_dataframe(table: OrientationTable, warnings: Sequence[Finding]) -> Any:
    """Convert all rows of a table to a DataFrame, with the other columns appended.

    Parameters
    ----------
    table : OrientationTable
    warnings : sequence of Finding
        Warnings, stored in ``.attrs["warnings"]``.

    Returns
    -------
    DataFrame
    """
    import pandas

    table_cells, other_cells = _other_cells(table)
    rows = [_row_values(table, i, table_cells) for i in range(len(table))]
    dataframe = frame(rows)
    other_columns = {name: _to_numbers(cells) for name, cells in other_cells.items()}
    if other_columns:
        dataframe = pandas.concat([dataframe, pandas.DataFrame(other_columns)], axis=1)
    dataframe.attrs["convention"] = table.convention
    dataframe.attrs["dropped_lines"] = list(table.dropped)
    dataframe.attrs["warnings"] = list(warnings)
    dataframe.attrs["registrations"] = stated_registrations(table.table.comments)
    return dataframe


def _row_values(table: OrientationTable, i: int, table_cells: Mapping[str, list[str]]) -> Row:
    metadata: dict[str, Any] = {"id": table.ids[i]}
    if table.kinds is not None:
        metadata["kind"] = table.kinds[i] or None
    if table.sets is not None:
        metadata["set"] = table.sets[i] or None
    if table.overturned is not None:
        metadata["overturned"] = table.overturned[i]
    if table.is_plane[i]:
        plane = Plane(float(table.dip_direction_deg[i]), float(table.dip_deg[i]))
        row = orientation_row(plane, **metadata)
    else:
        line = Line(float(table.trend_deg[i]), float(table.plunge_deg[i]))
        row = line_row(line, **metadata)
    for name, cells in table_cells.items():
        if row[name] is None:
            row[name] = _parse_cell(cells[i], FORMS[name])
    return row


def _other_cells(
    table: OrientationTable,
) -> tuple[dict[str, list[str]], dict[str, list[str]]]:
    """Return the cells of the used rows, split into orientation columns and other columns."""
    table_cells: dict[str, list[str]] = {}
    other_cells: dict[str, list[str]] = {}
    for column_index, name in enumerate(table.table.names or ()):
        cells = table.table.cells(column_index)
        row_list = [cells[i] for i in table.row_indices]
        if name in COLUMNS:
            table_cells[name] = row_list
        else:
            other_cells.setdefault(name, row_list)
    return table_cells, other_cells


def _parse_cell(cell: str, form: str) -> Any:
    if not cell:
        return None
    if form == "text":
        return cell
    if form == "flag":
        return parse_flag(cell) is True
    try:
        number = float(cell)
    except ValueError:
        return None
    return number if np.isfinite(number) else None


def _to_numbers(cells: list[str]) -> Any:
    import pandas

    try:
        return pandas.Series([float(c) if c else np.nan for c in cells])
    except ValueError:
        return pandas.Series(cells, dtype=object)
