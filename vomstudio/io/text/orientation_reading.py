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
from vomstudio.geology.common_rotation_errors import Turns
from vomstudio.geology.notation import parse_plane
from vomstudio.geology.orientation import Plane, lines_to_vectors, planes_to_poles
from vomstudio.geometry.vectors import wrap360
from vomstudio.io.text.column_names import normalise_name
from vomstudio.io.text.file_text import MAX_OBJECTS
from vomstudio.io.text.orientation_columns import Azimuth, OrientationColumns, convention_in_name
from vomstudio.io.text.registration_comments import stated_bowing_deg, table_rotation_errors
from vomstudio.io.text.repeated_rows import exclude_repeats
from vomstudio.io.text.rows import shorten
from vomstudio.io.text.tables import TextTable, read_table

_QUADRANT_NAMES = {"direction", "dir", "side", "sense", "dips"}
"""Column names that denote a dip quadrant if the cells are compass points."""
_PLANE, _LINE, _NONE = 1, 2, 0
BY_FILE_NAME = to_translate("no header: strike or dip direction by file name")


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
    def turns(self) -> Turns | None:
        """Rotation errors of the registrations of the rows, or None if not stated."""
        return table_rotation_errors(self.table, self.row_indices)

    @property
    def bowed_deg(self) -> float | None:
        """Bowing of the models in degrees, or None if not stated."""
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
        """Return the text (n,) of the column that the user calls `key`. Raises `UsageError`."""
        cells = self.table.labels(self.table.find(key))
        return [cells[row_index] for row_index in self.row_indices]

    def vectors(self) -> FloatArray:
        """Return World unit vectors (n, 3): downward poles of planes, and directed lines."""
        poles = planes_to_poles(self.dip_direction_deg, self.dip_deg)
        lines = lines_to_vectors(self.trend_deg, self.plunge_deg)
        return np.where(self.is_plane[:, None], poles, lines)


def read_orientations(
    path: str | Path, azimuth: Azimuth | None = None, *, repeats: bool = False
) -> OrientationTable:
    """Read planes and lines from a text table.

    Parameters
    ----------
    path : str or Path
    azimuth : {"strike", "dipdir"}, optional
        Meaning of a column named `azimuth`, or of the first column in a table without a header.
    repeats : bool
        Whether to include rows that repeat another pick according to the column `repeat_of`.

    Raises
    ------
    InputError
        If the table or its angles are not valid; states file, line and column.
    UsageError
        If `azimuth` is required but not given.
    """
    return extract_orientations(read_table(path, max_lines=MAX_OBJECTS), azimuth, repeats=repeats)


def extract_orientations(
    table: TextTable, azimuth: Azimuth | None = None, *, repeats: bool = False
) -> OrientationTable:
    """Extract planes and lines from a table in the same way as `read_orientations`."""
    if not len(table):
        raise InputError(Finding("table.no-rows"), file=table.path, line=table.header_line)
    return _TableReader(table if repeats else exclude_repeats(table), azimuth).result()


