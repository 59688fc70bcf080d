"""Tables of numbers and words in text files.

The rules are those of the command line: the delimiter (a comma, semicolon, tab or spaces) is
detected; lines with `#` are comments; the first row is a header if it contains a word or only
missing values; decimal commas are accepted if the delimiter is `;` or a tab. Every error states the
file, the line number as in an editor, and the column.

Long tables of plain numbers (a million points) are read by numpy. Only if that fails are the cells
parsed individually in order to locate the error.
"""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from operator import itemgetter
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.coordinate_limits import MAX_COORDINATE_M
from vomstudio.io.text.column_names import doubtful_cell, normalise_name
from vomstudio.io.text.file_text import MAX_LINES
from vomstudio.io.text.group_columns import GROUP_COLUMNS, Words, group_words
from vomstudio.io.text.rows import (
    TextRows,
    is_comma_number,
    parse_number,
    read_rows,
    shorten,
    split_cells,
)

TABLE_EXTENSIONS = (".csv", ".txt", ".tsv", ".dat")
"""Usual extensions of text tables, for file dialogs."""

_SCIENTIFIC_NUMBER = re.compile(r"[+-]?\d\.\d+[eE][+-]\d{2,3}")


_BLOCK_ROWS = 50_000
_MAX_LABEL_BYTES = 64
"""Maximum length of labels that are compared character by character."""


def _plain_label(cell: str) -> str:
    return f"{float(cell):.15g}" if _SCIENTIFIC_NUMBER.fullmatch(cell) else cell


