"""Tables of faults with slips: our own, FaultKin's, Win-Tensor's, and others with the same columns.

A fault has a strike (right-hand rule) or dip direction, and a dip; its slip a trend and plunge, or
a rake (pitch), of the striae, and a sense in words or letters; or, as our own tables have it, the
directed rake of the hanging wall's movement.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError, InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.notation import parse_rake
from vomstudio.geology.orientation import (
    ANGLE_TOLERANCE_DEG,
    Line,
    Plane,
    angle_line_plane,
    rake_of,
)
from vomstudio.geology.slip import slip_rake
from vomstudio.io.text.column_names import plain
from vomstudio.io.text.file_text import MOST_OBJECTS
from vomstudio.io.text.repeated_rows import first_picks
from vomstudio.io.text.rows import parse_number
from vomstudio.io.text.tables import TextTable, read_table

OFF_PLANE_DEG = 10.0
"""Striae that leave their plane by more are doubtful."""

_NAMES = {
    "dip_direction": (
        "on_plane_dip_direction_deg",
        "dip_direction_deg",
        "dip_direction",
        "dipdir",
        "dip_dir",
        "dd",
    ),
    "strike": ("strike", "strike_rhr_deg", "strike_rhr", "fault_strike"),
    "dip": ("on_plane_dip_deg", "dip_deg", "dip", "fault_dip"),
    "slip_rake": ("slip_rake_deg", "slip_rake"),
    "trend": ("trend_deg", "trend", "azimuth", "striae_trend", "line_trend"),
    "plunge": ("plunge_deg", "plunge", "striae_plunge", "line_plunge"),
    "rake": ("rake_deg", "rake", "pitch"),
    "sense": ("sense", "slip_sense", "slip", "movement"),
    "id": ("name", "label", "id"),
}

_ONE = {
    "normal": ("n", "normal", "nf"),
    "reverse": ("r", "i", "t", "reverse", "inverse", "thrust", "tf"),
    "sinistral": ("s", "l", "ll", "sinistral", "left", "left_lateral"),
    "dextral": ("d", "rl", "dextral", "right", "right_lateral"),
}
_SENSES = {plain(word): sense for sense, words in _ONE.items() for word in words}
_TWO = {
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
"""Letters of both parts of an oblique slip, FaultKin's first."""


_SENSE_WORDS = ("N", "R", "S", "D", "TR", "TL", "NR", "NL")
_EXAMPLE_HEADER = ("dip_direction", "dip", "trend", "plunge", "sense")


@dataclass(frozen=True, eq=False)
class SlipTable:
    """n faults with the directed rake of their slip. dropped : lines without all that is needed"""

    path: Path
    ids: tuple[str, ...]
    dip_direction_deg: FloatArray
    dip_deg: FloatArray
    slip_rake_deg: FloatArray
    dropped: tuple[int, ...]
    warnings: tuple[Finding, ...]

    def __len__(self) -> int:
        return len(self.ids)


def read_slips(path: str | Path) -> SlipTable:
    """Raises InputError, which names file, line and column, for a table without the columns, angles
    that cannot be, senses that are no word for one, and where no row has all of them."""
    return slips_of(read_table(path, most=MOST_OBJECTS))


def slips_of(table: TextTable) -> SlipTable:
    """Of a table that has been read, without rows that repeat others. Raises as `read_slips`."""
    table = first_picks(table)
    columns = {
        part: place
        for part, names in _NAMES.items()
        if (place := _column(table, names)) is not None
    }
    _check(table, columns)
    cells = {part: table.cells(column) for part, column in columns.items()}
    notes = list(table.notes)
    if "sense" in cells and _right_is_r(cells["sense"]):
        cells["sense"] = ["RL" if plain(word) == "r" else word for word in cells["sense"]]
        notes.append(Finding("slip.right-lateral"))
    faults: list[tuple[str, Plane, float]] = []
    dropped: list[int] = []
    off: list[int] = []
    for row, line in enumerate(table.line_numbers.tolist()):
        found = _Row(table.path, line, {part: c[row].strip() for part, c in cells.items()}).read()
        if found is None:
            dropped.append(line)
            continue
        plane, slip, away = found
        name = cells["id"][row].strip() if "id" in cells else ""
        faults.append((name or str(row + 1), plane, slip))
        if away > OFF_PLANE_DEG:
            off.append(line)
    if not faults:
        raise InputError(
            Finding("table.no-valid-rows", count=len(table), needed=tr("fault, slip and sense")),
            file=table.path,
        )
    return SlipTable(
        table.path,
        tuple(name for name, _, _ in faults),
        np.array([plane.dip_direction_deg for _, plane, _ in faults]),
        np.array([plane.dip_deg for _, plane, _ in faults]),
        np.array([slip for _, _, slip in faults]),
        tuple(dropped),
        (*notes, *_row_findings(dropped, off)),
    )


def _row_findings(dropped: list[int], off: list[int]) -> list[Finding]:
    findings = []
    if dropped:
        findings.append(
            Finding(
                "table.rows-left-out",
                count=len(dropped),
                needed=tr("fault, slip and sense"),
                lines=dropped,
            )
        )
    if off:
        findings.append(
            Finding("slip.off-plane", count=len(off), angle_deg=OFF_PLANE_DEG, lines=off)
        )
    return findings


