"""Tables of orientations as DataFrames, and the other way round."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np

from vomstudio.api.checking import (
    is_path,
    looks_like_radians,
    one_of,
    pairs,
    path_of,
    warn,
    wrong_type,
)
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Line, Plane
from vomstudio.io.text import orientation_reading
from vomstudio.io.text.column_names import normalise_name
from vomstudio.io.text.flags import parse_flag
from vomstudio.io.text.orientation_columns import ALIASES
from vomstudio.io.text.orientation_reading import OrientationTable, extract_orientations
from vomstudio.io.text.registration_comments import stated_registrations
from vomstudio.io.text.tables import TextTable, read_table, table_from_cells
from vomstudio.project import catalogue
from vomstudio.project.tables.orientation_table import COLUMNS, Row, line_row, orientation_row
from vomstudio.project.tables.registration_comments import registration_lines

FORMS = {figure.name: figure.form for figure in catalogue.ORIENTATION}
_IN_MEMORY = "the table"
_ANGLES = (
    "dip direction",
    "strike",
    "dip",
    "quadrant",
    "azimuth",
    "trend",
    "plunge",
    "pole trend",
    "pole plunge",
    "attitude",
)

Azimuth = Literal["strike", "dipdir"]


def read_orientations(path: str | Path, *, azimuth: Azimuth | None = None) -> Any:
    """Planes and lines of a text table, whatever its delimiter and convention.

    Parameters
    ----------
    path : CSV or text with a dip direction and dip, a right-hand-rule strike and dip (with or
        without a quadrant), the trend and plunge of poles or lines, or the columns of this program
    azimuth : what a column called only ``azimuth``, or the first of a table without header, means:
        "strike" or "dipdir"

    Returns
    -------
    DataFrame with the columns of the orientation table, angles in degrees, one row for each plane
    or line; columns of the file that the table does not have follow. ``.attrs["convention"]`` says
    how the columns were understood, ``.attrs["dropped_lines"]`` which lines had no angles,
    ``.attrs["warnings"]`` what was noticed, each of which is a Python warning as well,
    ``.attrs["registrations"]`` the covariance of each registration's rotation where the file states
    it.

    Raises
    ------
    vs.errors.InputError, which names file, line and column, for angles that cannot be (a dip over
    90) and tables that are none; vs.errors.UsageError where the meaning of an azimuth must be told.

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
    table = orientation_reading.read_orientations(
        path_of(path, "path"), meaning_of(azimuth), repeats=True
    )
    messages = _noticed(table)
    warn(messages)
    return frame_of_table(table, messages)


def meaning_of(azimuth: Any) -> Azimuth | None:
    """Check the meaning of an azimuth. Raises InputError."""
    if azimuth is None:
        return None
    one_of(azimuth, ("strike", "dipdir"), "azimuth")
    return azimuth  # type: ignore[no-any-return]


def rows_of(
    table: Any,
    azimuth: Azimuth | None = None,
    depth: int = 4,
    name: str = "table",
    *,
    repeats: bool = False,
) -> OrientationTable:
    """Return planes and lines of a DataFrame, a file, or two arrays (dip direction, dip).

    Issues the warnings of the table as Python warnings. depth : stack depth of this call below the
    user's line; name : argument name; repeats : whether rows that repeat a pick are included
    Raises InputError and UsageError.
    """
    azimuth = meaning_of(azimuth)
    if is_path(table):
        path = path_of(table, name)
        rows = orientation_reading.read_orientations(path, azimuth, repeats=repeats)
    elif hasattr(table, "columns") and hasattr(table, "itertuples"):
        names, cells = _cells_of(_without_claims(table), name)
        registrations = registration_lines(getattr(table, "attrs", {}).get("registrations", ()))
        comments = (*registrations, f"CRS: {dataframe_crs(table) or 'local'}")
        text_table = table_from_cells(names, cells, _IN_MEMORY, comments)
        rows = extract_orientations(text_table, azimuth, repeats=repeats)
    else:
        rows = extract_orientations(_arrays(table, name), None)
    warn(_noticed(rows), depth)
    return rows


def _without_claims(frame: Any) -> Any:
    """Drop the original angle columns of a DataFrame made by `read_orientations`."""
    if not set(COLUMNS) <= set(frame.columns):
        return frame
    angles = {word for meaning in _ANGLES for word in ALIASES[meaning]}
    claimed = {c for c in frame.columns if c not in COLUMNS and normalise_name(str(c)) in angles}
    return frame.drop(columns=list(claimed)) if claimed else frame


def text_of(table: Any, name: str = "table") -> TextTable:
    """Return a DataFrame or a file as a table of texts. name : argument name. Raises InputError."""
    if is_path(table):
        return read_table(path_of(table, name))
    if not (hasattr(table, "columns") and hasattr(table, "itertuples")):
        raise wrong_type(table, "pandas.DataFrame, str, pathlib.Path", name)
    names, cells = _cells_of(table, name)
    return table_from_cells(
        names, cells, _IN_MEMORY, comments=(f"CRS: {dataframe_crs(table) or 'local'}",)
    )


