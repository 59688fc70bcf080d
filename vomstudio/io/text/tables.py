"""Tables of numbers and words in text files, as people really have them.

The rules are those of the command line's contract: the delimiter is a comma, a semicolon, a tab or
spaces, and is found by looking; `#` lines are comments; the first row is a header if and only if
one of its cells is not a number; a decimal comma is understood where the delimiter is `;` or a tab.
Every complaint names the file, the line as an editor counts it, and the column.

Long tables of plain numbers (a million points) go through numpy's own reader; only when that
stumbles are the cells looked at one by one, to say what is wrong and where.
"""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.coordinate_limits import FARTHEST_M
from vomstudio.io.text.column_names import doubtful_cell, plain
from vomstudio.io.text.file_text import MOST_LINES
from vomstudio.io.text.group_columns import COLUMNS, Words, words_of_groups
from vomstudio.io.text.rows import (
    TextRows,
    cut,
    is_comma_number,
    parse_number,
    read_rows,
    shortened,
)

TABLE_ENDINGS = (".csv", ".txt", ".tsv", ".dat")
"""Extensions that text tables usually have, for file dialogs."""

_SCIENTIFIC = re.compile(r"[+-]?\d\.\d+[eE][+-]\d{2,3}")


@dataclass(frozen=True, eq=False)
class TextTable:
    """The rows of one text file. Columns are counted from 0 here, from 1 in what users type."""

    path: Path
    names: tuple[str, ...] | None
    """The header's cells, or None where the first row is numbers already."""
    header_line: int | None
    width: int
    delimiter: str
    """`,`, `;`, a tab, or a space for any run of blanks."""
    comments: tuple[str, ...]
    notes: tuple[Finding, ...]
    """What was remarkable in reading, for people."""
    separators: tuple[int, ...]  # lines that are rules such as `---` between rows
    line_numbers: IntArray
    """(n,) the line in the file at which each row begins, counted from 1."""
    _text: TextRows = field(repr=False)
    repeats: int = 0  # rows that were left out since they repeat others
    commented: tuple[int, ...] = ()  # lines that look like rows

    def __len__(self) -> int:
        return len(self.line_numbers)

    def label(self, column: int) -> str:
        """How to speak of a column: its header, or `column 3`."""
        return self.names[column] if self.names else f"column {column + 1}"

    def header_error(
        self, finding: Finding, field: str | None, kind: type[InputError] = InputError
    ) -> InputError:
        """Return the error that a column is missing, or that the header may be a row of data."""
        cell = doubtful_cell(self.names or (), self.header_line, self.delimiter)
        if cell is not None:
            finding = Finding(
                "table.doubtful-header", column=field, header_line=self.header_line, cell=cell
            )
        return kind(finding, file=self.path, line=self.header_line, field=field)

    @cached_property
    def rows(self) -> list[list[str]]:
        """All cells, stripped; every row has `width` of them."""
        if self._text.rows is not None:
            return self._text.rows
        return [cut(line, self.delimiter) for line in self._text.lines]

    def cells(self, column: int, first: int | None = None) -> list[str]:
        """(n,) the words of one column, or only of its `first` rows."""
        if self._text.rows is not None:
            return [row[column] for row in self._text.rows[:first]]
        delimiter = None if self.delimiter == " " else self.delimiter
        lines = self._text.lines[:first]
        return [line.split(delimiter, column + 1)[column].strip() for line in lines]

    def labels(self, column: int) -> list[str]:
        """(n,) the words of a column that tells rows apart. Programs that write whole tables in
        scientific notation write the label 1 as 1.000000e+00."""
        cells = self.cells(column)
        labels = {
            cell: f"{float(cell):.15g}" if _SCIENTIFIC.fullmatch(cell) else cell
            for cell in set(cells)
        }
        return [labels[cell] for cell in cells]

    def numbers(self, columns: Sequence[int]) -> FloatArray:
        """(n, len(columns)) float64; an empty cell is NaN. Raises `InputError` at a word."""
        fast = self._fast_numbers(columns)
        if fast is not None:
            return fast
        result = np.empty((len(self), len(columns)))
        for place, column in enumerate(columns):
            result[:, place] = self._careful_numbers(column)
        return result

    def _fast_numbers(self, columns: Sequence[int]) -> FloatArray | None:
        if self._text.rows is not None or not len(self):
            return None
        try:
            return np.loadtxt(
                self._text.lines,
                delimiter=None if self.delimiter == " " else self.delimiter,
                comments=None,
                usecols=list(columns),
                ndmin=2,
            )
        except ValueError:
            return None

    def _careful_numbers(self, column: int) -> list[float]:
        values: list[float] = []
        comma_allowed = self.delimiter in ";\t"
        first_use: dict[str, int] = {}
        for i, cell in enumerate(self.cells(column)):
            value = parse_number(cell, decimal_comma=comma_allowed)
            if value is None:
                raise self._not_a_number(i, column, cell)
            values.append(value)
            for mark in ",.":
                if mark in cell:
                    first_use.setdefault(mark, i)
        if len(first_use) == 2:
            raise InputError(
                Finding("table.mixed-decimals"),
                file=self.path,
                line=int(self.line_numbers[max(first_use.values())]),
                field=self.label(column),
            )
        return values

    def _not_a_number(self, row: int, column: int, cell: str) -> InputError:
        code = "table.decimal-comma" if is_comma_number(cell) else "table.not-a-number"
        return InputError(
            Finding(code, cell=shortened(cell)),
            file=self.path,
            line=int(self.line_numbers[row]),
            field=self.label(column),
        )

    def find(self, key: str) -> int:
        """The column that the user calls `key`: a header (case and separators forgiven), or a
        number counted from 1. Raises `UsageError` where there is none, or more than one."""
        key = key.strip()
        if self.names:
            exact = [i for i, name in enumerate(self.names) if name == key]
            loose = [i for i, name in enumerate(self.names) if plain(name) == plain(key)]
            matches = exact or loose
            if len(matches) > 1:
                raise UsageError(
                    Finding(
                        "table.repeated-column",
                        column=key,
                        columns=[self.names[i] for i in matches],
                    ),
                    file=self.path,
                    line=self.header_line,
                    field=key,
                )
            if matches:
                return matches[0]
        if key.isascii() and key.isdigit():
            number = int(key) if len(key) < 10 else 0
            if 1 <= number <= self.width:
                return number - 1
        columns = [self.label(i) for i in range(self.width)]
        finding = Finding("table.unknown-column", column=key, columns=columns)
        raise self.header_error(finding, key, UsageError)

    def has(self, name: str) -> bool:
        """Whether a header reads `name`, case and separators forgiven."""
        return self.names is not None and plain(name) in map(plain, self.names)