def _column(table: TextTable, names: tuple[str, ...]) -> int | None:
    titles = [plain(title) for title in table.names or ()]
    for name in names:
        if plain(name) in titles:
            return titles.index(plain(name))
    return None


def _check(table: TextTable, columns: dict[str, int]) -> None:
    """Raises InputError for what is missing."""
    missing = None
    if "dip" not in columns or not ({"strike", "dip_direction"} & columns.keys()):
        missing = tr("strike (or dip direction) and dip of the fault")
    elif "slip_rake" not in columns:
        if not ({"trend", "plunge"} <= columns.keys() or "rake" in columns):
            missing = tr("trend and plunge, or rake, of the striae")
        elif "sense" not in columns:
            missing = tr("sense of slip")
    if missing is not None:
        finding = Finding(
            "slip.missing-columns",
            missing=missing,
            example=(table.delimiter if table.delimiter.strip() else " ").join(_EXAMPLE_HEADER),
        )
        raise table.header_error(finding, None)


def _right_is_r(words: Sequence[str]) -> bool:
    """Whether R alone stands for right-lateral: beside T, which is FaultKin's thrust, or L, where
    no other letter tells a dextral movement."""
    found = {plain(word) for word in words}
    others = {"i", "s", "d", "rl", "rd", "rs", "dextral", "right", "right_lateral"}
    return "r" in found and bool(found & {"t", "l", "tr", "tl"}) and not found & others


class _Row:
    """One fault being understood."""

    def __init__(self, path: Path, line: int, cells: dict[str, str]) -> None:
        self.path, self.line, self.cells = path, line, cells

    def read(self) -> tuple[Plane, float, float] | None:
        """Plane, directed rake, and by how much the line leaves the plane; None for a row without
        all of them."""
        dip, strike = self._number("dip"), self._number("strike")
        azimuth = self._number("dip_direction")
        by_strike = azimuth is None
        if azimuth is None and strike is not None:
            azimuth = strike + 90.0
        if dip is None or azimuth is None:
            return None
        try:
            plane = Plane(azimuth, dip)
            turn = _turn_of_strike(plane, azimuth - 90.0, by_strike=by_strike)
            directed = self._number("slip_rake")
            if directed is not None:
                return plane, _directed_from(plane, directed, turn), 0.0
            rake, away = self._rake(plane, turn)
        except GeometryError as error:
            raise InputError(error, file=self.path, line=self.line, field=error.field) from error
        word = self.cells.get("sense", "")
        if rake is None or not word or plain(word) in ("x", "unknown"):
            return None
        slip = self._slip(plane, rake, word)
        return None if slip is None else (plane, slip, away)

    def _rake(self, plane: Plane, turn: float) -> tuple[float | None, float]:
        trend, plunge = self._number("trend"), self._number("plunge")
        if trend is not None and plunge is not None:
            line = Line(trend, plunge)
            return rake_of(line, plane), angle_line_plane(line, plane)
        cell = self.cells.get("rake", "")
        if cell and cell[-1].isalpha() and parse_number(cell, decimal_comma=True) is None:
            try:
                return parse_rake(cell, plane), 0.0
            except InputError as error:
                raise self._error(error) from error
        rake = self._number("rake")
        return (None if rake is None else _axial_from(plane, rake, turn)), 0.0

    def _slip(self, plane: Plane, rake: float, word: str) -> float | None:
        """Directed; None where the sense does not tell which way."""
        known = _SENSES.get(plain(word))
        senses = (known,) if known is not None else _TWO.get(plain(word))
        if senses is None:
            raise self._error(Finding("table.unknown-word", cell=word, words=_SENSE_WORDS))
        found = [slip for sense in senses if (slip := slip_rake(plane, rake, sense)) is not None]
        if len(found) == 2 and abs(found[0] - found[1]) > ANGLE_TOLERANCE_DEG:
            raise self._error(Finding("slip.contradiction", word=word, rake_deg=rake))
        return found[0] if found else None

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


def _turn_of_strike(plane: Plane, strike_deg: float, *, by_strike: bool) -> float:
    """By how much the strike that a row's rake is counted from is ahead of the one that ours are:
    on a horizontal plane of that of dip direction 0, on a vertical one of that under 180 where the
    row states a strike and no dip direction."""
    if plane.undefined:
        return (strike_deg - 270.0) % 360.0
    return 180.0 if plane.vertical and by_strike and strike_deg % 360.0 >= 180.0 else 0.0


def _axial_from(plane: Plane, rake_deg: float, turn: float) -> float:
    """The rake of a line from our strike, [0, 180)."""
    if plane.undefined:
        return (rake_deg + turn) % 180.0
    # From the other end of the same strike, down the same way.
    return (turn - rake_deg if turn else rake_deg) % 180.0


def _directed_from(plane: Plane, rake_deg: float, turn: float) -> float:
    """The directed rake from our strike."""
    if plane.undefined and turn:
        return 180.0 - (180.0 - (rake_deg - turn)) % 360.0
    # The other wall is the hanging one, and moves the other way.
    return -rake_deg if turn else rake_deg
