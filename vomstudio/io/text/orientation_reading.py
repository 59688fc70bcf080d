"""Orientation tables of others, and our own: which column means what, said aloud.

A table of planes gives a dip direction or a strike, and a dip; a table of lines a trend and a
plunge; our own gives both, row by row. What a column is called decides; a bare `azimuth`, or two
columns without a header, can be a strike as well as a dip direction, 90 degrees apart, and nothing
in the numbers tells: then the user must.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vomstudio.errors import InputError, UsageError, VomError
from vomstudio.geology.notation import parse_plane
from vomstudio.geology.orientation import (
    Plane,
    lines_to_vectors,
    planes_to_poles,
    wrap360,
)
from vomstudio.io.text.rows import shortened
from vomstudio.io.text.tables import TextTable, lines_in_words, plain, read_table

Azimuth = Literal["strike", "dipdir"]

ALIASES: dict[str, set[str]] = {
    "dip direction": {"dipdirection", "dipdir", "dipdirn", "ddir", "dd", "ddr", "azimuthofdip"}
    | {"dipazimuth", "dipazi", "dipaz", "dipdirectionazimuth", "directionofdip"},
    "strike": {"strike", "strikerhr", "rhrstrike", "strikerighthand", "strikerighthandrule"}
    | {"strikelhr", "lhrstrike", "strikelefthand", "strikelefthandrule", "strikeazimuth"},
    "dip": {"dip", "dipangle", "dipamount", "dipmagnitude", "angleofdip"},
    "quadrant": {"quadrant", "dipquadrant", "dipquad", "quad", "dipsector", "dipcardinal"}
    | {
        "dipdirectionquadrant",
        "dipside",
        "quadrantofdip",
        "dipto",
        "dipsto",
        "dipstowards",
        "dipstoward",
    },
    "azimuth": {"azimuth", "azimut", "azim", "azi", "az"},
    "trend": {"trend", "trendazimuth", "plungeazimuth", "plungedirection", "plungedir"},
    "plunge": {"plunge", "plungeangle", "plungeamount"},
    "pole trend": {"poletrend", "trendofpole", "poleazimuth"},
    "pole plunge": {"poleplunge", "plungeofpole"},
    "attitude": {"attitude", "orientation", "planeorientation"},
    "geometry": {"geometry", "geometrytype"},
    "kind": {"kind", "type", "featuretype", "planetype"},
    "set": {"set", "sets", "setname", "family", "domain"},
    "id": {"id", "fid", "uid", "number", "no", "nr"},
}
_QUADRANT_BY_ITS_CELLS = {"direction", "dir", "side", "sense", "dips"}
"""Names that mean a dip quadrant only where compass points stand below."""
_WIND = re.compile(r"[NSEW]{1,3}", re.IGNORECASE)
_BEARING = re.compile(
    r"[NSEW]{1,3}(\s*\d+([.,]\d+)?\s*°?\s*[EW]?)?|\d+([.,]\d+)?\s*°?\s*[NSEW]{1,3}", re.IGNORECASE
)
_PLANE, _LINE, _NEITHER = 1, 2, 0


@dataclass(frozen=True, eq=False)
class OrientationTable:
    """n planes and lines; NaN where a row is not of that geometry."""

    table: TextTable
    kept: NDArray[np.int64]
    """(n,) rows of `table` that these are; the others had no angles."""
    is_plane: NDArray[np.bool_]
    dip_direction_deg: NDArray[np.float64]
    dip_deg: NDArray[np.float64]
    trend_deg: NDArray[np.float64]
    """(n,) of lines; a horizontal plane or vertical line has azimuth 0."""
    plunge_deg: NDArray[np.float64]
    ids: tuple[str, ...]
    """The id column, or the row's number from 1."""
    kinds: tuple[str, ...] | None
    """The kind column, None where there is none, or nothing in it."""
    sets: tuple[str, ...] | None
    convention: str
    """How the columns were understood, for people."""
    dropped: tuple[int, ...]
    """Lines without angles."""
    warnings: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.kept)

    @property
    def line_numbers(self) -> NDArray[np.int64]:
        return self.table.line_numbers[self.kept]

    def column(self, key: str) -> list[str]:
        """(n,) the words of the column that the user calls `key`. Raises `UsageError`."""
        cells = self.table.labels(self.table.find(key))
        return [cells[i] for i in self.kept]

    def vectors(self) -> NDArray[np.float64]:
        """(n, 3) unit vectors, World: downward poles of the planes, and the lines as directed."""
        poles = planes_to_poles(self.dip_direction_deg, self.dip_deg)
        lines = lines_to_vectors(self.trend_deg, self.plunge_deg)
        return np.where(self.is_plane[:, None], poles, lines)