@dataclass(frozen=True, eq=False)
class TextTable:
    """Rows of a text file. Columns are numbered from 0 here, but from 1 for users."""

    path: Path
    names: tuple[str, ...] | None
    """Cells of the header, or None for a table without a header."""
    header_line: int | None
    width: int
    delimiter: str
    """`,`, `;`, a tab, or a space that stands for any number of spaces."""
    comments: tuple[str, ...]
    notes: tuple[Finding, ...]
    """Findings about the file."""
    separators: tuple[int, ...]  # lines of separators such as `---`
    line_numbers: IntArray
    """Number (from 1) of the first line of each row (n,) in the file."""
    _text: TextRows = field(repr=False)
    repeats: int = 0  # number of excluded rows that repeat others
    commented_lines: tuple[int, ...] = ()  # lines that look like rows

    def __len__(self) -> int:
        return len(self.line_numbers)

    def label(self, column: int) -> str:
        """Return the name of a column for messages: its header, or for example `column 3`."""
        return self.names[column] if self.names else f"column {column + 1}"

    def header_error(
        self, finding: Finding, field: str | None, kind: type[InputError] = InputError
    ) -> InputError:
        """Return the error that a column is missing or that the header may be a row of data."""
        cell = doubtful_cell(self.names or (), self.header_line, self.delimiter)
        if cell is not None:
            finding = Finding(
                "table.doubtful-header", column=field, header_line=self.header_line, cell=cell
            )
        return kind(finding, file=self.path, line=self.header_line, field=field)

    @cached_property
    def rows(self) -> list[list[str]]:
        """All cells, stripped; `width` per row."""
        if self._text.rows is not None:
            return self._text.rows
        return [split_cells(line, self.delimiter) for line in self._text.lines]

    def cells(self, column: int, max_rows: int | None = None) -> list[str]:
        """Return the text (n,) of a column, or of its first `max_rows` rows."""
        if self._text.rows is not None:
            return [row[column] for row in self._text.rows[:max_rows]]
        delimiter = None if self.delimiter == " " else self.delimiter
        lines = self._text.lines[:max_rows]
        # Functions in C: a comprehension takes half as long again for millions of rows.
        parts = map(str.split, lines, itertools.repeat(delimiter), itertools.repeat(column + 1))
        return list(map(str.strip, map(itemgetter(column), parts)))

    def labels(self, column: int) -> list[str]:
        """Return the labels (n,) in a column.

        Some programs write whole tables in scientific notation, so 1.000000e+00 becomes 1.
        """
        cells = self.cells(column)
        labels = {cell: _plain_label(cell) for cell in set(cells)}
        return [labels[cell] for cell in cells]

    def label_codes(self, column: int) -> tuple[list[str], IntArray]:
        """Return the distinct labels of a column in order of appearance, and their rows.

        Returns
        -------
        labels : list of str
            As returned by `labels`.
        codes : (n,) int64
            Index of the label of each row.
        """
        starts = self._run_starts(column)
        if len(starts) < len(self):
            lines = self._text.lines
            cells = [split_cells(lines[row], self.delimiter)[column] for row in starts.tolist()]
        else:
            cells = self.cells(column)
        codes_by_label: dict[str, int] = {}
        codes_by_cell = {
            cell: codes_by_label.setdefault(_plain_label(cell), len(codes_by_label))
            for cell in dict.fromkeys(cells)
        }
        codes = np.fromiter(map(codes_by_cell.__getitem__, cells), np.int64, len(cells))
        return list(codes_by_label), np.repeat(codes, np.diff(np.append(starts, len(self))))

    def _run_starts(self, column: int) -> IntArray:
        """Return the first rows of runs of rows with the same text in a column.

        Rows of the same feature are usually adjacent, so that few cells become objects.
        """
        lines = self._text.lines
        if self._text.rows is not None or self.delimiter == " ":
            return np.arange(len(self))
        blocks = [np.zeros(0, np.int64)]
        for first_row in range(0, len(lines), _BLOCK_ROWS):
            block = lines[first_row : first_row + _BLOCK_ROWS]
            text = np.frombuffer("\n".join([*block, ""]).encode(), np.uint8)
            is_end = (text == ord(self.delimiter)) | (text == ord("\n"))
            ends = np.flatnonzero(is_end).reshape(len(block), self.width)
            previous_ends = ends[:, column - 1] if column else np.append(-1, ends[:-1, -1])
            lengths = ends[:, column] - previous_ends - 1
            is_new = np.append(True, lengths[1:] != lengths[:-1])
            if lengths.max() > _MAX_LABEL_BYTES:
                is_new[:] = True
                lengths[:] = 0
            for i in range(int(lengths.max())):
                characters = text[np.minimum(previous_ends + 1 + i, len(text) - 1)]
                is_new[1:] |= (characters[1:] != characters[:-1]) & (lengths[1:] > i)
            blocks.append(first_row + np.flatnonzero(is_new))
        return np.concatenate(blocks)

    def numbers(self, columns: Sequence[int]) -> FloatArray:
        """Return the numbers in columns.

        Parameters
        ----------
        columns : sequence of int

        Returns
        -------
        (n, len(columns)) float64
            Numbers; NaN for an empty cell.

        Raises
        ------
        InputError
            If a cell contains a word.
        """
        parsed_numbers = self._fast_numbers(columns)
        if parsed_numbers is not None:
            return parsed_numbers
        result = np.empty((len(self), len(columns)))
        for position, column in enumerate(columns):
            result[:, position] = self._parse_numbers(column)
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

    def _parse_numbers(self, column: int) -> list[float]:
        values: list[float] = []
        allows_comma = self.delimiter in ";\t"
        first_rows: dict[str, int] = {}
        for i, cell in enumerate(self.cells(column)):
            value = parse_number(cell, decimal_comma=allows_comma)
            if value is None:
                raise self._number_error(i, column, cell)
            values.append(value)
            for mark in ",.":
                if mark in cell:
                    first_rows.setdefault(mark, i)
        if len(first_rows) == 2:
            raise InputError(
                Finding("table.mixed-decimals"),
                file=self.path,
                line=int(self.line_numbers[max(first_rows.values())]),
                field=self.label(column),
            )
        return values

    def _number_error(self, row: int, column: int, cell: str) -> InputError:
        code = "table.decimal-comma" if is_comma_number(cell) else "table.not-a-number"
        return InputError(
            Finding(code, cell=shorten(cell)),
            file=self.path,
            line=int(self.line_numbers[row]),
            field=self.label(column),
        )

    def find(self, key: str) -> int:
        """Return the 0-based number of a column from its name or its 1-based number.

        Names are compared without case and separators. Raises `UsageError` unless exactly one
        column matches.
        """
        key = key.strip()
        if self.names:
            exact_matches = [i for i, name in enumerate(self.names) if name == key]
            normalised_matches = [
                i
                for i, name in enumerate(self.names)
                if normalise_name(name) == normalise_name(key)
            ]
            matches = exact_matches or normalised_matches
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
        """Return whether the header contains a name, ignoring case and separators."""
        return self.names is not None and normalise_name(name) in map(normalise_name, self.names)


