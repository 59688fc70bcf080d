"""Reading of orientation tables written by this and other programs.

A table of planes contains a dip direction or a strike, and a dip; a table of lines contains a trend
and a plunge; tables of this program contain both. The meaning is determined by the column name. An
unspecific `azimuth`, or two columns without a header, may be a strike or a dip direction, so the
user must state which one it is. The convention that was used is reported.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.errors import InputError, UsageError, VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geology.common_rotation_errors import RotationErrors
from vomstudio.geology.notation import parse_line, parse_plane
from vomstudio.geology.orientation import Plane, lines_to_vectors, planes_to_poles
from vomstudio.geometry.vectors import wrap360
from vomstudio.io.text.column_names import normalise_name
from vomstudio.io.text.orientation_columns import (
    Azimuth,
    OrientationColumns,
    has_orientations,
    is_attitude,
    parse_convention,
)
from vomstudio.io.text.registration_comments import stated_bowing_deg, table_rotation_errors
from vomstudio.io.text.repeated_rows import exclude_repeats
from vomstudio.io.text.rows import shorten
from vomstudio.io.text.tables import TextTable

_QUADRANT_NAMES = {"direction", "dir", "side", "sense", "dips"}
"""Column names that denote a dip quadrant if the cells are compass points."""
_PLANE, _LINE, _NONE = 1, 2, 0
FILE_NAME_CONVENTION = to_translate("no header: strike or dip direction according to the file name")


@dataclass(frozen=True, eq=False)
class OrientationTable:
    """Table of planes and lines (n); values are NaN if a row does not have that geometry."""

    table: TextTable
    row_indices: IntArray
    """Rows (n,) of `table` that contain angles."""
    is_plane: BoolArray
    dip_direction_deg: FloatArray
    dip_deg: FloatArray
    trend_deg: FloatArray
    """Trends (n,) of lines; the azimuth of a horizontal plane or vertical line is 0."""
    plunge_deg: FloatArray
    ids: tuple[str, ...]
    """IDs, or the 1-based numbers of the rows."""
    kinds: tuple[str, ...] | None
    """Kinds, or None if the column is missing or empty."""
    sets: tuple[str, ...] | None
    overturned: tuple[bool | None, ...] | None
    """Whether the younger side of each bed (n,) is below it, or None if unknown."""
    convention: str
    """Description of the conventions of the columns."""
    dropped: tuple[int, ...]
    """Lines that do not contain angles."""
    warnings: tuple[Finding, ...]

    def __len__(self) -> int:
        return len(self.row_indices)

    @cached_property
    def rotation_errors(self) -> RotationErrors | None:
        """Rotation errors of the registrations of the rows, or None if not stated."""
        return table_rotation_errors(self.table, self.row_indices)

    @property
    def bowed_deg(self) -> float | None:
        """Bowing of the most strongly bowed model in degrees, or None if not stated."""
        return stated_bowing_deg(self.table.comments)

    @property
    def repeats(self) -> int:
        """Number of excluded rows that repeat other rows."""
        return self.table.repeats

    @property
    def path(self) -> Path:
        """Path of the table."""
        return self.table.path

    @property
    def line_numbers(self) -> IntArray:
        """Line number (n,) of each row in the file."""
        return self.table.line_numbers[self.row_indices]

    def column(self, key: str) -> list[str]:
        """Return the text (n,) of the column named or numbered `key`. Raises `UsageError`."""
        cells = self.table.labels(self.table.find(key))
        return [cells[row_index] for row_index in self.row_indices]

    def vectors(self) -> FloatArray:
        """Return World unit vectors (n, 3): downward poles of planes, and directed lines."""
        poles = planes_to_poles(self.dip_direction_deg, self.dip_deg)
        lines = lines_to_vectors(self.trend_deg, self.plunge_deg)
        return np.where(self.is_plane[:, None], poles, lines)


def extract_orientations(
    table: TextTable,
    azimuth: Azimuth | None = None,
    *,
    repeats: bool = False,
    azimuth_only: bool = False,
) -> OrientationTable:
    """Extract planes and lines from a table.

    Parameters
    ----------
    table : TextTable
    azimuth : {"strike", "dipdir"}, optional
        Meaning of a column named `azimuth`, or of the first column in a table without a header.
    repeats : bool
        Whether to include rows that repeat another pick according to the column `repeat_of`.
    azimuth_only : bool
        Whether a table may contain azimuths without dips or plunges, which become NaN.

    Raises
    ------
    InputError
        If the table or its angles are not valid; states file, line and column.
    UsageError
        If `azimuth` is required but not given.
    """
    if not len(table):
        raise InputError(Finding("table.no-rows"), file=table.path, line=table.header_line)
    reader = _TableReader(table if repeats else exclude_repeats(table), azimuth)
    return reader.read_azimuths() if azimuth_only and reader.has_only_azimuths else reader.result()


class _TableReader:
    """Interpreter of one table: first its columns, then planes, lines and findings."""

    def __init__(self, table: TextTable, azimuth: Azimuth | None) -> None:
        self.table = table
        self.azimuth = azimuth
        self.warnings: list[Finding] = list(table.notes)
        self.columns = OrientationColumns(table, self.warnings)
        self.conventions: list[str] = []
        self.is_downward: BoolArray | None = None
        n = len(table)
        self.dip_direction, self.dip, self.trend, self.plunge = np.full((4, n), np.nan)

    @property
    def has_only_azimuths(self) -> bool:
        """Whether the table has a column of azimuths and none of dips or plunges."""
        names = self.table.names
        if names is None:
            return self.table.width == 1 and not any(map(is_attitude, self.table.cells(0)))
        meanings = ("strike", "dip direction", "azimuth", "trend")
        has_azimuth = any(self.columns.find(meaning) is not None for meaning in meanings)
        return has_azimuth and not has_orientations(names)

    def read_azimuths(self) -> OrientationTable:
        """Interpret a table without dips and plunges, which become NaN.

        Raises UsageError if the meaning of the azimuths is not known.
        """
        meanings = ("strike", "dip direction", "azimuth", "trend")
        names = self.table.names
        meaning = next(
            (
                candidate
                for candidate in meanings
                if self.columns.find_unique(candidate) is not None
            ),
            "azimuth",
        )
        column = 0 if names is None else self.columns.find_unique(meaning) or 0
        if meaning == "azimuth":
            meaning = {"strike": "strike", "dipdir": "dip direction"}.get(self.azimuth or "", "")
            if not meaning:
                raise self._ambiguous_azimuth_error(column)
        azimuths = self.columns.azimuths(column, np.zeros(len(self.table), bool))
        if meaning == "trend":
            self.trend = azimuths
        else:
            self.dip_direction = wrap360(azimuths + (90.0 if meaning == "strike" else 0.0))
        self.conventions.append(
            tr(
                "azimuths as {meaning} ({columns}), without dips or plunges",
                meaning=meaning,
                columns=self.columns.quoted_names(column),
            )
        )
        return self._table(np.isfinite(self.dip_direction), np.isfinite(self.trend))

    def result(self) -> OrientationTable:
        """Interpret the table. Raises InputError and UsageError as `extract_orientations` does."""
        self._read_planes()
        self._read_lines()
        if not self.conventions:
            raise self._no_orientations_error()
        return self._table(
            np.isfinite(self.dip_direction) & np.isfinite(self.dip),
            np.isfinite(self.trend) & np.isfinite(self.plunge),
        )

    def _table(self, has_plane: BoolArray, has_line: BoolArray) -> OrientationTable:
        """Return the rows that are planes or lines.

        Raises InputError if no row contains angles.
        """
        table = self.table
        geometry = self._geometry(has_plane, has_line)
        row_indices = np.flatnonzero(geometry != _NONE)
        dropped_lines = tuple(int(n) for n in table.line_numbers[geometry == _NONE])
        if dropped_lines:
            self.warnings.append(
                Finding(
                    "table.rows-left-out",
                    count=len(dropped_lines),
                    needed=tr("angles"),
                    lines=dropped_lines,
                )
            )
        if not len(row_indices):
            raise InputError(
                Finding("table.no-valid-rows", count=len(table), needed=tr("angles")),
                file=table.path,
                line=int(table.line_numbers[0]),
            )
        is_plane = geometry[row_indices] == _PLANE
        overturned = self.columns.overturned(row_indices)
        if overturned is None and self.is_downward is not None:
            overturned = tuple(self.is_downward[row_indices].tolist())

        def select_values(values: FloatArray, mask: BoolArray) -> FloatArray:
            return np.where(mask, values[row_indices], np.nan)

        return OrientationTable(
            table=table,
            row_indices=row_indices,
            is_plane=is_plane,
            dip_direction_deg=select_values(self.dip_direction, is_plane),
            dip_deg=select_values(self.dip, is_plane),
            trend_deg=select_values(self.trend, ~is_plane),
            plunge_deg=select_values(self.plunge, ~is_plane),
            ids=self.columns.words("id", row_indices)
            or tuple(str(row_index + 1) for row_index in row_indices),
            kinds=self.columns.words("kind", row_indices),
            sets=self.columns.words("set", row_indices),
            overturned=overturned,
            convention="; ".join(self.conventions),
            dropped=dropped_lines,
            warnings=tuple(self.warnings),
        )

    # -- planes ----------------------------------------------------------------------------------

    def _read_planes(self) -> None:
        table = self.table
        if table.names is None:
            self._read_headerless()
            return
        attitude, dip = self.columns.find_unique("attitude"), self.columns.find_unique("dip")
        strike, direction = (
            self.columns.find_unique("strike"),
            self.columns.find_unique("dip direction"),
        )
        azimuth = self.columns.find_unique("azimuth")
        has_named_azimuth = strike is not None or direction is not None
        if dip is None:
            inclination = self.columns.find_unique("inclination")
            if inclination is not None and azimuth is not None and not has_named_azimuth:
                self._read_inclinations(azimuth, inclination)
                return
            dip = inclination if has_named_azimuth else None
        if dip is None:
            if has_named_azimuth and attitude is None:
                raise InputError(
                    Finding(
                        "table.missing-column", column="dip", columns=table.names, names=("dip",)
                    ),
                    file=table.path,
                    line=table.header_line,
                    field="dip",
                )
            self._read_planes_without_dip(attitude)
            return
        quadrant = self.columns.find_unique("quadrant")
        if (
            strike is not None
            and direction is not None
            and self.columns.are_compass_points(direction)
        ):
            # For `strike, dip, dip direction` with SE in the third column, that column is the
            # quadrant.
            quadrant, direction = direction, None
        if quadrant is None and direction is None and strike is not None:
            quadrant = self._find_quadrant()
        if direction is not None:
            self._read_dip_direction(direction, dip)
            if strike is not None:
                self._compare_strike(strike)
        elif strike is not None:
            self._read_strike(strike, dip, quadrant)
        elif azimuth is None:
            raise InputError(
                Finding(
                    "table.missing-column",
                    column="dip direction",
                    columns=table.names,
                    names=("strike", "dip direction"),
                ),
                file=table.path,
                line=table.header_line,
                field="dip direction",
            )
        elif quadrant is not None:
            self._read_strike(azimuth, dip, quadrant)
        else:
            self._read_azimuth(azimuth, dip)

    def _find_quadrant(self) -> int | None:
        """Return a column of compass points that complements the strike, or None.

        If its name does not denote a dip quadrant (it may be a limb or a site), it is reported and
        not used.
        """
        other_columns = sorted(set(range(self.table.width)) - self.columns.known_columns)
        candidates = [
            other_column
            for other_column in other_columns
            if self.columns.are_compass_points(other_column)
        ]
        quadrants = [
            candidate
            for candidate in candidates
            if normalise_name(self.table.label(candidate)) in _QUADRANT_NAMES
        ]
        if candidates and len(quadrants) != 1:
            self.warnings.append(
                Finding(
                    "orientation.quadrants-unused", columns=self.columns.quoted_names(*candidates)
                )
            )
        return quadrants[0] if len(quadrants) == 1 else None

    def _read_headerless(self) -> None:
        attitude = self.columns.attitude_column()
        if attitude is not None:
            self._read_attitudes(attitude)
            return
        if self.table.width < 2:
            raise InputError(
                Finding("table.column-count", count=1, columns=("dip direction", "dip")),
                file=self.table.path,
                line=int(self.table.line_numbers[0]),
            )
        is_given = self.azimuth is not None
        self.azimuth = self.azimuth or parse_convention(self.table.path)
        self._read_azimuth(0, 1)
        if not is_given:
            self.conventions.append(tr(FILE_NAME_CONVENTION))

    def _read_azimuth(self, azimuth: int, dip: int) -> None:
        if self.azimuth == "strike":
            self._read_strike(azimuth, dip, None)
        elif self.azimuth == "dipdir" or self.columns.are_gempy_fields:
            self._read_dip_direction(azimuth, dip)
        else:
            raise self._ambiguous_azimuth_error(azimuth)

    def _ambiguous_azimuth_error(self, column: int) -> UsageError:
        has_names = self.table.names is not None
        name = self.table.label(column)
        example = f"{name}=dip_direction" if has_names else "1=trend,2=plunge"
        return UsageError(
            Finding("orientation.ambiguous-azimuth", example=example),
            file=self.table.path,
            line=self.table.header_line if has_names else int(self.table.line_numbers[0]),
            field=self.table.label(column),
        )

    def _read_inclinations(self, azimuth: int, inclination: int) -> None:
        """Read azimuth and inclination as plane or line, depending on the type of each row."""
        is_line = self.columns.are_lines()
        if not is_line.all():
            if self.azimuth is None and self.columns.are_gems_fields:
                self.azimuth = "strike"
            self._read_azimuth(azimuth, inclination)
            self.dip_direction[is_line] = self.dip[is_line] = np.nan
        if is_line.any():
            plunges = self.columns.inclinations(inclination, -90.0)
            trends = self.columns.azimuths(azimuth, np.abs(plunges) == 90.0)
            self.plunge, self.trend = np.where(is_line, [plunges, trends], np.nan)
            self.conventions.append(
                tr(
                    "lines as trend/plunge ({columns})",
                    columns=self.columns.quoted_names(azimuth, inclination),
                )
            )

    def _read_dip_direction(self, direction: int, dip: int) -> None:
        self.dip = self.columns.inclinations(dip, 0.0)
        self.dip_direction = self.columns.azimuths(direction, self.dip == 0.0)
        self.conventions.append(
            tr(
                "planes as dip direction/dip ({columns})",
                columns=self.columns.quoted_names(direction, dip),
            )
        )

    def _read_strike(self, strike: int, dip: int, quadrant: int | None) -> None:
        table = self.table
        quoted_names = self.columns.quoted_names(strike, dip)
        if quadrant is not None:
            self._read_text([strike, dip, quadrant], "strike/dip")
            self.conventions.append(
                tr(
                    "planes as strike/dip with dip quadrant ({columns}, {quadrant}); right-hand"
                    " rule if empty",
                    columns=quoted_names,
                    quadrant=self.columns.quoted_names(quadrant),
                )
            )
            return
        if self.columns.has_letters(strike) or self.columns.has_letters(dip):
            self._read_text([strike, dip], "strike/dip")
            self.conventions.append(
                tr(
                    "planes as strike/dip with the quadrant in the cells ({columns}); right-hand"
                    " rule without one",
                    columns=quoted_names,
                )
            )
            return
        is_left_hand = re.search(r"lhr|left", table.label(strike), re.IGNORECASE) is not None
        self.dip = self.columns.inclinations(dip, 0.0)
        azimuths = self.columns.azimuths(strike, self.dip == 0.0)
        self.dip_direction = wrap360(azimuths + (270.0 if is_left_hand else 90.0))
        self.dip_direction[self.dip == 0.0] = 0.0
        self.conventions.append(
            tr("planes as strike (left-hand rule)/dip ({columns})", columns=quoted_names)
            if is_left_hand
            else tr("planes as strike (right-hand rule)/dip ({columns})", columns=quoted_names)
        )

    def _read_planes_without_dip(self, attitude: int | None) -> None:
        """Read planes as poles, as normals, or as text with both angles."""
        normals = [self.columns.find_unique(f"normal {axis}") for axis in "xyz"]
        trend, plunge = (
            self.columns.find_unique("pole trend"),
            self.columns.find_unique("pole plunge"),
        )
        if trend is not None and plunge is not None:
            inclinations = self.columns.inclinations(plunge, 0.0)
            self.dip_direction = wrap360(self.columns.azimuths(trend, inclinations == 90.0) + 180.0)
            self.dip = 90.0 - inclinations
            self.conventions.append(
                tr(
                    "planes as trend/plunge of their poles ({columns})",
                    columns=self.columns.quoted_names(trend, plunge),
                )
            )
        elif attitude is not None:
            self._read_attitudes(attitude)
        elif None not in normals:
            self._read_normals([column for column in normals if column is not None])
        elif not has_orientations(self.table.names or ()):
            column = self.columns.attitude_column()
            if column is not None:
                self._read_attitudes(column)

    def _read_normals(self, columns: list[int]) -> None:
        """Read planes from their normals, which need not be of unit length or point up."""
        normals = self.table.numbers(columns)
        length = np.linalg.norm(normals, axis=1)
        with np.errstate(invalid="ignore"):
            is_valid = np.isfinite(length) & (length > 0.0)
            upward_normals = normals / np.where(is_valid, length, np.nan)[:, None]
            upward_normals *= np.where(upward_normals[:, 2] < 0.0, -1.0, 1.0)[:, None]
            self.dip = np.degrees(np.arccos(np.clip(upward_normals[:, 2], -1.0, 1.0)))
            self.dip_direction = wrap360(
                np.degrees(np.arctan2(upward_normals[:, 0], upward_normals[:, 1]))
            )
        self.dip_direction[self.dip == 0.0] = 0.0
        if self.columns.are_loop_fields:
            self.is_downward = np.asarray(normals[:, 2] < 0.0)
        self.conventions.append(
            tr("planes as normals ({columns})", columns=self.columns.quoted_names(*columns))
        )

    def _read_attitudes(self, column: int) -> None:
        """Read planes from cells with both angles."""
        is_strike = self.azimuth == "strike" or (
            self.azimuth is None and normalise_name(self.table.label(column)).startswith("strike")
        )
        self._read_text([column], "strike/dip" if is_strike else "dipdir/dip")
        self.conventions.append(
            tr(
                "planes as written in {column}; two bare numbers are {notation}",
                column=self.columns.quoted_names(column),
                notation="strike/dip" if is_strike else "dip direction/dip",
            )
        )
        has_letters = [
            any(character.isalpha() for character in cell)
            for cell in self.table.cells(column)
            if cell
        ]
        if any(has_letters) and not all(has_letters):
            self.warnings.append(
                Finding(
                    "orientation.two-conventions",
                    column=self.columns.quoted_names(column),
                    count=len(has_letters) - sum(has_letters),
                    other_count=sum(has_letters),
                    notation="strike/dip" if is_strike else "dip direction/dip",
                )
            )

    def _read_text(self, columns: list[int], notation: str | None) -> None:
        cells = [self.table.cells(column) for column in columns]
        wrapped_lines: list[int] = []
        for i, row_cells in enumerate(zip(*cells, strict=True)):
            if not all(row_cells[:2]) or any(
                word.casefold() in ("nan", "na") for word in row_cells[:2]
            ):
                continue
            try:
                plane = parse_plane_cells(row_cells, notation)
            except VomError as error:
                raise InputError(
                    error,
                    file=self.table.path,
                    line=int(self.table.line_numbers[i]),
                    field=self.table.label(columns[0]),
                ) from error
            self.dip_direction[i], self.dip[i] = plane.dip_direction_deg, plane.dip_deg
            if (azimuth := _parse_plain_number(row_cells[0])) is not None and azimuth > 360.0:
                wrapped_lines.append(int(self.table.line_numbers[i]))
        self.columns.report_wrapped(columns[0], wrapped_lines)

    def _compare_strike(self, strike: int) -> None:
        """Compare the strike with the dip direction, which is used if they disagree."""
        try:
            strikes = self.table.numbers([strike])[:, 0]
        except InputError:
            return
        difference_deg = np.abs(wrap360(strikes + 90.0 - self.dip_direction + 180.0) - 180.0)
        has_strike = np.isfinite(difference_deg) & (self.dip > 0)
        differing_rows = np.flatnonzero((difference_deg > 1.5) & has_strike)
        if len(differing_rows) and (difference_deg[has_strike] > 180.0 - 1.5).all():
            quoted_name = self.columns.quoted_names(strike)
            self.warnings.append(Finding("orientation.strike-left-hand", column=quoted_name))
        elif len(differing_rows):
            lines = [int(n) for n in self.table.line_numbers[differing_rows]]
            self.warnings.append(
                Finding(
                    "orientation.strike-differs",
                    count=len(differing_rows),
                    column=self.columns.quoted_names(strike),
                    lines=lines,
                )
            )

    # -- lines -----------------------------------------------------------------------------------

    def _read_lines(self) -> None:
        plunge = self.columns.find_unique("plunge")
        trend = self.columns.find_unique("trend")
        if trend is None and self.columns.find("dip") is None:
            trend = self.columns.find_unique("azimuth")
        if plunge is None and trend is None and not self.conventions:
            trend, plunge = self._read_declinations()
        if plunge is None and trend is not None and self.columns.find("trend") is not None:
            plunge = self.columns.find_unique("inclination")
        if plunge is None and trend is None and not self.conventions:
            self._read_line_text()
        if plunge is None and trend is None:
            return
        if plunge is None or trend is None:
            if self.conventions or (trend is not None and self.columns.find("trend") is None):
                return
            missing_name = "plunge" if plunge is None else "trend"
            raise InputError(
                Finding(
                    "table.missing-column",
                    column=missing_name,
                    columns=self.table.names or (),
                    names=(missing_name,),
                ),
                file=self.table.path,
                line=self.table.header_line,
                field=missing_name,
            )
        self.plunge = self.columns.inclinations(plunge, -90.0)
        self.trend = self.columns.azimuths(trend, np.abs(self.plunge) == 90.0)
        self.conventions.append(
            tr(
                "lines as trend/plunge ({columns})",
                columns=self.columns.quoted_names(trend, plunge),
            )
        )

    def _read_declinations(self) -> tuple[int | None, int | None]:
        """Return the columns of declination and inclination of a line, or None for both.

        If there are principal axes (K1, K2, K3), the first of them is used.
        """
        axes = self.columns.principal_axes()
        if len(axes) > 1:
            self.warnings.append(
                Finding("orientation.other-axes", used=next(iter(axes)), axes=list(axes)[1:])
            )
        if axes:
            return next(iter(axes.values()))
        return self.columns.find_unique("declination"), self.columns.find_unique("inclination")

    def _read_line_text(self) -> None:
        """Read lines from cells with trend and plunge, as in 120/30."""
        column = self.columns.find_unique("line attitude")
        if column is None:
            return
        for i, cell in enumerate(self.table.cells(column)):
            if not cell:
                continue
            try:
                line = parse_line(cell)
            except VomError as error:
                raise InputError(
                    error,
                    file=self.table.path,
                    line=int(self.table.line_numbers[i]),
                    field=self.table.label(column),
                ) from error
            self.trend[i], self.plunge[i] = line.trend_deg, line.plunge_deg
        self.conventions.append(
            tr("lines as trend/plunge ({columns})", columns=self.columns.quoted_names(column))
        )

    def _geometry(self, has_plane: BoolArray, has_line: BoolArray) -> IntArray:
        """Return the geometry (n,) of each row.

        A row with angles of a plane and of a line is a plane with a line, unless its element or, if
        that is not stated, its type is a line.
        """
        result = np.where(has_plane, _PLANE, np.where(has_line, _LINE, _NONE))
        column = self.columns.find("element")
        if column is None:
            # The type decides, as in the tables of Orient.
            has_both = has_plane & has_line
            result[has_both & self.columns.are_lines()] = _LINE
            if n_ambiguous := int(np.count_nonzero(has_both & (result == _PLANE))):
                self.warnings.append(Finding("orientation.planes-with-lines", count=n_ambiguous))
            return result
        for i, cell in enumerate(self.table.cells(column)):
            word = cell.casefold()
            if word in ("line", "lineation"):
                result[i] = _LINE if has_line[i] else _NONE
            elif word == "plane":
                result[i] = _PLANE if has_plane[i] else _NONE
            elif word:
                raise InputError(
                    Finding("table.unknown-word", cell=shorten(cell), words=("plane", "line")),
                    file=self.table.path,
                    line=int(self.table.line_numbers[i]),
                    field=self.table.label(column),
                )
        return result

    def _no_orientations_error(self) -> InputError:
        finding = Finding("orientation.no-columns", columns=self.table.names or ())
        return self.table.header_error(finding, "dip")


def _parse_plain_number(cell: str) -> float | None:
    return float(cell.replace(",", ".")) if re.fullmatch(r"\d+([.,]\d*)?", cell) else None


def parse_plane_cells(cells: tuple[str, ...], notation: str | None) -> Plane:
    """Parse a plane from one cell, or from cells with strike, dip and an optional quadrant."""
    if len(cells) == 1:
        return parse_plane(cells[0], notation)
    strike = cells[0]
    azimuth = _parse_plain_number(strike)
    if azimuth is not None and azimuth <= 720.0:
        strike = f"{wrap360(azimuth):.10g}"
    return parse_plane(" ".join([strike, *cells[1:]]), notation)
