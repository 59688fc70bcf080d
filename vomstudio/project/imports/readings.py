"""Compass readings from a table: columns, north reference, and invalid rows.

Field books are typed by hand, so a row that cannot be read does not affect the other rows: it is
listed with its line number and the reason. The module does not guess anything that the numbers
leave ambiguous: the user decides whether an azimuth is a strike or a dip direction.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding, to_finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.words import tr
from vomstudio.geology.notation import parse_line, parse_plane
from vomstudio.geology.orientation import Line
from vomstudio.geometry.coordinate_limits import check_coordinates, check_longitude_latitude
from vomstudio.geometry.matrices import Point
from vomstudio.geometry.vectors import wrap360
from vomstudio.io.gate.points import ModelFrame, points_to_world
from vomstudio.io.text.flags import is_overturned
from vomstudio.io.text.orientation_reading import parse_plane_cells
from vomstudio.io.text.tables import line_numbers_text
from vomstudio.project.imports.field_table import FieldTable, parse_cell
from vomstudio.project.kinds.reading import Reading

NOTATIONS = ("dipdir/dip", "strike/dip", "strike/dip lhr", "quadrant", "trend/plunge")
"""Meaning of the two angles of a row; the last notation is for lines."""

ToGrid = Callable[[float, float], tuple[float, float] | None]
"""Function that converts longitude and latitude to x and y of the project."""

FRAME_WITHOUT_CRS = ModelFrame()
"""Frame of a project in local coordinates."""

_EMPTY_TEXTS = {"", "-", "–", "nan", "na", "n/a", "none"}


@dataclass(frozen=True)
class FieldRow:
    """Reading as written in the table, before its azimuth is referred to grid north."""

    line: int
    name: str
    geometry: str
    azimuth_deg: float
    inclination_deg: float
    type_name: str = ""
    set_name: str = ""
    position: Point | None = None
    overturned: bool = False
    notes: str = ""
    station: str = ""


@dataclass(frozen=True)
class BadRow:
    """Skipped row of a table with the reason."""

    line: int
    reason: Finding

    def __str__(self) -> str:
        return tr("Line {line}: {reason}", line=self.line, reason=self.reason)


@dataclass(frozen=True)
class FieldReadings:
    """Result of reading a table: valid rows, skipped rows with reasons, and findings."""

    rows: tuple[FieldRow, ...]
    bad_rows: tuple[BadRow, ...]
    findings: tuple[Finding, ...]

    @property
    def type_names(self) -> tuple[str, ...]:
        """Distinct names in the type column, in order of appearance."""
        return tuple(dict.fromkeys(row.type_name for row in self.rows if row.type_name))


# --- reading ---------------------------------------------------------------------------------
def missing_choice(columns: Mapping[str, int], notation: str | None) -> Finding | None:
    """Return a finding about a choice that the user must make before reading, or None."""
    missing_roles = [role for role in ("azimuth", "inclination") if role not in columns]
    if missing_roles and "text" not in columns:
        return Finding("reading.columns-missing", roles=missing_roles)
    return Finding("reading.notation-missing") if notation is None else None


def read_readings(
    table: FieldTable,
    columns: Mapping[str, int],
    notation: str,
    to_grid: ToGrid | None = None,
    model: ModelFrame = FRAME_WITHOUT_CRS,
    line_types: Collection[str] = (),
) -> FieldReadings:
    """Return the readings of a table as written, without referring azimuths to grid north.

    Positions are converted to the World frame if the table states a CRS other than that of the
    project; if the conversion fails, the readings have no position. A line that points up is
    reversed.

    Parameters
    ----------
    table : FieldTable
    columns : mapping of str to int
        Columns by role. The roles are `azimuth` and `inclination` (the two angles of the notation);
        `text` (both angles in one cell); `trend` and `plunge` (for rows that are lines in a table
        of planes); and `name`, `station`, `quadrant`, `element`, `type`, `set`, `overturned`,
        `notes`, `x`, `y`, `z`, `longitude`, `latitude`.
    notation : str
        One of `NOTATIONS`.
    to_grid : callable or None
        Function that converts longitude and latitude to x and y (`io.gis.crs.degrees_to_grid`). If
        None, a position requires x, y and z.
    model : ModelFrame
        Frame of the project.
    line_types : collection of str
        Case-folded names in the type column whose rows are lines, even in a table of planes.

    Raises
    ------
    ValueError
        If the notation is unknown.
    """
    if notation not in NOTATIONS:
        raise ValueError(notation)
    rows: list[FieldRow] = []
    bad_rows: list[BadRow] = []
    flipped_rows: list[int] = []
    unpositioned_rows: list[int] = []
    invalid_positions: list[tuple[int, Finding]] = []
    for i, (cells, line) in enumerate(zip(table.rows, table.lines, strict=True)):
        if i in table.ragged_row_findings:
            bad_rows.append(BadRow(line, table.ragged_row_findings[i]))
            continue
        cells_by_role = {role: cells[column] for role, column in columns.items()}
        try:
            is_line = is_line_row(cells_by_role, line_types)
            geometry, azimuth, inclination = _orientation(
                cells_by_role, notation, table, is_line=is_line
            )
        except InputError as error:
            bad_rows.append(BadRow(line, to_finding(error)))
            continue
        if inclination < 0:
            flipped_rows.append(line)
            azimuth, inclination = float(wrap360(azimuth + 180.0)), -inclination
        position = None
        try:
            position = _position(cells_by_role, table, to_grid)
            if position is None and any(
                cells_by_role.get(role) for role in ("x", "y", "longitude", "latitude")
            ):
                unpositioned_rows.append(line)
        except InputError as error:
            invalid_positions.append((line, to_finding(error)))
        rows.append(
            FieldRow(
                line=line,
                name=cells_by_role.get("name", ""),
                geometry=geometry,
                azimuth_deg=azimuth,
                inclination_deg=inclination,
                type_name=cells_by_role.get("type", ""),
                set_name=cells_by_role.get("set", ""),
                position=position,
                overturned=is_overturned(cells_by_role.get("overturned", "")) is True,
                notes=cells_by_role.get("notes", ""),
                station=cells_by_role.get("station", ""),
            )
        )
    needs_crs = "longitude" in columns and to_grid is None
    findings: Sequence[Finding] = ()
    if "x" in columns and "y" in columns:
        try:
            rows, findings = _rows_in_world(rows, table, model)
        except (InputError, UsageError) as error:
            reason = to_finding(error)
            invalid_positions += [(row.line, reason) for row in rows if row.position is not None]
            rows = [replace(row, position=None) for row in rows]
    row_findings = [
        *_row_findings(flipped_rows, unpositioned_rows, needs_crs),
        *_position_findings(invalid_positions),
    ]
    return FieldReadings(tuple(rows), tuple(bad_rows), (*table.notes, *row_findings, *findings))


def _rows_in_world(
    rows: list[FieldRow], table: FieldTable, model: ModelFrame
) -> tuple[list[FieldRow], Sequence[Finding]]:
    """Convert positions from the CRS of the table. Raises InputError and UsageError."""
    placed_rows = [row for row in rows if row.position is not None]
    if not placed_rows:
        return rows, ()
    world = points_to_world(
        np.array([row.position for row in placed_rows], np.float64),
        file=table.path,
        comments=table.comments,
        model=model,
    )
    positions: dict[int, Point] = {
        row.line: (x, y, z)
        for row, (x, y, z) in zip(placed_rows, world.points.tolist(), strict=True)
    }
    return [replace(row, position=positions.get(row.line)) for row in rows], world.findings


def _row_findings(
    flipped_indices: list[int], unpositioned_indices: list[int], needs_crs: bool
) -> list[Finding]:
    """Return findings for rows that were reversed or have no position."""
    findings = []
    if flipped_indices:
        findings.append(_rows_finding("reading.upward", flipped_indices))
    if unpositioned_indices:
        code = "reading.degrees-without-crs" if needs_crs else "reading.coordinate-missing"
        findings.append(_rows_finding(code, unpositioned_indices))
    return findings


def _position_findings(rows: list[tuple[int, Finding]]) -> list[Finding]:
    """Return findings for invalid positions, whose readings are used without a position."""
    if not rows:
        return []
    reason = rows[0][1]
    return [
        _rows_finding(
            "reading.no-position",
            [line for line, _ in rows],
            reason=reason.message,
            reason_code=reason.code,
        )
    ]


def _rows_finding(code: str, lines: list[int], **values: str) -> Finding:
    return Finding(code, count=len(lines), rows=lines, lines=line_numbers_text(lines), **values)


def is_line_row(cells_by_role: Mapping[str, str], line_types: Collection[str]) -> bool:
    """Return whether the element or the type of a row states that it is a line.

    Parameters
    ----------
    cells_by_role : mapping of str to str
    line_types : collection of str
        Case-folded names of types whose rows are lines.

    Returns
    -------
    bool
    """
    element = cells_by_role.get("element", "").casefold()
    return element.startswith("line") or (
        not element and cells_by_role.get("type", "").casefold() in line_types
    )


def _orientation(
    word: Mapping[str, str], notation: str, table: FieldTable, *, is_line: bool
) -> tuple[str, float, float]:
    """Return "plane" or "line", azimuth and inclination of a row. Raises InputError."""
    angles = [word.get("azimuth", ""), word.get("inclination", "")]
    is_empty = all(cell.casefold() in _EMPTY_TEXTS for cell in (*angles, word.get("text", "")))
    if word.get("plunge", "") and (is_line or is_empty):
        return _line(word.get("trend", ""), word["plunge"], table)
    if word.get("text", "").casefold() not in _EMPTY_TEXTS:
        if notation == "trend/plunge" or is_line:
            line = parse_line(word["text"])
            return "line", line.trend_deg, line.plunge_deg
        plane = parse_plane(word["text"], notation)
        return "plane", plane.dip_direction_deg, plane.dip_deg
    if is_empty:
        raise InputError(Finding("reading.no-angle", missing=("azimuth", "inclination")))
    if angles[0].casefold() in _EMPTY_TEXTS:
        raise InputError(Finding("reading.no-angle", missing=("azimuth",)))
    if angles[1].casefold() in _EMPTY_TEXTS:
        raise InputError(Finding("reading.no-angle", missing=("inclination",)))
    if notation == "trend/plunge" or is_line:
        return _line(angles[0], angles[1], table)
    azimuth, dip = (parse_cell(cell, table) for cell in angles)
    if (
        notation == "dipdir/dip"
        and azimuth is not None
        and dip is not None
        and 0.0 <= azimuth <= 360.0
        and 0.0 <= dip <= 90.0
    ):
        return "plane", float(wrap360(azimuth)) if dip else 0.0, dip
    if azimuth is not None and azimuth > 360.0:
        raise InputError(
            Finding("angle.out-of-range", angle="azimuth", value=azimuth, minimum=0, maximum=360)
        )
    if dip is not None and dip < 0.0:
        # In a single text, a minus may separate two numbers; in a separate cell it is an error.
        raise InputError(
            Finding("angle.out-of-range", angle="dip", value=dip, minimum=0, maximum=90)
        )
    quadrant = word.get("quadrant", "") if notation in ("quadrant", "strike/dip") else ""
    plane = parse_plane_cells((*angles, quadrant) if quadrant else tuple(angles), notation)
    return "plane", plane.dip_direction_deg, plane.dip_deg


def _line(trend: str, plunge: str, table: FieldTable) -> tuple[str, float, float]:
    a, b = parse_cell(trend, table), parse_cell(plunge, table)
    if a is not None and b is not None:
        if not 0.0 <= a <= 360.0:
            raise InputError(
                Finding("angle.out-of-range", angle="trend", value=a, minimum=0, maximum=360)
            )
        if not -90.0 <= b <= 90.0:
            raise InputError(
                Finding("angle.out-of-range", angle="plunge", value=b, minimum=-90, maximum=90)
            )
        line = Line(a, b)
    else:
        line = parse_line(f"{trend} {plunge}")
    return "line", line.trend_deg, line.plunge_deg


def _position(word: Mapping[str, str], table: FieldTable, to_grid: ToGrid | None) -> Point | None:
    """Return the position of a row, or None if a coordinate is missing.

    Raises InputError for coordinates that are not on Earth.
    """
    x, y, z, longitude, latitude = (
        parse_cell(word.get(role, ""), table) for role in ("x", "y", "z", "longitude", "latitude")
    )
    finding = check_coordinates(value for value in (x, y, z) if value is not None)
    if longitude is not None and latitude is not None:
        finding = finding or check_longitude_latitude(longitude, latitude)
    if finding is not None:
        raise InputError(finding)
    if (x is None or y is None) and to_grid and longitude is not None and latitude is not None:
        grid = to_grid(longitude, latitude)
        x, y = grid if grid is not None else (None, None)
    if x is None or y is None or z is None:
        return None
    return x, y, z


# --- records ---------------------------------------------------------------------------------
def make_readings(
    rows: Sequence[FieldRow],
    *,
    type_ids: Mapping[str, str],
    type_id: str,
    set_name: str = "",
    turn_deg: float = 0.0,
    source: str = "",
) -> list[Reading]:
    """Create records from the rows, with azimuths referred to grid north.

    Parameters
    ----------
    rows : sequence of FieldRow
    type_ids : mapping of str to str
        Type IDs by case-folded name in the type column.
    type_id, set_name : str
        Type and set of rows that do not state one.
    turn_deg : float
        Angle added to each azimuth, in degrees. The azimuth of a horizontal plane or a vertical
        line stays 0.
    source : str, optional
        Name of the table.
    """
    readings = []
    for row in rows:
        is_undefined = row.inclination_deg == (0.0 if row.geometry == "plane" else 90.0)
        azimuth = 0.0 if is_undefined else float(wrap360(row.azimuth_deg + turn_deg))
        readings.append(
            Reading(
                id=new_id("reading"),
                name=row.name,
                type_id=type_ids.get(row.type_name.casefold(), type_id)
                if row.type_name
                else type_id,
                geometry="line" if row.geometry == "line" else "plane",
                azimuth_deg=azimuth,
                inclination_deg=row.inclination_deg,
                turned_deg=turn_deg,
                position=row.position,
                source=source,
                set_name=row.set_name or set_name,
                overturned=row.overturned,
                notes=row.notes,
                station=row.station,
            )
        )
    return readings