@dataclass(frozen=True, eq=False)
class PointGroups:
    """Points of one or more features, grouped by feature.

    Group i is `points[offsets[i]:offsets[i + 1]]`. The groups and their points are in the order of
    the file.
    """

    ids: tuple[str, ...]
    points: FloatArray
    """x, y, z as in the file, (n, 3) float64."""
    offsets: IntArray
    """Start of each group, and the end of the last one, (len(ids) + 1,)."""
    dropped: tuple[int, ...]
    """Lines that have no finite coordinates."""
    warnings: tuple[Finding, ...]
    words: Words[str] = field(default_factory=dict)
    """Kinds and sets of the groups."""
    comments: tuple[str, ...] = ()
    """Comments of the table, which may state its CRS."""


def line_numbers_text(lines: Sequence[int], limit: int = 8) -> str:
    """Return `line 4`, `lines 4, 7 and 9`, or a longer list with the number of further lines."""
    if len(lines) == 1:
        return tr("line {number}", number=lines[0])
    heading = ", ".join(str(n) for n in (lines[:-1] if len(lines) <= limit else lines[:limit]))
    if len(lines) <= limit:
        return tr("lines {numbers} and {last}", numbers=heading, last=lines[-1])
    return tr("lines {numbers} and {count} more", numbers=heading, count=len(lines) - limit)


def read_table(
    path: str | Path, *, has_header: bool = False, max_lines: int = MAX_LINES
) -> TextTable:
    """Read a text table.

    Parameters
    ----------
    path : str or Path
    has_header, max_lines
        As for `read_rows`.

    Raises
    ------
    InputError
        If the file is missing, empty, not text, or not a table; states file and line.
    """
    path = Path(path)
    text_rows = read_rows(path, has_header=has_header, max_lines=max_lines)
    return TextTable(
        path=path,
        names=None if text_rows.header is None else tuple(text_rows.header),
        header_line=text_rows.header_line,
        width=text_rows.width,
        delimiter=text_rows.delimiter,
        comments=tuple(text_rows.comments),
        notes=tuple(text_rows.notes),
        separators=tuple(text_rows.separators),
        line_numbers=np.asarray(text_rows.line_numbers, dtype=np.int64),
        _text=text_rows,
        commented_lines=tuple(text_rows.commented_lines),
    )


def table_from_cells(
    names: Sequence[str] | None,
    rows: Sequence[Sequence[str]],
    title: str,
    comments: Sequence[str] = (),
    notes: Sequence[Finding] = (),
    numbers: Sequence[int] | None = None,
) -> TextTable:
    """Create a table from cells in memory.

    Parameters
    ----------
    names : sequence of str or None
        Column names.
    rows : sequence of sequence of str
    title : str
        Name of the table for error messages.
    comments : sequence of str
        Comments as in a file.
    notes : sequence of Finding
        Findings about the table.
    numbers : sequence of int, optional
        Number of each row; by default they are counted from 1.
    """
    width = len(names) if names is not None else len(rows[0]) if rows else 0
    cells = [list(row) for row in rows]
    header = None if names is None else list(names)
    row_numbers = list(range(1, len(cells) + 1) if numbers is None else numbers)
    text_rows = TextRows(header, None, width, ",", [], cells, row_numbers, [], [], [])
    return TextTable(
        path=Path(title),
        names=None if header is None else tuple(header),
        header_line=None,
        width=width,
        delimiter=",",
        comments=tuple(comments),
        notes=tuple(notes),
        separators=(),
        line_numbers=np.asarray(row_numbers, dtype=np.int64),
        _text=text_rows,
    )


