"""Tables of faults with slip from this program, FaultKin, Win-Tensor and others.

A fault has a strike (right-hand rule) or dip direction, and a dip. Its slip is given by the trend
and plunge or the rake (pitch) of the striae, and by a sense in words or letters. In tables of this
program, the slip is the directed rake of the movement of the hanging wall.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError, InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.notation import parse_rake
from vomstudio.geology.orientation import (
    ANGLE_TOLERANCE_DEG,
    Line,
    Plane,
    angle_line_plane,
    compute_rake,
)
from vomstudio.geology.slip import slip_rake
from vomstudio.io.text.column_names import normalise_name
from vomstudio.io.text.orientation_columns import Azimuth
from vomstudio.io.text.repeated_rows import exclude_repeats
from vomstudio.io.text.rows import parse_number
from vomstudio.io.text.slip_columns import SLIP_NAMES
from vomstudio.io.text.tables import TextTable

MAX_OFF_PLANE_DEG = 10.0
"""Maximum angle between striae and their plane; larger angles are reported."""

_SINGLE_SENSES = {
    "normal": ("n", "normal", "nf"),
    "reverse": ("r", "i", "t", "reverse", "inverse", "thrust", "tf"),
    "sinistral": ("s", "l", "ll", "sinistral", "left", "left_lateral"),
    "dextral": ("d", "rl", "dextral", "right", "right_lateral"),
}
_NUMBERED_SENSES = {"1": "reverse", "2": "normal", "3": "dextral", "4": "sinistral"}
"""Codes of T-TECTO and OpenStereo."""
_SIGNED_SENSES = {"1": "normal", "+1": "normal", "-1": "reverse"}
"""Codes of APSG and structR: the hanging wall moves down or up."""
_SENSES = {normalise_name(word): sense for sense, words in _SINGLE_SENSES.items() for word in words}
_OBLIQUE_SENSES = {
    "tr": ("reverse", "dextral"),
    "tl": ("reverse", "sinistral"),
    "nr": ("normal", "dextral"),
    "nl": ("normal", "sinistral"),
    "rr": ("reverse", "dextral"),
    "rs": ("reverse", "sinistral"),
    "rd": ("reverse", "dextral"),
    "nd": ("normal", "dextral"),
    "ns": ("normal", "sinistral"),
    "id": ("reverse", "dextral"),
    "is": ("reverse", "sinistral"),
}
"""Codes for both components of oblique slip, starting with those of FaultKin."""


_SENSE_WORDS = ("N", "R", "S", "D", "TR", "TL", "NR", "NL")
_COLUMN_ORDERS = {
    5: ("fault_azimuth", "dip", "trend", "plunge", "sense"),
    4: ("fault_azimuth", "dip", "rake", "sense"),
}
"""Columns of tables without a header, by their number."""
_EXAMPLE_HEADER = ("dip_direction", "dip", "trend", "plunge", "sense")


@dataclass(frozen=True, eq=False)
class SlipTable:
    """Faults (n) with the directed rake of their slip.

    Parameters
    ----------
    dropped : tuple of int
        Lines of incomplete rows.
    """

    path: Path
    ids: tuple[str, ...]
    dip_direction_deg: FloatArray
    dip_deg: FloatArray
    slip_rake_deg: FloatArray
    dropped: tuple[int, ...]
    warnings: tuple[Finding, ...]

    def __len__(self) -> int:
        return len(self.ids)


def extract_slips(table: TextTable, azimuth: Azimuth | None = None) -> SlipTable:
    """Extract faults without repeats from a table.

    Parameters
    ----------
    table : TextTable
    azimuth : {"strike", "dipdir"}, optional
        Meaning of a column named `azimuth` of the fault, or of the first column without a header.

    Raises
    ------
    InputError
        If columns are missing, angles or senses of slip are not valid, or no row is complete;
        states file, line and column.
    UsageError
        If `azimuth` is required but not given.
    """
    table = _name_columns(exclude_repeats(table), azimuth)
    columns = {
        key: column
        for key, names in SLIP_NAMES.items()
        if (column := _column(table, names)) is not None
    }
    if not {"strike", "dip_direction"} & columns.keys() and "fault_azimuth" in columns:
        columns["strike" if azimuth == "strike" else "dip_direction"] = columns["fault_azimuth"]
        if azimuth is None:
            raise _ambiguous_azimuth_error(table, columns["fault_azimuth"])
    _require_columns(table, columns)
    cells = {key: table.cells(column) for key, column in columns.items()}
    notes = list(table.notes)
    if "sense" in cells and _is_r_right_lateral(cells["sense"]):
        cells["sense"] = ["RL" if normalise_name(word) == "r" else word for word in cells["sense"]]
        notes.append(Finding("slip.right-lateral"))
    if "sense" in cells and _are_signed(cells["sense"], is_apsg="fault_azimuth" in columns):
        cells["sense"] = [_SIGNED_SENSES.get(word.strip(), word) for word in cells["sense"]]
        notes.append(Finding("slip.signed-senses"))
    elif "sense" in cells and _are_numbered(cells["sense"]):
        cells["sense"] = [_NUMBERED_SENSES.get(word.strip(), word) for word in cells["sense"]]
        notes.append(Finding("slip.numbered-senses"))
    faults: list[tuple[str, Plane, float]] = []
    dropped_lines: list[int] = []
    off_plane_lines: list[int] = []
    for row, line in enumerate(table.line_numbers.tolist()):
        slip_row = _Row(
            table.path,
            line,
            {key: column_cells[row].strip() for key, column_cells in cells.items()},
        ).read()
        if slip_row is None:
            dropped_lines.append(line)
            continue
        plane, slip, off_plane_deg = slip_row
        name = cells["id"][row].strip() if "id" in cells else ""
        faults.append((name or str(row + 1), plane, slip))
        if off_plane_deg > MAX_OFF_PLANE_DEG:
            off_plane_lines.append(line)
    if not faults:
        raise InputError(
            Finding(
                "table.no-valid-rows",
                count=len(table),
                needed=tr("values for fault, slip and sense"),
            ),
            file=table.path,
        )
    return SlipTable(
        table.path,
        tuple(name for name, _, _ in faults),
        np.array([plane.dip_direction_deg for _, plane, _ in faults]),
        np.array([plane.dip_deg for _, plane, _ in faults]),
        np.array([slip for _, _, slip in faults]),
        tuple(dropped_lines),
        (*notes, *_row_findings(dropped_lines, off_plane_lines)),
    )


def _name_columns(table: TextTable, azimuth: Azimuth | None) -> TextTable:
    """Name the columns of a table without a header, in the order of T-TECTO and OpenStereo.

    Other tables are returned unchanged. Raises UsageError if the meaning of the azimuth is not
    stated.
    """
    if table.names is not None or not has_fault_rows(table):
        return table
    if azimuth is None:
        raise _ambiguous_azimuth_error(table, 0)
    return replace(table, names=_COLUMN_ORDERS[table.width])


def has_fault_rows(table: TextTable) -> bool:
    """Return whether the rows are angles followed by a sense, as in T-TECTO and OpenStereo.

    Parameters
    ----------
    table : TextTable

    Returns
    -------
    bool
    """
    if table.width not in _COLUMN_ORDERS:
        return False
    senses = {normalise_name(word) for word in table.cells(table.width - 1) if word}
    known_senses = _SENSES.keys() | _OBLIQUE_SENSES.keys() | _NUMBERED_SENSES.keys()
    angles = (cell for column in range(table.width - 1) for cell in table.cells(column))
    return bool(senses) and senses <= known_senses and all(map(_is_number, angles))


def _is_number(cell: str) -> bool:
    return parse_number(cell, decimal_comma=True) is not None


def _ambiguous_azimuth_error(table: TextTable, column: int) -> UsageError:
    header = ",".join(f"{i}={name}" for i, name in enumerate(_EXAMPLE_HEADER, 1))
    example = header if table.names is None else f"{table.label(column)}=dip_direction"
    return UsageError(
        Finding("orientation.ambiguous-azimuth", example=example),
        file=table.path,
        line=table.header_line or int(table.line_numbers[0]),
        field=table.label(column),
    )


def _row_findings(dropped_lines: list[int], off_plane_lines: list[int]) -> list[Finding]:
    findings = []
    if dropped_lines:
        findings.append(
            Finding(
                "table.rows-left-out",
                count=len(dropped_lines),
                needed=tr("values for fault, slip and sense"),
                lines=dropped_lines,
            )
        )
    if off_plane_lines:
        findings.append(
            Finding(
                "slip.off-plane",
                count=len(off_plane_lines),
                angle_deg=MAX_OFF_PLANE_DEG,
                lines=off_plane_lines,
            )
        )
    return findings


def _column(table: TextTable, names: tuple[str, ...]) -> int | None:
    titles = [normalise_name(title) for title in table.names or ()]
    for name in names:
        if normalise_name(name) in titles:
            return titles.index(normalise_name(name))
    return None


def _require_columns(table: TextTable, columns: dict[str, int]) -> None:
    """Raise InputError if columns are missing."""
    missing_column = None
    if "dip" not in columns or not ({"strike", "dip_direction"} & columns.keys()):
        missing_column = tr("strike (or dip direction) and dip of the fault")
    elif "slip_rake" not in columns:
        if not ({"trend", "plunge"} <= columns.keys() or "rake" in columns):
            missing_column = tr("trend and plunge, or rake, of the striae")
        elif "sense" not in columns:
            missing_column = tr("sense of slip")
    if missing_column is not None:
        finding = Finding(
            "slip.missing-columns",
            missing=missing_column,
            example=(table.delimiter if table.delimiter.strip() else " ").join(_EXAMPLE_HEADER),
        )
        raise table.header_error(finding, None)


def _are_signed(words: Sequence[str], *, is_apsg: bool) -> bool:
    """Return whether all senses that are stated are 1 or -1.

    A 1 alone may also be a code of T-TECTO, unless the columns are those of APSG.
    """
    codes = {word.strip() for word in words if word.strip()}
    return codes <= _SIGNED_SENSES.keys() and ("-1" in codes or (is_apsg and bool(codes)))


def _are_numbered(texts: Sequence[str]) -> bool:
    """Return whether all senses that are stated are codes of T-TECTO."""
    codes = {word.strip() for word in texts if word.strip()}
    return bool(codes) and codes <= _NUMBERED_SENSES.keys()


def _is_r_right_lateral(texts: Sequence[str]) -> bool:
    """Return whether R by itself means right-lateral.

    This is the case if T (thrust in FaultKin) or L also occurs, and no other code means dextral.
    """
    codes = {normalise_name(word) for word in texts}
    known_words = {"i", "s", "d", "rl", "rd", "rs", "dextral", "right", "right_lateral"}
    return "r" in codes and bool(codes & {"t", "l", "tr", "tl"}) and not codes & known_words


class _Row:
    """Parser of a row that contains one fault."""

    def __init__(self, path: Path, line: int, cells: dict[str, str]) -> None:
        self.path, self.line, self.cells = path, line, cells

    def read(self) -> tuple[Plane, float, float] | None:
        """Parse the row. Raises InputError if a cell is not valid.

        Returns
        -------
        plane : Plane
        slip_rake_deg : float
            Directed rake.
        off_plane_deg : float
            Angle between the striae and the plane. Returns None instead for an incomplete row.
        """
        dip, strike = self._number("dip"), self._number("strike")
        azimuth = self._number("dip_direction")
        has_strike = azimuth is None
        if azimuth is None and strike is not None:
            azimuth = strike + 90.0
        if dip is None or azimuth is None:
            return None
        try:
            plane = Plane(azimuth, dip)
            turn = _strike_difference(plane, azimuth - 90.0, has_strike=has_strike)
            directed_rake = self._number("slip_rake")
            if directed_rake is not None:
                return plane, _convert_directed_rake(plane, directed_rake, turn), 0.0
            rake, off_plane_deg = self._parse_rake(plane, turn)
        except GeometryError as error:
            raise InputError(error, file=self.path, line=self.line, field=error.field) from error
        word = self.cells.get("sense", "")
        if rake is None or not word or normalise_name(word) in ("x", "unknown"):
            return None
        slip = self._parse_slip_rake(plane, rake, word)
        return None if slip is None else (plane, slip, off_plane_deg)

    def _parse_rake(self, plane: Plane, angle: float) -> tuple[float | None, float]:
        trend, plunge = self._number("trend"), self._number("plunge")
        if trend is not None and plunge is not None:
            line = Line(trend, plunge)
            return compute_rake(line, plane), angle_line_plane(line, plane)
        cell = self.cells.get("rake", "")
        if cell and cell[-1].isalpha() and parse_number(cell, decimal_comma=True) is None:
            try:
                return parse_rake(cell, plane), 0.0
            except InputError as error:
                raise self._error(error) from error
        rake = self._number("rake")
        return (None if rake is None else _convert_axial_rake(plane, rake, angle)), 0.0

    def _parse_slip_rake(self, plane: Plane, rake: float, word: str) -> float | None:
        """Return the directed rake, or None if the sense does not define the direction.

        Raises InputError if the sense is unknown or contradicts the rake.
        """
        single_sense = _SENSES.get(normalise_name(word))
        senses = (
            (single_sense,)
            if single_sense is not None
            else _OBLIQUE_SENSES.get(normalise_name(word))
        )
        if senses is None:
            raise self._error(Finding("table.unknown-word", cell=word, words=_SENSE_WORDS))
        rakes = [slip for sense in senses if (slip := slip_rake(plane, rake, sense)) is not None]
        if len(rakes) == 2 and abs(rakes[0] - rakes[1]) > ANGLE_TOLERANCE_DEG:
            raise self._error(Finding("slip.contradiction", word=word, rake_deg=rake))
        return rakes[0] if rakes else None

    def _number(self, name: str) -> float | None:
        cell = self.cells.get(name, "")
        if not cell:
            return None
        value = parse_number(cell, decimal_comma=True)
        if value is None:
            raise self._error(Finding("table.not-a-number", cell=cell))
        return value if math.isfinite(value) else None

    def _error(self, cause: Finding | InputError) -> InputError:
        return InputError(cause, file=self.path, line=self.line)


def _strike_difference(plane: Plane, strike_deg: float, *, has_strike: bool) -> float:
    """Return the angle from the reference strike to the strike of the row, in degrees.

    They differ on a horizontal plane, whose reference dip direction is 0, and on a vertical plane,
    whose reference strike is below 180, if the row states a strike and no dip direction.
    """
    if plane.undefined:
        return (strike_deg - 270.0) % 360.0
    return 180.0 if plane.vertical and has_strike and strike_deg % 360.0 >= 180.0 else 0.0


def _convert_axial_rake(plane: Plane, rake_deg: float, angle: float) -> float:
    """Return the rake of a line from the reference strike, in [0, 180), degrees."""
    if plane.undefined:
        return (rake_deg + angle) % 180.0
    # Measured from the opposite end of the strike, with the same sense of dip.
    return (angle - rake_deg if angle else rake_deg) % 180.0


def _convert_directed_rake(plane: Plane, rake_deg: float, angle: float) -> float:
    """Return the directed rake from the reference strike, degrees."""
    if plane.undefined and angle:
        return 180.0 - (180.0 - (rake_deg - angle)) % 360.0
    # The other wall is the hanging wall and moves in the opposite direction.
    return -rake_deg if angle else rake_deg