@dataclass(frozen=True, eq=False)
class PointGroups:
    """Points of one or several features, those of one feature side by side.

    Group i is `points[offsets[i]:offsets[i + 1]]`; groups, and the points in them, keep the order
    of the file.
    """

    ids: tuple[str, ...]
    points: FloatArray
    """(n, 3) x, y, z as written, float64."""
    offsets: IntArray
    """(len(ids) + 1,)"""
    dropped: tuple[int, ...]
    """Lines whose coordinates are missing or not finite."""
    warnings: tuple[Finding, ...]
    words: Words[str] = field(default_factory=dict)
    """Kind and set of the groups that have one."""
    comments: tuple[str, ...] = ()
    """Comments of the table, which may name its CRS."""


def line_numbers_text(lines: Sequence[int], limit: int = 8) -> str:
    """`line 4`, `lines 4, 7 and 9`, or `lines 4, 5, 6, 7, 8, 9, 10, 11 and 90 more`."""
    if len(lines) == 1:
        return tr("line {number}", number=lines[0])
    head = ", ".join(str(n) for n in (lines[:-1] if len(lines) <= limit else lines[:limit]))
    if len(lines) <= limit:
        return tr("lines {numbers} and {last}", numbers=head, last=lines[-1])
    return tr("lines {numbers} and {count} more", numbers=head, count=len(lines) - limit)