def dataframe_crs(table: Any) -> str | None:
    """Return the CRS of a GeoDataFrame as WKT in one line; None for any other table."""
    crs = getattr(table, "crs", None)
    return str(crs.to_wkt()) if crs is not None and hasattr(crs, "to_wkt") else None


def _noticed(table: OrientationTable) -> list[Finding]:
    angles = (
        (table.dip_direction_deg, table.dip_deg),
        (table.trend_deg, table.plunge_deg),
    )
    radians = any(looks_like_radians(azimuth, angle) for azimuth, angle in angles)
    return [*table.warnings, *([Finding("compass.radians")] if radians else [])]


def _arrays(given: Any, name: str) -> Any:
    names = ("dip_direction", "dip")
    if isinstance(given, Mapping) or not isinstance(given, Sequence | np.ndarray):
        raise _not_a_table(given, name)
    if len(given) != 2:
        raise _not_a_table(given, name)
    azimuth, dip = pairs(given[0], given[1], names)
    cells = [[repr(float(a)), repr(float(d))] for a, d in zip(azimuth, dip, strict=True)]
    return table_from_cells(names, cells, _IN_MEMORY)


def _not_a_table(value: Any, name: str) -> InputError:
    return wrong_type(value, "pandas.DataFrame, str, pathlib.Path, (dip_directions, dips)", name)


# --- DataFrame to cells ---------------------------------------------------------------------------
def _cells_of(frame: Any, argument: str) -> tuple[list[str], list[list[str]]]:
    """Names and cells of a DataFrame; columns of shapes are left out."""
    names, columns = [], []
    for place, name in enumerate(frame.columns):
        values = frame.iloc[:, place].tolist()
        if any(hasattr(value, "geom_type") for value in values[:100]):
            continue
        names.append(str(name))
        columns.append([_cell(value) for value in values])
    if not names or not len(frame):
        raise InputError(Finding("argument.empty"), field=argument)
    return names, [list(row) for row in zip(*columns, strict=True)]


def _cell(value: Any) -> str:
    """As a text table has it; floats with all their digits."""
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
    """Rows of the orientation table as a DataFrame: numbers are float64 with NaN where they do not
    apply, counts whole where all have one, texts None."""
    import pandas

    kept = list(rows)
    made = {
        name: _column([row.get(name) for row in kept], FORMS.get(name, "text")) for name in columns
    }
    return pandas.DataFrame(made, columns=list(columns))


def _column(values: list[Any], form: str) -> Any:
    import pandas

    if form == "text":
        return pandas.Series(values, dtype=object)
    if form == "flag":
        whole = all(value is not None for value in values)
        return pandas.Series(values, dtype=bool if whole and values else object)
    floats = np.array([np.nan if v is None else float(v) for v in values], np.float64)
    if form == "count" and len(floats) and np.isfinite(floats).all():
        return pandas.Series(floats.astype(np.int64))
    return pandas.Series(floats)


def frame_of_table(table: OrientationTable, warnings: Sequence[Finding]) -> Any:
    """All rows of a table that was read, with its other columns behind."""
    import pandas

    own, others = _other_cells(table)
    rows = [_row(table, i, own) for i in range(len(table))]
    made = frame(rows)
    extra = {name: _as_numbers(cells) for name, cells in others.items()}
    if extra:
        made = pandas.concat([made, pandas.DataFrame(extra)], axis=1)
    made.attrs["convention"] = table.convention
    made.attrs["dropped_lines"] = list(table.dropped)
    made.attrs["warnings"] = list(warnings)
    made.attrs["registrations"] = stated_registrations(table.table.comments)
    return made


def _row(table: OrientationTable, i: int, own: Mapping[str, list[str]]) -> Row:
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
    for name, cells in own.items():
        if row[name] is None:
            row[name] = _value(cells[i], FORMS[name])
    return row


def _other_cells(
    table: OrientationTable,
) -> tuple[dict[str, list[str]], dict[str, list[str]]]:
    """Cells of the kept rows in columns that are ours by name, and in columns that nobody knows."""
    own: dict[str, list[str]] = {}
    others: dict[str, list[str]] = {}
    for place, name in enumerate(table.table.names or ()):
        cells = table.table.cells(place)
        kept = [cells[i] for i in table.row_indices]
        if name in COLUMNS:
            own[name] = kept
        else:
            others.setdefault(name, kept)
    return own, others


def _value(cell: str, form: str) -> Any:
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


def _as_numbers(cells: list[str]) -> Any:
    import pandas

    try:
        return pandas.Series([float(c) if c else np.nan for c in cells])
    except ValueError:
        return pandas.Series(cells, dtype=object)