def read_orientations(path: str | Path, azimuth: Azimuth | None = None) -> OrientationTable:
    """Read planes and lines from a text table.

    azimuth: what a column called only `azimuth`, or the first of a table without header, means.
    Raises `InputError` (file, line, column) where the table is none, or its angles cannot be, and
    `UsageError` where the meaning of an azimuth must be given.
    """
    table = read_table(path)
    if not len(table):
        raise InputError(
            "there is a header and nothing below it; a table of orientations needs rows.",
            file=table.path,
            line=table.header_line,
        )
    return _Reading(table, azimuth).result()


class _Reading:
    """One table being understood: columns first, then planes, lines, and what is said of them."""

    def __init__(self, table: TextTable, azimuth: Azimuth | None) -> None:
        self.table = table
        self.azimuth = azimuth
        self.columns = self._known_columns()
        self.warnings = list(table.notes)
        self.said: list[str] = []
        n = len(table)
        self.dip_direction, self.dip, self.trend, self.plunge = np.full((4, n), np.nan)

    def result(self) -> OrientationTable:
        self._read_planes()
        self._read_lines()
        if not self.said:
            raise self._no_orientations()
        table = self.table
        has_plane = np.isfinite(self.dip_direction) & np.isfinite(self.dip)
        has_line = np.isfinite(self.trend) & np.isfinite(self.plunge)
        geometry = self._geometry(has_plane, has_line)
        kept = np.flatnonzero(geometry != _NEITHER)
        dropped = tuple(int(n) for n in table.line_numbers[geometry == _NEITHER])
        if dropped:
            self.warnings.append(
                f"{len(dropped)} row{'s' if len(dropped) > 1 else ''} without angles dropped: "
                f"{lines_in_words(dropped)}"
            )
        if not len(kept):
            raise InputError(
                f"none of its {len(table)} rows has both angles; fill in the columns.",
                file=table.path,
                line=int(table.line_numbers[0]),
            )
        plane = geometry[kept] == _PLANE

        def only(values: NDArray[np.float64], where: NDArray[np.bool_]) -> NDArray[np.float64]:
            return np.where(where, values[kept], np.nan)

        return OrientationTable(
            table=table,
            kept=kept,
            is_plane=plane,
            dip_direction_deg=only(self.dip_direction, plane),
            dip_deg=only(self.dip, plane),
            trend_deg=only(self.trend, ~plane),
            plunge_deg=only(self.plunge, ~plane),
            ids=self._words("id", kept) or tuple(str(i + 1) for i in kept),
            kinds=self._words("kind", kept),
            sets=self._words("set", kept),
            convention="; ".join(self.said),
            dropped=dropped,
            warnings=tuple(self.warnings),
        )

    # -- columns ---------------------------------------------------------------------------------

    def _known_columns(self) -> dict[str, int]:
        """Column by what it means; a meaning claimed twice is an error only where it is needed."""
        found: dict[str, int] = {}
        self.claimed_twice: dict[str, list[str]] = {}
        for i, name in enumerate(self.table.names or ()):
            for meaning, aliases in ALIASES.items():
                if plain(name) not in aliases:
                    continue
                if meaning in found:
                    first = self.table.label(found[meaning])
                    self.claimed_twice.setdefault(meaning, [first]).append(name)
                else:
                    found[meaning] = i
        return found

    def _take(self, meaning: str) -> int | None:
        """The column that means this, None where there is none."""
        if meaning in self.claimed_twice:
            names = ", ".join(self.claimed_twice[meaning])
            raise InputError(
                f"more than one column is the {meaning} ({names}); rename all but one.",
                file=self.table.path,
                line=self.table.header_line,
                field=meaning,
            )
        return self.columns.get(meaning)

    def _words(self, meaning: str, kept: NDArray[np.int64]) -> tuple[str, ...] | None:
        """The cells of a column, None where there is none or nothing in it."""
        column = self.columns.get(meaning)
        if column is None:
            return None
        cells = self.table.labels(column)
        words = tuple(cells[i] for i in kept)
        return words if any(words) else None

    def _named(self, *columns: int) -> str:
        names = [self.table.label(c) for c in columns]
        return ", ".join(f"'{n}'" if self.table.names else n for n in names)

    # -- planes ----------------------------------------------------------------------------------

    def _read_planes(self) -> None:
        table = self.table
        if table.names is None:
            self._read_headerless()
            return
        attitude, dip = self._take("attitude"), self._take("dip")
        strike, direction = self._take("strike"), self._take("dip direction")
        azimuth = self._take("azimuth")
        if dip is None:
            if strike is not None or direction is not None:
                raise InputError(
                    f"there is a column {self._named(_first(strike, direction))} but none for the "
                    "dip; name it 'dip'.",
                    file=table.path,
                    line=table.header_line,
                    field="dip",
                )
            self._read_poles_or_text(attitude)
            return
        quadrant = self._take("quadrant")
        if strike is not None and direction is not None and self._are_winds(direction):
            # `strike, dip, dip direction` with SE in the third: a quadrant by another name.
            quadrant, direction = direction, None
        if quadrant is None and direction is None and strike is not None:
            quadrant = self._quadrant_by_another_name()
        if direction is not None:
            self._from_dip_direction(direction, dip)
            if strike is not None:
                self._compare(strike)
        elif strike is not None:
            self._from_strike(strike, dip, quadrant)
        elif azimuth is None:
            raise InputError(
                f"there is a column {self._named(dip)} but none for the strike or dip direction; "
                "name it 'strike' or 'dip direction'.",
                file=table.path,
                line=table.header_line,
                field="dip direction",
            )
        elif quadrant is not None:
            self._from_strike(azimuth, dip, quadrant)
        else:
            self._from_azimuth(azimuth, dip)

    def _quadrant_by_another_name(self) -> int | None:
        """A column of compass points beside the strike. Where its name leaves open what it says
        (a limb? a site?), it is not used and that is told."""
        others = set(range(self.table.width)) - set(self.columns.values())
        winds = [c for c in sorted(others) if self._are_winds(c)]
        named = [c for c in winds if plain(self.table.label(c)) in _QUADRANT_BY_ITS_CELLS]
        if len(named) == 1:
            return named[0]
        if winds:
            self.warnings.append(
                f"{self._named(*winds)}: compass points that were not used; call the column "
                "'quadrant' if the planes dip to them"
            )
        return None

    def _read_headerless(self) -> None:
        if self.table.width < 2:
            raise InputError(
                "orientations need two columns, and this table has 1.",
                file=self.table.path,
                line=int(self.table.line_numbers[0]),
            )
        told = self.azimuth is not None
        self.azimuth = self.azimuth or _convention_in_name(self.table.path)
        if self.azimuth is None:
            raise UsageError(
                "this table has no header, and its first column can be strike or dip direction; "
                "say which with --azimuth strike or --azimuth dipdir, or add a header.",
                file=self.table.path,
                line=int(self.table.line_numbers[0]),
                field="column 1",
            )
        self._from_azimuth(0, 1)
        if not told:
            self.said.append("there is no header: strike or dip direction by the file's name")

    def _from_azimuth(self, azimuth: int, dip: int) -> None:
        if self.azimuth == "strike":
            self._from_strike(azimuth, dip, None)
        elif self.azimuth == "dipdir":
            self._from_dip_direction(azimuth, dip)
        else:
            raise UsageError(
                "an azimuth can be strike or dip direction; say which with --azimuth strike or "
                "--azimuth dipdir, or rename the column.",
                file=self.table.path,
                line=self.table.header_line,
                field=self.table.label(azimuth),
            )

    def _from_dip_direction(self, direction: int, dip: int) -> None:
        self.dip = self._inclinations(dip, 0.0)
        self.dip_direction = self._azimuths(direction, self.dip == 0.0)
        self.said.append(f"planes by dip direction/dip ({self._named(direction, dip)})")

    def _from_strike(self, strike: int, dip: int, quadrant: int | None) -> None:
        table = self.table
        named = self._named(strike, dip)
        if quadrant is not None:
            self._from_text([strike, dip, quadrant], "strike/dip")
            self.said.append(
                f"planes by strike/dip and the quadrant they dip to ({named}, "
                f"{self._named(quadrant)}); right-hand rule where that is empty"
            )
            return
        if self._has_letters(strike) or self._has_letters(dip):
            self._from_text([strike, dip], "strike/dip")
            self.said.append(
                f"planes by strike/dip with the quadrant in the cells ({named}); "
                "right-hand rule where there is none"
            )
            return
        left = re.search(r"lhr|left", table.label(strike), re.IGNORECASE) is not None
        self.dip = self._inclinations(dip, 0.0)
        azimuths = self._azimuths(strike, self.dip == 0.0)
        self.dip_direction = wrap360(azimuths + (270.0 if left else 90.0))
        self.dip_direction[self.dip == 0.0] = 0.0
        hand = "left" if left else "right"
        self.said.append(f"planes by strike ({hand}-hand rule)/dip ({named})")

    def _read_poles_or_text(self, attitude: int | None) -> None:
        trend, plunge = self._take("pole trend"), self._take("pole plunge")
        if trend is not None and plunge is not None:
            down = self._inclinations(plunge, 0.0)
            self.dip_direction = wrap360(self._azimuths(trend, down == 90.0) + 180.0)
            self.dip = 90.0 - down
            self.said.append(
                f"planes by the trend/plunge of their poles ({self._named(trend, plunge)})"
            )
        elif attitude is not None:
            meaning = {"strike": "strike/dip", "dipdir": "dipdir/dip"}.get(self.azimuth or "")
            self._from_text([attitude], meaning)
            pair = "strike/dip" if self.azimuth == "strike" else "dip direction/dip"
            self.said.append(
                f"planes as written in {self._named(attitude)}; two bare numbers are {pair}"
            )

    def _from_text(self, columns: list[int], notation: str | None) -> None:
        cells = [self.table.cells(c) for c in columns]
        wrapped: list[int] = []
        for i, words in enumerate(zip(*cells, strict=True)):
            if not all(words[:2]) or any(w.casefold() in ("nan", "na") for w in words[:2]):
                continue
            try:
                plane = plane_of(words, notation)
            except VomError as error:
                raise InputError(
                    error.message,
                    file=self.table.path,
                    line=int(self.table.line_numbers[i]),
                    field=self.table.label(columns[0]),
                ) from error
            self.dip_direction[i], self.dip[i] = plane.dip_direction_deg, plane.dip_deg
            if (azimuth := _bare_number(words[0])) is not None and azimuth > 360.0:
                wrapped.append(int(self.table.line_numbers[i]))
        self._say_wrapped(columns[0], wrapped)

    def _compare(self, strike: int) -> None:
        """Other programs mix strike conventions in one file; the dip direction is believed."""
        try:
            given = self.table.numbers([strike])[:, 0]
        except InputError:
            return
        turned = np.abs(wrap360(given + 90.0 - self.dip_direction + 180.0) - 180.0)
        off = np.flatnonzero((turned > 1.5) & (self.dip > 0))
        if len(off):
            where = [int(n) for n in self.table.line_numbers[off]]
            self.warnings.append(
                f"{self._named(strike)} is not dip direction - 90 in {len(off)} "
                f"row{'s' if len(off) > 1 else ''} ({lines_in_words(where)}); the dip direction "
                "was taken"
            )

    # -- lines -----------------------------------------------------------------------------------

    def _read_lines(self) -> None:
        plunge = self._take("plunge")
        trend = self._take("trend")
        if trend is None and "dip" not in self.columns:
            trend = self._take("azimuth")
        if plunge is None and trend is None:
            return
        if plunge is None or trend is None:
            if self.said or (trend is not None and "trend" not in self.columns):
                return
            missing = "plunge" if plunge is None else "trend"
            raise InputError(
                f"there is a column {self._named(_first(trend, plunge))} but none for the "
                f"{missing}; name it '{missing}'.",
                file=self.table.path,
                line=self.table.header_line,
                field=missing,
            )
        self.plunge = self._inclinations(plunge, -90.0)
        self.trend = self._azimuths(trend, np.abs(self.plunge) == 90.0)
        self.said.append(f"lines by trend/plunge ({self._named(trend, plunge)})")

    def _geometry(
        self, has_plane: NDArray[np.bool_], has_line: NDArray[np.bool_]
    ) -> NDArray[np.int64]:
        """(n,) what each row is. A row with both is a plane that bears a line."""
        result = np.where(has_plane, _PLANE, np.where(has_line, _LINE, _NEITHER))
        column = self.columns.get("geometry")
        if column is None:
            if both := int(np.count_nonzero(has_plane & has_line)):
                self.warnings.append(
                    f"{both} rows have a plane and a line; they were taken as planes: add a "
                    "column 'geometry' (plane or line) to choose"
                )
            return result
        for i, cell in enumerate(self.table.cells(column)):
            word = cell.casefold()
            if word in ("line", "lineation"):
                result[i] = _LINE if has_line[i] else _NEITHER
            elif word == "plane":
                result[i] = _PLANE if has_plane[i] else _NEITHER
            elif word:
                raise InputError(
                    f"'{shortened(cell)}' is neither plane nor line; write one of them.",
                    file=self.table.path,
                    line=int(self.table.line_numbers[i]),
                    field=self.table.label(column),
                )
        return result

    # -- angles ----------------------------------------------------------------------------------

    def _azimuths(self, column: int, undefined: NDArray[np.bool_]) -> NDArray[np.float64]:
        """(n,) in [0, 360); 0 where the direction is `undefined`, whatever is written there."""
        values = self.table.numbers([column])[:, 0]
        values = np.where(undefined, 0.0, values)
        outside = np.isfinite(values) & ((values < 0.0) | (values > 360.0))
        hopeless = np.isinf(values) | (outside & ((values < -360.0) | (values > 720.0)))
        if hopeless.any():
            raise self._outside(int(np.argmax(hopeless)), column, values, "0 to 360")
        self._say_wrapped(column, [int(n) for n in self.table.line_numbers[outside]])
        return np.asarray(wrap360(values))

    def _say_wrapped(self, column: int, where: list[int]) -> None:
        if where:
            self.warnings.append(
                f"{len(where)} azimuth{'s' if len(where) > 1 else ''} outside 0 to 360 in "
                f"{self._named(column)} taken modulo 360: {lines_in_words(where)}"
            )

    def _inclinations(self, column: int, lowest: float) -> NDArray[np.float64]:
        """(n,) dips or plunges, which must lie in [lowest, 90]."""
        values = self.table.numbers([column])[:, 0]
        outside = ~np.isnan(values) & ~((values >= lowest) & (values <= 90.0))
        if outside.any():
            raise self._outside(int(np.argmax(outside)), column, values, f"{lowest:g} to 90")
        return values

    def _outside(
        self, row: int, column: int, values: NDArray[np.float64], wanted: str
    ) -> InputError:
        hint = ""
        if wanted == "0 to 90":
            hint = " (are the columns in another order? an overturned bed is a flag, not a dip)"
        return InputError(
            f"{values[row]:g} is outside {wanted} degrees; correct it{hint}.",
            file=self.table.path,
            line=int(self.table.line_numbers[row]),
            field=self.table.label(column),
        )

    def _has_letters(self, column: int) -> bool:
        """Whether a cell is a bearing or a quadrant, such as N30E or 40SE."""
        return any(_BEARING.fullmatch(cell) for cell in self.table.cells(column))

    def _are_winds(self, column: int) -> bool:
        cells = [c for c in self.table.cells(column) if c]
        return bool(cells) and all(_WIND.fullmatch(c) for c in cells)

    def _no_orientations(self) -> InputError:
        names = ", ".join(self.table.names or ())
        return InputError(
            "there are no columns of orientations in the header "
            f"({shortened(names, 80)}); name them strike and dip, dip direction and dip, or trend "
            "and plunge.",
            file=self.table.path,
            line=self.table.header_line,
            field="dip",
        )


def _convention_in_name(path: Path) -> Azimuth | None:
    """strike or dipdir where the name of a file, such as `fold_strike_dip.txt`, says just one."""
    name = plain(path.stem)
    said: list[Azimuth] = []
    if "strike" in name:
        said.append("strike")
    if "dipdir" in name or "dipazi" in name:
        said.append("dipdir")
    return said[0] if len(said) == 1 else None


def _first(*columns: int | None) -> int:
    return next(c for c in columns if c is not None)


def _bare_number(cell: str) -> float | None:
    return float(cell.replace(",", ".")) if re.fullmatch(r"\d+([.,]\d*)?", cell) else None


def plane_of(words: tuple[str, ...], notation: str | None) -> Plane:
    """A plane from a cell, or from strike, dip and perhaps a quadrant in cells of their own."""
    if len(words) == 1:
        return parse_plane(words[0], notation)
    strike = words[0]
    azimuth = _bare_number(strike)
    if azimuth is not None and azimuth <= 720.0:
        strike = f"{wrap360(azimuth):.10g}"
    return parse_plane(" ".join([strike, *words[1:]]), notation)