def read_table(path: str | Path, *, named: bool = False, most: int = MOST_LINES) -> TextTable:
    """Read a text table of any of the usual kinds; named, and the most lines, as in `read_rows`.

    Raises `InputError` (file, line) for what is missing, empty, not text, or not a table.
    """
    path = Path(path)
    text = read_rows(path, named=named, most=most)
    return TextTable(
        path=path,
        names=None if text.header is None else tuple(text.header),
        header_line=text.header_line,
        width=text.width,
        delimiter=text.delimiter,
        comments=tuple(text.comments),
        notes=tuple(text.notes),
        separators=tuple(text.separators),
        line_numbers=np.asarray(text.numbers, dtype=np.int64),
        _text=text,
        commented=tuple(text.commented),
    )


def table_of_cells(
    names: Sequence[str] | None,
    rows: Sequence[Sequence[str]],
    called: str,
    comments: Sequence[str] = (),
) -> TextTable:
    """A table that is in memory already; its lines are its rows, counted from 1. names : of the
    columns, None for none. called : what errors call it. comments : as in a file"""
    width = len(names) if names is not None else len(rows[0]) if rows else 0
    cells = [list(row) for row in rows]
    header, numbers = None if names is None else list(names), list(range(1, len(cells) + 1))
    text = TextRows(header, None, width, ",", [], cells, numbers, [], [], [])
    return TextTable(
        path=Path(called),
        names=None if header is None else tuple(header),
        header_line=None,
        width=width,
        delimiter=",",
        comments=tuple(comments),
        notes=(),
        separators=(),
        line_numbers=np.asarray(numbers, dtype=np.int64),
        _text=text,
    )


def read_points(path: str | Path, by: str | None = None) -> PointGroups:
    """Read x, y, z, and which feature each point belongs to, from a text table.

    path: the table; with a header the columns x, y, z (also easting, northing, elevation) are
    taken, without one the first three.
    by: header or 1-based number of the column that names the feature; `segment` stands for the
    parts between `---` lines; None makes one feature `1`.
    Raises `InputError` or `UsageError`.
    """
    table = read_table(path)
    columns = coordinate_columns(table)
    if not len(table):
        raise InputError(Finding("table.no-rows"), file=table.path, line=table.header_line)
    points = table.numbers(columns)
    _refuse_no_places(table, columns, points)
    keep: BoolArray = np.asarray(np.isfinite(points).all(axis=1))
    dropped = tuple(int(n) for n in table.line_numbers[~keep])
    warnings = list(table.notes)
    if dropped:
        warnings.append(
            Finding(
                "table.rows-left-out", count=len(dropped), needed=tr("coordinates"), lines=dropped
            )
        )
    if not keep.any():
        raise InputError(
            Finding("table.no-valid-rows", count=len(table), needed=tr("coordinates")),
            file=table.path,
            line=int(table.line_numbers[0]),
            field=", ".join(table.label(c) for c in columns),
        )
    if by is None:
        warnings += _signs_of_groups(table, columns)
        groups = ["1"] * len(table)
    elif by == "segment" and table.separators and not table.has(by):
        groups = _segments(table)
    else:
        groups = table.labels(table.find(by))
        nameless = [i for i, name in enumerate(groups) if not name and keep[i]]
        if nameless:
            keep[nameless] = False
            where = [int(n) for n in table.line_numbers[nameless]]
            warnings.append(
                Finding("table.rows-left-out", count=len(where), needed=f"'{by}'", lines=where)
            )
            if not keep.any():
                raise InputError(
                    Finding("table.no-valid-rows", count=len(table), needed=f"'{by}'"),
                    file=table.path,
                    field=by,
                )
    words, said = _words_beside(table, groups, keep, by)
    named = groups if all(groups) else [g for g, k in zip(groups, keep, strict=True) if k or g]
    codes = {name: i for i, name in enumerate(dict.fromkeys(named))}
    kept = np.fromiter(map(codes.__getitem__, itertools.compress(groups, keep)), np.int64)
    counts = np.bincount(kept, minlength=len(codes))
    return PointGroups(
        ids=tuple(codes),
        points=np.ascontiguousarray(points[keep][np.argsort(kept, kind="stable")]),
        offsets=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        dropped=dropped,
        words=words,
        warnings=(*warnings, *said),
        comments=table.comments,
    )