def read_points(path: str | Path, by: str | None = None) -> PointGroups:
    """Read x, y, z and the feature of each point from a text table.

    Parameters
    ----------
    path : str or Path
        Table file. If it has a header, the columns x, y, z (or easting, northing, elevation) are
        used, otherwise the first three columns.
    by : str, optional
        Name or 1-based number of the column with the features, or `segment` for parts between `---`
        lines. If None, all points belong to a single feature `1`.

    Raises
    ------
    InputError
        If the table is not valid or contains no points.
    UsageError
        If the column `by` does not exist or is ambiguous.
    """
    table = read_table(path)
    columns = coordinate_columns(table)
    if not len(table):
        raise InputError(Finding("table.no-rows"), file=table.path, line=table.header_line)
    points = table.numbers(columns)
    _refuse_large_coordinates(table, columns, points)
    is_finite_row: BoolArray = np.asarray(np.isfinite(points).all(axis=1))
    dropped_lines = tuple(int(n) for n in table.line_numbers[~is_finite_row])
    warnings = list(table.notes)
    if dropped_lines:
        warnings.append(
            Finding(
                "table.rows-left-out",
                count=len(dropped_lines),
                needed=tr("coordinates"),
                lines=dropped_lines,
            )
        )
    if not is_finite_row.any():
        raise InputError(
            Finding("table.no-valid-rows", count=len(table), needed=tr("coordinates")),
            file=table.path,
            line=int(table.line_numbers[0]),
            field=", ".join(table.label(column) for column in columns),
        )
    codes: IntArray = np.zeros(len(table), np.int64)
    if by is None:
        warnings += _detect_groups(table, columns)
        names = ["1"]
    elif by == "segment" and table.separators and not table.has(by):
        codes = _segments(table)
        names = [str(number + 1) for number in range(int(codes.max()) + 1)]
    else:
        names, codes = table.label_codes(table.find(by))
        has_name = np.array([bool(name) for name in names])[codes]
        unnamed_rows = np.flatnonzero(is_finite_row & ~has_name)
        if len(unnamed_rows):
            is_finite_row &= has_name
            lines = [int(n) for n in table.line_numbers[unnamed_rows]]
            warnings.append(
                Finding("table.rows-left-out", count=len(lines), needed=f"'{by}'", lines=lines)
            )
            if not is_finite_row.any():
                raise InputError(
                    Finding("table.no-valid-rows", count=len(table), needed=f"'{by}'"),
                    file=table.path,
                    field=by,
                )
    words, word_findings = _group_words(table, names, codes, is_finite_row, by)
    if "" in names:
        # Rows without a name are left out.
        unnamed_code = names.index("")
        names.remove("")
        codes -= codes > unnamed_code
    point_codes = codes[is_finite_row]
    counts = np.bincount(point_codes, minlength=len(names))
    return PointGroups(
        ids=tuple(names),
        points=np.ascontiguousarray(points[is_finite_row][np.argsort(point_codes, kind="stable")]),
        offsets=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        dropped=dropped_lines,
        words=words,
        warnings=(*warnings, *word_findings),
        comments=table.comments,
    )


def _group_words(
    table: TextTable,
    names: list[str],
    codes: IntArray,
    is_finite_row: BoolArray,
    group_column: str | None,
) -> tuple[Words[str], list[Finding]]:
    columns = [
        column
        for column in GROUP_COLUMNS
        if group_column not in (None, column) and table.has(column)
    ]
    if not columns:
        return {}, []
    return group_words(
        {column: table.cells(table.find(column)) for column in columns},
        [names[code] for code in codes.tolist()],
        is_finite_row.tolist(),
    )


