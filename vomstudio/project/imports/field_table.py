"""Cells of a table of readings as they are written in a text file."""

from __future__ import annotations

import csv
import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.spreadsheet_cells import unescape_formula
from vomstudio.core.findings import Finding
from vomstudio.geology.notation import parse_line, parse_plane
from vomstudio.io.gate.orientation_files import is_layer_file, read_any_table
from vomstudio.io.text.file_text import MAX_OBJECTS, read_text
from vomstudio.io.text.rows import (
    DELIMITER_NAMES,
    detect_delimiter,
    is_blank,
    is_header,
    parse_number,
    rejoin_header,
    split_cells,
)

MAX_CELL_LINES = 50
"""Maximum number of lines of a quoted cell."""


@dataclass(frozen=True, eq=False)
class FieldTable:
    """Cells of a text file.

    `ragged_row_findings` contains the findings for rows with too many or too few cells, by row
    index; `comments` are stored without their comment mark.
    """

    path: Path
    names: tuple[str, ...] | None
    width: int
    delimiter: str
    rows: list[list[str]]
    lines: list[int]
    ragged_row_findings: Mapping[int, Finding]
    notes: tuple[Finding, ...]
    comments: tuple[str, ...] = ()

    def label(self, column: int) -> str:
        return self.names[column] if self.names else f"column {column + 1}"


def read_field_table(path: str | Path) -> FieldTable:
    """Read the cells of a table of readings; rows with a wrong number of cells are flagged.

    Point layers of GIS files and sheets of workbooks are read like text tables. Raises InputError
    if the file is missing or has no rows, and UsageError if several layers contain orientations.
    """
    path = Path(path)
    if is_layer_file(path):
        return _read_layer_table(path)
    text, notes = read_text(path, MAX_OBJECTS)
    lines = [line.rstrip("\r") for line in text.split("\n")]
    records = [
        (i, line)
        for i, line in _join_quoted_lines(lines)
        if not is_blank(line.strip()) and not line.lstrip().startswith("#")
    ]
    comments = tuple(
        line.strip().lstrip("#").strip() for line in lines if line.lstrip().startswith("#")
    )
    if not records:
        raise InputError(Finding("table.no-rows"), file=path)
    delimiter = detect_delimiter([line for _, line in records[:200]])
    if all(is_orientation(line) for _, line in records[1:20]) and len(records) > 1:
        rows = [[line.strip()] for _, line in records]  # each line is one reading: N42E 41SE
    else:
        rows = [_split_cells(line, delimiter) for _, line in records]
    line_numbers = [i for i, _ in records]
    has_header = is_header(rows[0], delimiter) and not any(is_orientation(cell) for cell in rows[0])
    first_row = rows[0]
    if has_header:
        rows, line_numbers = rows[1:], line_numbers[1:]
        if delimiter == " " and rows:
            first_row = rejoin_header(first_row, [], rows)
    names = tuple(first_row) if has_header else None
    if not rows:
        raise InputError(Finding("table.no-rows"), file=path)
    width = len(names) if names else Counter(map(len, rows)).most_common(1)[0][0]
    ragged_rows = {}
    for i, row in enumerate(rows):
        while len(row) > width and not row[-1]:
            row.pop()
        if len(row) != width:
            ragged_rows[i] = Finding(
                "table.ragged-row",
                count=len(row),
                expected=width,
                delimiter=DELIMITER_NAMES[delimiter],
            )
            row[:] = (row + [""] * width)[:width]
    return FieldTable(
        path, names, width, delimiter, rows, line_numbers, ragged_rows, tuple(notes), comments
    )


def _read_layer_table(path: Path) -> FieldTable:
    table = read_any_table(path)
    return FieldTable(
        path,
        table.names,
        table.width,
        table.delimiter,
        [list(row) for row in table.rows],
        table.line_numbers.tolist(),
        {},
        table.notes,
        table.comments,
    )


def _join_quoted_lines(lines: list[str]) -> list[tuple[int, str]]:
    """Join the lines of quoted cells, and return records with the number of their first line.

    A quote that is not closed within `MAX_CELL_LINES` belongs to a single line.
    """
    records: list[tuple[int, str]] = []
    i = 0
    while i < len(lines):
        end, quotes = i + 1, lines[i].count('"')
        if quotes % 2 and not lines[i].lstrip().startswith("#"):
            while quotes % 2 and end < min(len(lines), i + MAX_CELL_LINES):
                quotes += lines[end].count('"')
                end += 1
            end = end if quotes % 2 == 0 else i + 1
        records.append((i + 1, "\n".join(lines[i:end])))
        i = end
    return records


def _split_cells(line: str, delimiter: str) -> list[str]:
    if '"' not in line:
        return [unescape_formula(cell) for cell in split_cells(line, delimiter)]
    try:
        cells = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))
    except csv.Error:
        # The cell has more than 131,072 characters.
        cells = split_cells(line, delimiter)
    return [unescape_formula(cell.strip()) for cell in cells]


def is_orientation(text: str) -> bool:
    """Return whether a text contains both angles; two plain numbers do not count."""
    if not any(character in text for character in "/°") and not any(
        character in "NSEWnsew" for character in text
    ):
        return False
    for parse in (parse_plane, parse_line):
        try:
            parse(text)
        except InputError:
            continue
        return True
    return False


def parse_cell(cell: str, table: FieldTable) -> float | None:
    """Return the number in a cell, or None if it is not a finite number."""
    if not cell:
        return None
    value = parse_number(cell.rstrip("°"), decimal_comma=table.delimiter in ";\t")
    return value if value is not None and math.isfinite(value) else None