def _words_beside(
    table: TextTable, groups: list[str], keep: BoolArray, by: str | None
) -> tuple[Words[str], list[Finding]]:
    told = [c for c in COLUMNS if by not in (None, c) and table.has(c)]
    return words_of_groups({c: table.cells(table.find(c)) for c in told}, groups, keep.tolist())


COORDINATES: dict[str, set[str]] = {
    "x": {"easting", "east", "e", "xcoord", "xcoordinate", "coordx", "pointx", "utme", "utmx"},
    "y": {"northing", "north", "n", "ycoord", "ycoordinate", "coordy", "pointy", "utmn", "utmy"},
    "z": {"elevation", "elev", "height", "altitude", "alt", "up", "u", "h"}
    | {"zcoord", "zcoordinate", "coordz", "pointz"},
}
_GROUPS = frozenset(
    {"trace", "traceid", "tracename", "group", "groupid", "plane", "planeid", "feature"}
    | {"featureid", "object", "objectid", "fid", "id", "name", "label", "set", "bed", "bedding"}
    | {"surface", "segment", "polyline", "line", "lineid", "patch", "facet", "fracture", "fault"}
    | {"part", "cluster", "class"}
)


def coordinate_columns(table: TextTable) -> list[int]:
    """Which columns are x, y and z. Raises `InputError` where they cannot be told."""
    if table.names is None:
        if table.width < 3:
            raise InputError(
                Finding("table.column-count", count=table.width, columns=("x", "y", "z")),
                file=table.path,
                line=int(table.line_numbers[0]),
            )
        return [0, 1, 2]
    found: list[int] = []
    known = [plain(name) for name in table.names]
    for letter, aliases in COORDINATES.items():
        matches = [i for i, name in enumerate(known) if name == letter]
        matches = matches or [i for i, name in enumerate(known) if name in aliases]
        if len(matches) > 1:
            raise InputError(
                Finding(
                    "table.repeated-column",
                    column=letter,
                    columns=[table.names[i] for i in matches],
                ),
                file=table.path,
                line=table.header_line,
                field=letter,
            )
        if not matches:
            raise table.header_error(
                Finding(
                    "table.missing-column", column=letter, columns=table.names, names=(letter,)
                ),
                letter,
            )
        found.append(matches[0])
    return found


def _refuse_no_places(table: TextTable, columns: list[int], points: FloatArray) -> None:
    """Coordinates whose squares would overflow, and that are no metres on any planet."""
    far = np.isfinite(points) & (np.abs(points) > FARTHEST_M)
    if far.any():
        row, place = np.argwhere(far)[0]
        raise InputError(
            Finding("coordinate.out-of-range", value=points[row, place]),
            file=table.path,
            line=int(table.line_numbers[row]),
            field=table.label(columns[place]),
        )


def _segments(table: TextTable) -> list[str]:
    """Rows numbered by the rules between them, from 1; rules before the first row don't count."""
    place = np.searchsorted(np.asarray(table.separators), table.line_numbers)
    _, number = np.unique(place, return_inverse=True)
    return [str(n + 1) for n in number]


def _signs_of_groups(table: TextTable, taken: list[int]) -> list[Finding]:
    """Warnings where the table looks as if it held more than one feature."""
    warnings = []
    if table.separators and len(parts := set(_segments(table))) > 1:
        warnings.append(Finding("table.segments", count=len(parts)))
    for column in range(table.width):
        named = table.names is not None and plain(table.names[column]) in _GROUPS
        # A million rows of colours are told from labels by their beginning.
        if column in taken or not (named or _runs(table.cells(column, 1000))):
            continue
        cells = table.cells(column)
        values = Counter(cells)
        values.pop("", None)
        if not 2 <= len(values) <= len(cells) / 2:
            continue
        if named or (_runs(cells) and min(values.values()) > 1):
            how = table.names[column] if table.names else str(column + 1)
            warnings.append(
                Finding("table.groups", column=table.label(column), count=len(values), by=how)
            )
    return warnings


def _runs(cells: list[str]) -> bool:
    """Whether equal cells stand together: labels do, measurements hardly ever."""
    return 1 + sum(a != b for a, b in itertools.pairwise(cells)) == len(set(cells)) < len(cells)