COORDINATES: dict[str, set[str]] = {
    "x": {"easting", "east", "e", "xcoord", "xcoordinate", "coordx", "pointx", "utme", "utmx"},
    "y": {"northing", "north", "n", "ycoord", "ycoordinate", "coordy", "pointy", "utmn", "utmy"},
    "z": {"elevation", "elev", "height", "altitude", "alt", "up", "u", "h"}
    | {"zcoord", "zcoordinate", "coordz", "pointz"},
}
_GROUP_NAMES = frozenset(
    {"trace", "traceid", "tracename", "group", "groupid", "plane", "planeid", "feature"}
    | {"featureid", "object", "objectid", "fid", "id", "name", "label", "set", "bed", "bedding"}
    | {"surface", "segment", "polyline", "line", "lineid", "patch", "facet", "fracture", "fault"}
    | {"part", "cluster", "class"}
)


def coordinate_columns(table: TextTable) -> list[int]:
    """Return the numbers of the columns x, y and z. Raises `InputError`."""
    if table.names is None:
        if table.width < 3:
            raise InputError(
                Finding("table.column-count", count=table.width, columns=("x", "y", "z")),
                file=table.path,
                line=int(table.line_numbers[0]),
            )
        return [0, 1, 2]
    columns: list[int] = []
    normalised_names = [normalise_name(name) for name in table.names]
    for letter, aliases in COORDINATES.items():
        matches = [i for i, name in enumerate(normalised_names) if name == letter]
        matches = matches or [i for i, name in enumerate(normalised_names) if name in aliases]
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
        columns.append(matches[0])
    return columns


def _refuse_large_coordinates(table: TextTable, columns: list[int], points: FloatArray) -> None:
    """Raise InputError if coordinates are too large for metres and their squares may overflow."""
    is_too_large = np.isfinite(points) & (np.abs(points) > MAX_COORDINATE_M)
    if is_too_large.any():
        row, column = np.argwhere(is_too_large)[0]
        raise InputError(
            Finding("coordinate.out-of-range", value=points[row, column]),
            file=table.path,
            line=int(table.line_numbers[row]),
            field=table.label(columns[column]),
        )


def _segments(table: TextTable) -> IntArray:
    """Return the segment (n,) of each row, from 0, according to the separators."""
    segment = np.searchsorted(np.asarray(table.separators), table.line_numbers)
    return np.unique(segment, return_inverse=True)[1].astype(np.int64)


def _detect_groups(table: TextTable, excluded_columns: list[int]) -> list[Finding]:
    """Return findings if the table seems to contain more than one feature."""
    warnings = []
    if table.separators and (count := int(_segments(table).max()) + 1) > 1:
        warnings.append(Finding("table.segments", count=count))
    for column in range(table.width):
        has_group_name = (
            table.names is not None and normalise_name(table.names[column]) in _GROUP_NAMES
        )
        # The first rows are sufficient to distinguish labels from a million colours.
        if column in excluded_columns or not (
            has_group_name or _is_grouped(table.cells(column, 1000))
        ):
            continue
        cells = table.cells(column)
        values = Counter(cells)
        values.pop("", None)
        if not 2 <= len(values) <= len(cells) / 2:
            continue
        if has_group_name or (_is_grouped(cells) and min(values.values()) > 1):
            key = table.names[column] if table.names else str(column + 1)
            warnings.append(
                Finding("table.groups", column=table.label(column), count=len(values), by=key)
            )
    return warnings


def _is_grouped(cells: list[str]) -> bool:
    """Return whether equal cells are adjacent, as is usual for labels but not measurements."""
    return (
        1 + sum(cell != next_cell for cell, next_cell in itertools.pairwise(cells))
        == len(set(cells))
        < len(cells)
    )