class _TableReader:
    """Interpreter of one table: first its columns, then planes, lines and findings."""

    def __init__(self, table: TextTable, azimuth: Azimuth | None) -> None:
        self.table = table
        self.azimuth = azimuth
        self.warnings: list[Finding] = list(table.notes)
        self.columns = OrientationColumns(table, self.warnings)
        self.conventions: list[str] = []
        n = len(table)
        self.dip_direction, self.dip, self.trend, self.plunge = np.full((4, n), np.nan)

    def result(self) -> OrientationTable:
        """Interpret the table."""
        self._read_planes()
        self._read_lines()
        if not self.conventions:
            raise self._no_orientations()
        table = self.table
        has_plane = np.isfinite(self.dip_direction) & np.isfinite(self.dip)
        has_line = np.isfinite(self.trend) & np.isfinite(self.plunge)
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

        def select(values: FloatArray, mask: BoolArray) -> FloatArray:
            return np.where(mask, values[row_indices], np.nan)

        return OrientationTable(
            table=table,
            row_indices=row_indices,
            is_plane=is_plane,
            dip_direction_deg=select(self.dip_direction, is_plane),
            dip_deg=select(self.dip, is_plane),
            trend_deg=select(self.trend, ~is_plane),
            plunge_deg=select(self.plunge, ~is_plane),
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
        attitude, dip = self.columns.take("attitude"), self.columns.take("dip")
        strike, direction = self.columns.take("strike"), self.columns.take("dip direction")
        azimuth = self.columns.take("azimuth")
        if dip is None:
            inclination = self.columns.take("inclination")
            is_named = strike is not None or direction is not None
            if inclination is not None and azimuth is not None and not is_named:
                self._read_inclinations(azimuth, inclination)
                return
            if is_named:
                raise InputError(
                    Finding(
                        "table.missing-column", column="dip", columns=table.names, names=("dip",)
                    ),
                    file=table.path,
                    line=table.header_line,
                    field="dip",
                )
            self._read_poles_or_text(attitude)
            return
        quadrant = self.columns.take("quadrant")
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
        other_columns = sorted(set(range(self.table.width)) - self.columns.known)
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
        if self.table.width < 2:
            raise InputError(
                Finding("table.column-count", count=1, columns=("dip direction", "dip")),
                file=self.table.path,
                line=int(self.table.line_numbers[0]),
            )
        is_given = self.azimuth is not None
        self.azimuth = self.azimuth or convention_in_name(self.table.path)
        if self.azimuth is None:
            raise UsageError(
                Finding("orientation.ambiguous-azimuth"),
                file=self.table.path,
                line=int(self.table.line_numbers[0]),
                field="column 1",
            )
        self._read_azimuth(0, 1)
        if not is_given:
            self.conventions.append(tr(BY_FILE_NAME))

    def _read_azimuth(self, azimuth: int, dip: int) -> None:
        if self.azimuth == "strike":
            self._read_strike(azimuth, dip, None)
        elif self.azimuth == "dipdir":
            self._read_dip_direction(azimuth, dip)
        else:
            raise UsageError(
                Finding("orientation.ambiguous-azimuth"),
                file=self.table.path,
                line=self.table.header_line,
                field=self.table.label(azimuth),
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

    def _read_poles_or_text(self, attitude: int | None) -> None:
        trend, plunge = self.columns.take("pole trend"), self.columns.take("pole plunge")
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
            convention = {"strike": "strike/dip", "dipdir": "dipdir/dip"}.get(self.azimuth or "")
            self._read_text([attitude], convention)
            pair = "strike/dip" if self.azimuth == "strike" else "dip direction/dip"
            self.conventions.append(
                tr(
                    "planes as written in {column}; two bare numbers are {notation}",
                    column=self.columns.quoted_names(attitude),
                    notation=pair,
                )
            )

    def _read_text(self, columns: list[int], notation: str | None) -> None:
        cells = [self.table.cells(column) for column in columns]
        wrapped_rows: list[int] = []
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
            if (azimuth := _plain_number(row_cells[0])) is not None and azimuth > 360.0:
                wrapped_rows.append(int(self.table.line_numbers[i]))
        self.columns.report_wrapped(columns[0], wrapped_rows)

    def _compare_strike(self, strike: int) -> None:
        """Compare the strike with the dip direction, which is used if they disagree."""
        try:
            strikes = self.table.numbers([strike])[:, 0]
        except InputError:
            return
        difference_deg = np.abs(wrap360(strikes + 90.0 - self.dip_direction + 180.0) - 180.0)
        differing = np.flatnonzero((difference_deg > 1.5) & (self.dip > 0))
        if len(differing):
            lines = [int(n) for n in self.table.line_numbers[differing]]
            self.warnings.append(
                Finding(
                    "orientation.strike-differs",
                    count=len(differing),
                    column=self.columns.quoted_names(strike),
                    lines=lines,
                )
            )

    # -- lines -----------------------------------------------------------------------------------

    def _read_lines(self) -> None:
        plunge = self.columns.take("plunge")
        trend = self.columns.take("trend")
        if trend is None and self.columns.find("dip") is None:
            trend = self.columns.take("azimuth")
        if plunge is None and trend is None:
            return
        if plunge is None or trend is None:
            if self.conventions or (trend is not None and self.columns.find("trend") is None):
                return
            missing_text = "plunge" if plunge is None else "trend"
            raise InputError(
                Finding(
                    "table.missing-column",
                    column=missing_text,
                    columns=self.table.names or (),
                    names=(missing_text,),
                ),
                file=self.table.path,
                line=self.table.header_line,
                field=missing_text,
            )
        self.plunge = self.columns.inclinations(plunge, -90.0)
        self.trend = self.columns.azimuths(trend, np.abs(self.plunge) == 90.0)
        self.conventions.append(
            tr(
                "lines as trend/plunge ({columns})",
                columns=self.columns.quoted_names(trend, plunge),
            )
        )

    def _geometry(self, has_plane: BoolArray, has_line: BoolArray) -> IntArray:
        """Return the geometry (n,) of each row; a row that has both is a plane with a line."""
        result = np.where(has_plane, _PLANE, np.where(has_line, _LINE, _NONE))
        column = self.columns.find("element")
        if column is None:
            if n_with_both := int(np.count_nonzero(has_plane & has_line)):
                self.warnings.append(Finding("orientation.planes-with-lines", count=n_with_both))
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

    def _no_orientations(self) -> InputError:
        finding = Finding("orientation.no-columns", columns=self.table.names or ())
        return self.table.header_error(finding, "dip")


def _plain_number(cell: str) -> float | None:
    return float(cell.replace(",", ".")) if re.fullmatch(r"\d+([.,]\d*)?", cell) else None


def parse_plane_cells(cells: tuple[str, ...], notation: str | None) -> Plane:
    """Parse a plane from one cell, or from cells with strike, dip and an optional quadrant."""
    if len(cells) == 1:
        return parse_plane(cells[0], notation)
    strike = cells[0]
    azimuth = _plain_number(strike)
    if azimuth is not None and azimuth <= 720.0:
        strike = f"{wrap360(azimuth):.10g}"
    return parse_plane(" ".join([strike, *cells[1:]]), notation)
