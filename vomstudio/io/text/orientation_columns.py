"""What the columns of a table of orientations mean, and the angles in them."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Literal

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.geology.notation import parse_angle, parse_azimuth
from vomstudio.geometry.vectors import wrap360
from vomstudio.io.text.column_names import plain
from vomstudio.io.text.flags import is_overturned
from vomstudio.io.text.rows import parse_number
from vomstudio.io.text.tables import TextTable

Azimuth = Literal["strike", "dipdir"]

# An azimuth of a table is taken modulo 360 up to a whole turn beyond.
_LEAST_DEG, _MOST_DEG = -360.0, 720.0

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
    "element": {"element"},
    "kind": {"kind", "type", "featuretype", "planetype"},
    "set": {"set", "sets", "setname", "family"},
    "id": {"id", "fid", "uid", "number", "no", "nr"},
    "overturned": {"overturned", "isoverturned", "inverted", "overturnedbed", "overturnedbedding"}
    | {"bedoverturned", "invertedbed", "beddingoverturned", "upsidedown"},
}
_WIND = re.compile(r"[NSEW]{1,3}", re.IGNORECASE)
_BEARING = re.compile(
    r"[NSEW]{1,3}(\s*\d+([.,]\d+)?\s*(°\s*)?[EW]?)?|\d+([.,]\d+)?\s*(°\s*)?[NSEW]{1,3}",
    re.IGNORECASE,
)

_WRITTEN = re.compile(r"[°º˚]|^\s*[NSEW]{1,3}\s*(\d|$)", re.IGNORECASE)
"""An angle that is more than a number: 45°, N45E, NW."""


class Columns:
    """The columns of one table by what they mean. `warnings` grows with what is strange in them."""

    def __init__(self, table: TextTable, warnings: list[Finding]) -> None:
        self.table = table
        self.warnings = warnings
        self._by_meaning = self._found()

    def _found(self) -> dict[str, int]:
        """Column by what it means; a meaning claimed twice is an error only where it is needed."""
        found: dict[str, int] = {}
        self._claimed_twice: dict[str, list[str]] = {}
        for i, name in enumerate(self.table.names or ()):
            for meaning, aliases in ALIASES.items():
                if plain(name) not in aliases:
                    continue
                if meaning in found:
                    first = self.table.label(found[meaning])
                    self._claimed_twice.setdefault(meaning, [first]).append(name)
                else:
                    found[meaning] = i
        if "set" not in found:
            for i, name in enumerate(self.table.names or ()):
                if plain(name) == "domain":
                    found["set"] = i
        return found

    @property
    def known(self) -> set[int]:
        """Those of which the meaning is known."""
        return set(self._by_meaning.values())

    def find(self, meaning: str) -> int | None:
        """The first column that means this, None where there is none."""
        return self._by_meaning.get(meaning)

    def take(self, meaning: str) -> int | None:
        """The column that means this, None where there is none. Raises InputError where there are
        several."""
        if meaning in self._claimed_twice:
            raise InputError(
                Finding(
                    "table.repeated-column", column=meaning, columns=self._claimed_twice[meaning]
                ),
                file=self.table.path,
                line=self.table.header_line,
                field=meaning,
            )
        return self.find(meaning)

    def words(self, meaning: str, kept: IntArray) -> tuple[str, ...] | None:
        """The cells of a column, None where there is none or nothing in it."""
        column = self.find(meaning)
        if column is None:
            return None
        cells = self.table.labels(column)
        words = tuple(cells[i] for i in kept)
        return words if any(words) else None

    def overturned(self, kept: IntArray) -> tuple[bool | None, ...] | None:
        """(n,) which beds are overturned, None in an empty cell and where no column says so. A word
        that is neither yes nor no counts as no, and is told."""
        cells = self.words("overturned", kept)
        if cells is None:
            return None
        said = [is_overturned(cell) for cell in cells]
        unclear = [i for i, answer in enumerate(said) if answer is None]
        if unclear:
            self.warnings.append(
                Finding(
                    "orientation.unclear-overturned",
                    column=self.named(self._by_meaning["overturned"]),
                    word=cells[unclear[0]],
                    lines=[int(self.table.line_numbers[kept[i]]) for i in unclear],
                )
            )
        return tuple(
            answer is True if cell else None for cell, answer in zip(cells, said, strict=True)
        )

    def named(self, *columns: int) -> str:
        names = [self.table.label(c) for c in columns]
        return ", ".join(f"'{n}'" if self.table.names else n for n in names)

    def azimuths(self, column: int, undefined: BoolArray) -> FloatArray:
        """(n,) in [0, 360); 0 where the direction is `undefined`, whatever is written there."""
        values = np.where(undefined, 0.0, self._angles(column, parse_azimuth))
        outside = np.isfinite(values) & ((values < 0.0) | (values > 360.0))
        hopeless = np.isinf(values) | (outside & ((values < _LEAST_DEG) | (values > _MOST_DEG)))
        if hopeless.any():
            raise self._outside(int(np.argmax(hopeless)), column, values, _LEAST_DEG, _MOST_DEG)
        self.say_wrapped(column, [int(n) for n in self.table.line_numbers[outside]])
        return np.asarray(wrap360(values))

    def say_wrapped(self, column: int, where: list[int]) -> None:
        if where:
            self.warnings.append(
                Finding(
                    "orientation.azimuths-wrapped",
                    count=len(where),
                    column=self.named(column),
                    lines=where,
                )
            )

    def inclinations(self, column: int, lowest: float) -> FloatArray:
        """(n,) dips or plunges, which must lie in [lowest, 90]."""
        values = self._angles(column, parse_angle)
        outside = ~np.isnan(values) & ~((values >= lowest) & (values <= 90.0))
        if outside.any():
            raise self._outside(int(np.argmax(outside)), column, values, lowest, 90.0)
        return values

    def _angles(self, column: int, read: Callable[[str], float]) -> FloatArray:
        """(n,) numbers, or angles as they stand in field books (N45E, 45°)."""
        try:
            return self.table.numbers([column])[:, 0]
        except InputError:
            cells = self.table.cells(column)
            if not any(map(_WRITTEN.search, cells)):
                raise
        return np.array([self._angle(i, column, cell, read) for i, cell in enumerate(cells)])

    def _angle(self, row: int, column: int, cell: str, read: Callable[[str], float]) -> float:
        number = parse_number(cell, decimal_comma=self.table.delimiter in ";\t")
        if number is not None:
            return number
        try:
            return read(cell)
        except InputError as error:
            raise InputError(
                error,
                file=self.table.path,
                line=int(self.table.line_numbers[row]),
                field=self.table.label(column),
            ) from error

    def _outside(
        self, row: int, column: int, values: FloatArray, lowest: float, highest: float
    ) -> InputError:
        value = float(values[row])
        if (lowest, highest) == (0.0, 90.0) and 90.0 < value < 180.0:
            finding = Finding("orientation.overturned-dip", value=value, dip=180.0 - value)
        else:
            finding = Finding("angle.out-of-range", value=value, minimum=lowest, maximum=highest)
        return InputError(
            finding,
            file=self.table.path,
            line=int(self.table.line_numbers[row]),
            field=self.table.label(column),
        )

    def has_letters(self, column: int) -> bool:
        """Whether a cell is a bearing or a quadrant, such as N30E or 40SE."""
        return any(_BEARING.fullmatch(cell) for cell in self.table.cells(column))

    def are_winds(self, column: int) -> bool:
        cells = [c for c in self.table.cells(column) if c]
        return bool(cells) and all(_WIND.fullmatch(c) for c in cells)


def convention_in_name(path: Path) -> Azimuth | None:
    """strike or dipdir where the name of a file, such as `fold_strike_dip.txt`, says just one."""
    name = plain(path.stem)
    said: list[Azimuth] = []
    if "strike" in name:
        said.append("strike")
    if "dipdir" in name or "dipazi" in name:
        said.append("dipdir")
    return said[0] if len(said) == 1 else None
