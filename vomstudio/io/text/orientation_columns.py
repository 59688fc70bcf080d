"""Columns of an orientation table by their meaning, and the angles in them."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.geology.notation import parse_angle, parse_azimuth, parse_plane
from vomstudio.geometry.vectors import wrap360
from vomstudio.io.text.column_names import normalise_name
from vomstudio.io.text.flags import is_overturned
from vomstudio.io.text.rows import parse_number
from vomstudio.io.text.tables import TextTable

Azimuth = Literal["strike", "dipdir"]

# Azimuths outside [0, 360] by up to one full turn are wrapped.
_MIN_AZIMUTH_DEG, _MAX_AZIMUTH_DEG = -360.0, 720.0

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
    "azimuth": {"azimuth", "azimut", "azim", "azi", "az", "fazi", "faultazimuth"},
    "inclination": {"inclination", "incl", "inc", "finc", "faultinclination"},
    "trend": {"trend", "bearing", "trendazimuth", "plungeazimuth", "plungedirection", "plungedir"}
    | {"lazi", "lineazimuth", "striaetrend", "linetrend"},
    "plunge": {"plunge", "plungeangle", "plungeamount"}
    | {"linc", "lineinclination", "striaeplunge", "lineplunge"},
    "declination": {"dec", "decl", "declination"},
    "pole trend": {"poletrend", "trendofpole", "poleazimuth"},
    "pole plunge": {"poleplunge", "plungeofpole"},
    "normal x": {"nx", "normalx", "xnormal", "gx", "orientx"},
    "normal y": {"ny", "normaly", "ynormal", "gy", "orienty"},
    "normal z": {"nz", "normalz", "znormal", "gz", "orientz"},
    "attitude": {"attitude", "orientation", "planeorientation"}
    | {"dipdirectiondip", "dipdirdip", "dddip", "strikedip", "strikerhrdip"},
    "line attitude": {"trendplunge", "lineorientation", "lineattitude"},
    "polarity": {"polarity", "dippolarity"},
    "element": {"element"},
    "kind": {"kind", "type", "featuretype", "planetype"},
    "set": {"set", "sets", "setname", "family"},
    "id": {"id", "fid", "uid", "number", "no", "nr"},
    "overturned": {"overturned", "isoverturned", "inverted", "overturnedbed", "overturnedbedding"}
    | {"bedoverturned", "invertedbed", "beddingoverturned", "upsidedown"},
}
LINE_WORDS = ("lineation", "slickenline", "slickenfib", "stria", "fold axis", "hinge", "rodding")
"""Parts of the names of structures that are lines."""
_LINE_CODE = re.compile(r"l\d*")
"""Code of a lineation, such as L1, as opposed to S1 of a foliation."""
_GEMS_FIELD = "orientationconfidencedegrees"
_GEMPY_FIELDS = {"azimuth", "dip", "polarity"}
_LOOP_FIELDS = {"featurename", "nx", "ny", "nz", "interface"}
_PRINCIPAL_AXIS = re.compile(r"k([123])(?:dec|declination|trend|azi)")
"""Declination of a principal axis of the magnetic susceptibility, such as K1dec."""
_AXIS_PLUNGES = ("inc", "inclination", "plunge")
_COMPASS_POINT = re.compile(r"[NSEW]{1,3}", re.IGNORECASE)
_BEARING = re.compile(
    r"[NSEW]{1,3}(\s*\d+([.,]\d+)?\s*(°\s*)?[EW]?)?|\d+([.,]\d+)?\s*(°\s*)?[NSEW]{1,3}",
    re.IGNORECASE,
)

_QUADRANT_PAIR = re.compile(r"[NS]\s*\d+.*[EW].*\d", re.IGNORECASE)
_FIELD_NOTATION = re.compile(r"[°º˚]|^\s*[NSEW]{1,3}\s*(\d|$)", re.IGNORECASE)
"""Angle in field notation: 45°, N45E, NW."""


class OrientationColumns:
    """Columns of a table by their meaning; problems are appended to `warnings`."""

    def __init__(self, table: TextTable, warnings: list[Finding]) -> None:
        self.table = table
        self.warnings = warnings
        self._columns = self._find_columns()

    def _find_columns(self) -> dict[str, int]:
        """Return the columns by meaning; a repeated meaning is an error only if it is used."""
        columns: dict[str, int] = {}
        self._repeated_names: dict[str, list[str]] = {}
        for i, name in enumerate(self.table.names or ()):
            for meaning, aliases in ALIASES.items():
                if normalise_name(name) not in aliases:
                    continue
                if meaning in columns:
                    first_label = self.table.label(columns[meaning])
                    self._repeated_names.setdefault(meaning, [first_label]).append(name)
                else:
                    columns[meaning] = i
        if "set" not in columns:
            for i, name in enumerate(self.table.names or ()):
                if normalise_name(name) == "domain":
                    columns["set"] = i
        return columns

    @property
    def known_columns(self) -> set[int]:
        """Numbers of the columns with a known meaning."""
        return set(self._columns.values())

    def find(self, meaning: str) -> int | None:
        """Return the first column with a meaning, or None."""
        return self._columns.get(meaning)

    def find_unique(self, meaning: str) -> int | None:
        """Return the column with a meaning, or None. Raises InputError if there are several."""
        if meaning in self._repeated_names:
            raise InputError(
                Finding(
                    "table.repeated-column", column=meaning, columns=self._repeated_names[meaning]
                ),
                file=self.table.path,
                line=self.table.header_line,
                field=meaning,
            )
        return self.find(meaning)

    @property
    def are_gems_fields(self) -> bool:
        """Whether the columns are those of the USGS standard GeMS, with right-hand-rule strikes."""
        return any(normalise_name(name) == _GEMS_FIELD for name in self.table.names or ())

    @property
    def are_gempy_fields(self) -> bool:
        """Whether the columns are those of GemPy, whose azimuth is a dip direction."""
        return set(map(normalise_name, self.table.names or ())) >= _GEMPY_FIELDS

    @property
    def are_loop_fields(self) -> bool:
        """Whether the columns are those of this program's export for LoopStructural.

        Its normals point to the younger rocks. Other files may use the opposite direction.
        """
        return set(map(normalise_name, self.table.names or ())) >= _LOOP_FIELDS

    def principal_axes(self) -> dict[str, tuple[int, int]]:
        """Return the columns of declination and inclination of each axis K1, K2, K3."""
        names = [normalise_name(name) for name in self.table.names or ()]
        axes = {}
        for i, name in enumerate(names):
            if (match := _PRINCIPAL_AXIS.fullmatch(name)) is None:
                continue
            plunges = [f"k{match[1]}{word}" for word in _AXIS_PLUNGES]
            if (
                plunge_column := next((j for j, n in enumerate(names) if n in plunges), None)
            ) is not None:
                axes[f"K{match[1]}"] = (i, plunge_column)
        return dict(sorted(axes.items()))

    def attitude_column(self) -> int | None:
        """Return the first column in which each cell contains both angles of a plane, or None."""
        for column in range(self.table.width):
            cells = [cell for cell in self.table.cells(column) if cell]
            if cells and column not in self.known_columns and all(map(is_attitude, cells)):
                return column
        return None

    def are_lines(self) -> BoolArray:
        """Return whether the type or structure of each row (n,) denotes a line."""
        column = self.find("kind")
        for i, name in enumerate(self.table.names or ()):
            if column is None and normalise_name(name) == "structure":
                column = i
        if column is None:
            return np.zeros(len(self.table), bool)
        texts = [cell.casefold() for cell in self.table.cells(column)]
        is_line = [
            _LINE_CODE.fullmatch(word) is not None or any(part in word for part in LINE_WORDS)
            for word in texts
        ]
        return np.array(is_line, bool)

    def words(self, meaning: str, rows: IntArray) -> tuple[str, ...] | None:
        """Return the text in selected rows of a column, or None if it is missing or empty."""
        column = self.find(meaning)
        if column is None:
            return None
        cells = self.table.labels(column)
        texts = tuple(cells[i] for i in rows)
        return texts if any(texts) else None

    def overturned(self, rows: IntArray) -> tuple[bool | None, ...] | None:
        """Return whether each of the selected beds is overturned.

        Returns
        -------
        tuple of bool or None
            None for an empty cell; an unknown word counts as False and is reported. Returns None
            instead of a tuple if the table has no such column.
        """
        cells = self.words("overturned", rows)
        if cells is None:
            return self._overturned_polarity(rows)
        flags = [is_overturned(cell) for cell in cells]
        unclear_rows = [i for i, flag in enumerate(flags) if flag is None]
        if unclear_rows:
            self.warnings.append(
                Finding(
                    "orientation.unclear-overturned",
                    column=self.quoted_names(self._columns["overturned"]),
                    word=cells[unclear_rows[0]],
                    lines=[int(self.table.line_numbers[rows[i]]) for i in unclear_rows],
                )
            )
        return tuple(
            flag is True if cell else None for cell, flag in zip(cells, flags, strict=True)
        )

    def _overturned_polarity(self, rows: IntArray) -> tuple[bool | None, ...] | None:
        """Return whether the polarity of each selected bed is -1, as in GemPy.

        Returns None if there is no column of polarities.
        """
        column = self.find("polarity")
        if column is None:
            return None
        flags = {"1": False, "-1": True, "0": None, "": None}
        cells = [cell.removesuffix(".0") for cell in self.table.cells(column)]
        if not set(cells) <= flags.keys():
            return None
        return tuple(flags[cells[row]] for row in rows)

    def quoted_names(self, *columns: int) -> str:
        """Return the names of columns for a sentence."""
        names = [self.table.label(column) for column in columns]
        return ", ".join(f"'{name}'" if self.table.names else name for name in names)

    def azimuths(self, column: int, is_undefined: BoolArray) -> FloatArray:
        """Return azimuths (n,) in [0, 360), in degrees; 0 where `is_undefined` is True.

        Raises InputError for values that differ from this range by more than a full turn.
        """
        values = np.where(is_undefined, 0.0, self._angles(column, parse_azimuth))
        is_outside = np.isfinite(values) & ((values < 0.0) | (values > 360.0))
        is_invalid = np.isinf(values) | (
            is_outside & ((values < _MIN_AZIMUTH_DEG) | (values > _MAX_AZIMUTH_DEG))
        )
        if is_invalid.any():
            raise self._out_of_range_error(
                int(np.argmax(is_invalid)), column, values, _MIN_AZIMUTH_DEG, _MAX_AZIMUTH_DEG
            )
        self.report_wrapped(column, [int(n) for n in self.table.line_numbers[is_outside]])
        return np.asarray(wrap360(values))

    def report_wrapped(self, column: int, lines: list[int]) -> None:
        """Report azimuths outside [0, 360] in the given lines."""
        if lines:
            self.warnings.append(
                Finding(
                    "orientation.azimuths-wrapped",
                    count=len(lines),
                    column=self.quoted_names(column),
                    lines=lines,
                )
            )

    def inclinations(self, column: int, min_value: float) -> FloatArray:
        """Return dips or plunges (n,) in [min_value, 90], in degrees. Raises InputError."""
        values = self._angles(column, parse_angle)
        is_outside = ~np.isnan(values) & ~((values >= min_value) & (values <= 90.0))
        if is_outside.any():
            raise self._out_of_range_error(
                int(np.argmax(is_outside)), column, values, min_value, 90.0
            )
        return values

    def _angles(self, column: int, parse: Callable[[str], float]) -> FloatArray:
        """Return numbers (n,) from numerical cells or field notation (N45E, 45°)."""
        try:
            return self.table.numbers([column])[:, 0]
        except InputError:
            cells = self.table.cells(column)
            if not any(map(_FIELD_NOTATION.search, cells)):
                raise
        return np.array([self._angle(i, column, cell, parse) for i, cell in enumerate(cells)])

    def _angle(self, row: int, column: int, cell: str, parse: Callable[[str], float]) -> float:
        number = parse_number(cell, decimal_comma=self.table.delimiter in ";\t")
        if number is not None:
            return number
        try:
            return parse(cell)
        except InputError as error:
            raise InputError(
                error,
                file=self.table.path,
                line=int(self.table.line_numbers[row]),
                field=self.table.label(column),
            ) from error

    def _out_of_range_error(
        self, row: int, column: int, values: FloatArray, min_value: float, max_value: float
    ) -> InputError:
        value = float(values[row])
        if (min_value, max_value) == (0.0, 90.0) and 90.0 < value < 180.0:
            finding = Finding("orientation.overturned-dip", value=value, dip=180.0 - value)
        else:
            finding = Finding(
                "angle.out-of-range", value=value, minimum=min_value, maximum=max_value
            )
        return InputError(
            finding,
            file=self.table.path,
            line=int(self.table.line_numbers[row]),
            field=self.table.label(column),
        )

    def has_letters(self, column: int) -> bool:
        """Return whether any cell is a bearing or quadrant, such as N30E or 40SE."""
        return any(_BEARING.fullmatch(cell) for cell in self.table.cells(column))

    def are_compass_points(self, column: int) -> bool:
        """Return whether all cells are compass points."""
        cells = [cell for cell in self.table.cells(column) if cell]
        return bool(cells) and all(_COMPASS_POINT.fullmatch(cell) for cell in cells)


def is_attitude(cell: str) -> bool:
    """Return whether a cell contains both angles of a plane: 120/30, N30E/45SE, 45 -> 120.

    Parameters
    ----------
    cell : str

    Returns
    -------
    bool
    """
    if not any(separator in cell for separator in "/→>") and _QUADRANT_PAIR.search(cell) is None:
        return False
    try:
        parse_plane(cell)
    except InputError:
        return False
    return True


def has_orientations(names: Sequence[str]) -> bool:
    """Return whether the names of columns include angles of planes or lines.

    Parameters
    ----------
    names : sequence of str

    Returns
    -------
    bool
    """
    words = {normalise_name(name) for name in names}
    return any(words & ALIASES[meaning] for meaning in _ANGLE_MEANINGS) or any(
        _PRINCIPAL_AXIS.fullmatch(word) for word in words
    )


_ANGLE_MEANINGS = (
    "dip",
    "inclination",
    "plunge",
    "pole plunge",
    "normal x",
    "attitude",
    "line attitude",
)


def parse_convention(path: Path) -> Azimuth | None:
    """Return the convention stated in a file name such as `fold_strike_dip.txt`, or None."""
    name = normalise_name(path.stem)
    conventions: list[Azimuth] = []
    if "strike" in name:
        conventions.append("strike")
    if "dipdir" in name or "dipazi" in name:
        conventions.append("dipdir")
    return conventions[0] if len(conventions) == 1 else None
