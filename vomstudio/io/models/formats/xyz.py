"""Points as text: XYZ, CSV and similar, with columns identified by name or value."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.file_kinds import require_text
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coordinate_limits import MAX_COORDINATE_M
from vomstudio.io.gate.stated_crs import parse_crs_comments
from vomstudio.io.models.formats._common import (
    BLOCK_ROWS,
    Columns,
    drop_invalid_points,
    read_whole_file,
    to_uint8_colors,
)
from vomstudio.io.models.formats._row_widths import has_equal_widths
from vomstudio.io.models.reader import LoadedModel, Reader
from vomstudio.io.text.column_names import normalise_name
from vomstudio.io.text.encodings import convert_to_utf8
from vomstudio.io.text.file_text import MAX_FILE_BYTES
from vomstudio.io.text.rows import (
    MAX_LINE_LENGTH,
    TextRows,
    detect_delimiter,
    is_blank,
    is_comma_number,
    is_header,
    parse_number,
    refuse_decimal_commas,
    split_cells,
)
from vomstudio.io.text.tables import TextTable, coordinate_columns, read_points

HEAD_BYTES = 1 << 18
SAMPLE_ROWS = 200
FEW_BYTES = 1 << 16
COLOR_NAMES = (
    ("r", "g", "b"),
    ("red", "green", "blue"),
    ("diffusered", "diffusegreen", "diffuseblue"),
)
NORMAL_NAMES = (
    ("nx", "ny", "nz"),
    ("normalx", "normaly", "normalz"),
    ("xnormal", "ynormal", "znormal"),
)


@dataclass(frozen=True)
class Layout:
    """Layout of the rows, determined from a sample; the whole file must conform to it.

    `n_skipped_lines` is the number of lines before the first row of numbers; `comments` contains
    the comment lines before it, without their comment mark.
    """

    delimiter: str
    decimal: str
    header: list[str] | None
    header_line: int
    n_skipped_lines: int
    width: int
    sample: list[list[str]]
    comments: list[str] = field(default_factory=list)


@dataclass
class ColumnUses:
    """Column numbers, from 0, by the use of the columns."""

    xyz: list[int]
    rgb: list[int] = field(default_factory=list)
    normals: list[int] = field(default_factory=list)
    other_fields: dict[int, str] = field(default_factory=dict)


def matches(path: Path, head: bytes) -> bool:
    """Return False: text has no signature, so the extension decides."""
    return False


def read(path: Path, progress: Progress) -> LoadedModel:
    """Read the points of a text table by the rules of `vomstudio.io.text.tables`.

    Colours (0..1, 0..255 or 16 bits), normals and scalar fields are read. Rows without finite
    coordinates are dropped and counted. Raises InputError with the line if a coordinate is a word
    or a row has a different number of cells.
    """
    data = read_whole_file(path, progress).tobytes()
    if len(data) > MAX_FILE_BYTES:
        raise InputError(Finding("table.too-large", size_gib=len(data) / 2**30), file=path)
    data = convert_to_utf8(data)
    if b"\r" in data and b"\n" not in data:
        data = data.replace(b"\r", b"\n")
    require_text(path, data)
    findings: list[Finding] = []
    layout = _layout(data[:HEAD_BYTES], len(data) > HEAD_BYTES, path)
    columns = _columns(layout, path, findings)
    table = _numbers(data, layout, path, progress)
    _refuse_ragged_rows(table, data, layout, path)
    del data
    cloud = _cloud(table, columns, layout, path, findings)
    cloud = drop_invalid_points(cloud, findings, path)
    return LoadedModel(
        cloud, "cloud", parse_crs_comments(layout.comments).text, tuple(findings), path
    )


def _layout(head: bytes, is_truncated: bool, path: Path) -> Layout:
    lines = head.decode("utf-8-sig", "replace").replace("\r\n", "\n").split("\n")
    if is_truncated and len(lines) > 1:
        lines = lines[:-1]
    if max(map(len, lines)) > min(MAX_LINE_LENGTH, HEAD_BYTES - 1):
        raise InputError(Finding("table.long-line", count=max(map(len, lines))), file=path)
    rows = [(n, line) for n, line in enumerate(lines) if not is_blank(line) and line[:1] != "#"]
    if not rows:
        raise InputError(Finding("table.no-rows"), file=path)
    if len(rows) > 2 and re.fullmatch(r"\s*\d+\s*", rows[0][1]) and len(rows[1][1].split()) > 1:
        rows = rows[1:]  # the number of points, as .pts files begin
    sample = [line.replace('"', "") for _, line in rows[:SAMPLE_ROWS]]
    delimiter = detect_delimiter(sample)
    positions = [n + 1 for n, _ in rows[:SAMPLE_ROWS]]
    refuse_decimal_commas(path, sample, positions, delimiter)
    first_cells = split_cells(sample[0], delimiter)
    header: list[str] | None = None
    offset, header_line = 0, 0
    if is_header(first_cells, delimiter):
        header = [name.lstrip("/").strip() for name in first_cells]
        header = [name for name in header if name] if delimiter == " " else header
        offset, header_line = 1, rows[0][0] + 1
        if len(rows) == 1:
            raise InputError(Finding("table.no-rows"), file=path, line=header_line)
    cells = [split_cells(line, delimiter) for line in sample[offset:]]
    width = len(cells[0])
    if header is None:
        header, header_line = _commented_header(lines[: rows[0][0]], width, delimiter)
    has_decimal_comma = delimiter in ";\t" and any(
        is_comma_number(cell) for row in cells for cell in row
    )
    return Layout(
        delimiter,
        "," if has_decimal_comma else ".",
        header,
        header_line,
        rows[offset][0],
        max(width, len(header or ())),
        cells,
        [line[1:].strip() for line in lines[: rows[offset][0]] if line[:1] == "#"],
    )


def _commented_header(lines: list[str], width: int, delimiter: str) -> tuple[list[str] | None, int]:
    """Return the names in the last comment before the points and its line, or (None, 0).

    Many programs write such a header. The comment must begin with x, y and z and contain one name
    for each column.
    """
    for line_number in range(len(lines), 0, -1):
        text = lines[line_number - 1].strip()
        if not text.startswith("#"):
            continue
        names = split_cells(text.lstrip("#/ "), delimiter)
        if len(names) == width and [normalise_name(name) for name in names[:3]] == ["x", "y", "z"]:
            return names, line_number
        return None, 0
    return None, 0


def _columns(layout: Layout, path: Path, findings: list[Finding]) -> ColumnUses:
    if layout.header is None:
        return _columns_by_value(layout, path, findings)
    text = TextRows(
        layout.header, layout.header_line, layout.width, layout.delimiter, [], None, [], [], [], []
    )
    table = TextTable(
        path,
        tuple(layout.header),
        layout.header_line,
        layout.width,
        layout.delimiter,
        (),
        (),
        (),
        np.zeros(0, np.int64),
        text,
    )
    columns = ColumnUses(coordinate_columns(table))
    names = {
        normalise_name(name): i
        for i, name in reversed(list(enumerate(layout.header)))
        if i not in columns.xyz
    }
    for triple in COLOR_NAMES:
        if all(n in names for n in triple):
            columns.rgb = [names[n] for n in triple]
            break
    for triple in NORMAL_NAMES:
        if all(n in names for n in triple):
            columns.normals = [names[n] for n in triple]
            break
    used_columns = {*columns.xyz, *columns.rgb, *columns.normals}
    for i, name in enumerate(layout.header):
        if i not in used_columns:
            label = name or f"column {i + 1}"
            columns.other_fields[i] = (
                label if label not in columns.other_fields.values() else f"{label} {i + 1}"
            )
    return columns


def _columns_by_value(layout: Layout, path: Path, findings: list[Finding]) -> ColumnUses:
    """Assign unnamed columns: x, y, z first, then colours and normals by their values.

    Raises InputError if there are fewer than three columns.
    """
    if layout.width < 3:
        raise InputError(
            Finding("table.column-count", count=layout.width, columns=("x", "y", "z")),
            file=path,
            line=layout.n_skipped_lines + 1,
        )
    columns = ColumnUses([0, 1, 2])
    rows = [row for row in layout.sample if len(row) == layout.width]
    cells = [
        [parse_number(cell, decimal_comma=layout.decimal == ",") for cell in row] for row in rows
    ]
    values = np.array(
        [[np.nan if cell is None else cell for cell in row] for row in cells], np.float64
    )
    column = 3
    while column < layout.width:
        triple = values[:, column : column + 3]
        remaining_columns = layout.width - column
        if (
            remaining_columns >= 3
            and not columns.rgb
            and _are_colors(triple, remaining_columns in (3, 4, 6))
        ):
            columns.rgb = [column, column + 1, column + 2]
        elif remaining_columns >= 3 and not columns.normals and _are_normals(triple):
            columns.normals = [column, column + 1, column + 2]
        else:
            columns.other_fields[column] = f"column {column + 1}"
            column += 1
            continue
        findings.append(
            Finding(
                "model.columns-as-colors"
                if columns.rgb[:1] == [column]
                else "model.columns-as-normals",
                first=column + 1,
                last=column + 3,
            )
        )
        column += 3
    return columns


def _are_colors(values: AnyArray, can_be_fractions: bool) -> bool:
    if not np.isfinite(values).all() or values.min() < 0:
        return False
    if (values == np.rint(values)).all():
        return bool(values.max() <= 255) and bool(values.max() > 1)
    return can_be_fractions and bool(values.max() <= 1) and not _are_normals(values)


def _are_normals(values: AnyArray) -> bool:
    if not np.isfinite(values).all():
        return False
    return bool(np.abs(np.sqrt((values**2).sum(axis=1)) - 1).max() < 0.02)


def _numbers(data: bytes, layout: Layout, path: Path, progress: Progress) -> dict[int, AnyArray]:
    """Return the columns of the table; columns that contain text have the object type.

    Raises InputError with the invalid line.
    """
    progress.stage(tr("Reading the points"), len(data))
    if len(data) <= FEW_BYTES and (parsed_numbers := parse_plain_numbers(data, layout)) is not None:
        return parsed_numbers
    import pandas

    file = io.BytesIO(data)
    columns, rows = Columns(1), 0
    try:
        with pandas.read_csv(
            file,
            sep=r"\s+" if layout.delimiter == " " else layout.delimiter,
            header=None,
            names=list(range(layout.width)),
            index_col=False,
            skiprows=layout.n_skipped_lines,
            comment="#",
            decimal=layout.decimal,
            engine="c",
            skipinitialspace=True,
            low_memory=False,
            encoding_errors="replace",
            na_values=["-", "none", "None"],
            # All cells at once would take more memory than the text and the numbers together.
            chunksize=BLOCK_ROWS,
            **({"float_precision": "round_trip"} if _is_old_pandas(pandas) else {}),
        ) as pieces:
            for piece in pieces:
                for i in range(layout.width):
                    columns.add(str(i), piece[i].to_numpy())
                rows += len(piece)
                progress.step(file.tell())
    except (ValueError, OverflowError, LookupError) as error:
        read_points(path)  # raises an error with the line and the reason
        raise InputError(
            Finding("file.damaged", reason=" ".join(str(error).split())[:160], format="XYZ"),
            file=path,
        ) from error
    table = {i: columns.take(str(i), rows) for i in range(layout.width)}
    return {i: column for i, column in table.items() if column is not None}


def _is_old_pandas(pandas: Any) -> bool:
    """Return whether the installed pandas is older than 3.1.

    By default, older versions do not read the nearest float64 (one in eight numbers of 16 digits
    has a wrong last bit), and they drop surplus cells in the first row of a piece without an error.
    """
    return tuple(int(part) for part in pandas.__version__.split(".")[:2]) < (3, 1)


def _refuse_ragged_rows(table: Any, data: bytes, layout: Layout, path: Path) -> None:
    """Reject a row with too many or too few cells. Raises InputError with its line."""
    named_column_count = layout.width if layout.header is None else len(layout.header)
    is_beyond = any(not _is_empty(table[i]) for i in range(named_column_count, layout.width))
    last_column = table[layout.width - 1]
    is_suspicious = last_column.dtype.kind not in "iu" and bool(np.any(last_column != last_column))
    if len(last_column) > BLOCK_ROWS:
        import pandas

        is_suspicious |= _is_old_pandas(pandas)
    if is_beyond or (
        is_suspicious and not has_equal_widths(data, layout.delimiter, layout.n_skipped_lines)
    ):
        read_points(path)


def _is_empty(column: Any) -> bool:
    return bool(np.all(column != column))


_PLAIN_NUMBER = re.compile(r"-?(?:0|[1-9][0-9]*)(?:\.[0-9]+)?")
_BLANKS = re.compile(r"[ \t]+")
_EXACT_DIGITS = 15


def parse_plain_numbers(data: bytes, layout: Layout) -> dict[int, AnyArray] | None:
    """Return the columns of a small table of plain numbers, exactly as pandas reads them.

    Any parser rounds numbers of at most 15 characters only once. Returns None for any other table.
    This avoids importing pandas, which takes longer than reading the table.
    """
    try:
        lines = data.decode("ascii").split("\n")[layout.n_skipped_lines :]
    except UnicodeDecodeError:
        return None
    rows = []
    for line in lines[:-1] if lines[-1] == "" else lines:
        line = line.removesuffix("\r")
        is_blank_separated = layout.delimiter == " "
        cells = (
            _BLANKS.split(line.strip(" \t")) if is_blank_separated else line.split(layout.delimiter)
        )
        if layout.decimal == ",":
            if "." in line:
                return None
            cells = [cell.replace(",", ".") for cell in cells]
        is_valid = len(cells) == layout.width and all(
            _PLAIN_NUMBER.fullmatch(cell) and len(cell) <= _EXACT_DIGITS for cell in cells
        )
        if not is_valid:
            return None
        rows.append(cells)
    return {i: _column(cells) for i, cells in enumerate(zip(*rows, strict=True))} or None


def _column(cells: Sequence[str]) -> AnyArray:
    if any("." in cell for cell in cells):
        return np.array([float(cell) for cell in cells])
    return np.array([int(cell) for cell in cells], np.int64)


def _cloud(
    table: dict[int, AnyArray],
    columns: ColumnUses,
    layout: Layout,
    path: Path,
    findings: list[Finding],
) -> PointCloud:
    def numeric_column(i: int) -> AnyArray | None:
        return np.asarray(table[i]) if table[i].dtype.kind in "iuf" else None

    points = np.empty((len(table[0]), 3))
    for axis, i in enumerate(columns.xyz):
        values = numeric_column(i)
        if values is None:
            read_points(path)
            raise InputError(
                Finding("table.value-missing"),
                file=path,
                field=layout.header[i] if layout.header else f"column {i + 1}",
            )
        points[:, axis] = values
        # Freed immediately because it is as large as the result.
        del values, table[i]
    is_far = np.zeros(len(points), bool)
    for column in points.T:
        is_beyond = np.abs(column) > MAX_COORDINATE_M
        column[is_beyond] = np.nan
        is_far |= is_beyond
    if is_far.any():
        findings.append(Finding("model.points-far-away", count=int(is_far.sum())))
    colors, normals = (
        _stack_columns(columns.rgb, numeric_column),
        _stack_columns(columns.normals, numeric_column),
    )
    fields: dict[str, AnyArray] = {}
    text_columns = []
    for i, name in columns.other_fields.items():
        values = numeric_column(i)
        if values is None:
            text_columns.append(name)
        else:
            fields[name] = np.ascontiguousarray(values)
    if columns.rgb and colors is None:
        findings.append(Finding("model.colors-not-numbers"))
    if columns.normals and normals is None:
        findings.append(Finding("model.normals-not-numbers"))
    if text_columns:
        findings.append(Finding("model.columns-left-out", columns=text_columns))
    return PointCloud(
        points,
        None if colors is None else to_uint8_colors(colors),
        normals,
        fields,
    )


def _stack_columns(indices: list[int], numeric_column: Any) -> AnyArray | None:
    columns = [numeric_column(i) for i in indices]
    if not columns or any(column is None for column in columns):
        return None
    return np.stack(columns, axis=1, dtype=np.float32, casting="unsafe")


READER = Reader(
    to_translate("text table of points"),
    (
        ".xyz",
        ".csv",
        ".txt",
        ".asc",
        ".pts",
        ".xyzrgb",
        ".xyzn",
        # Other extensions of tables, such as those that `info` treats as tables.
        ".tsv",
        ".dat",
        ".tab",
        ".prn",
    ),
    matches,
    read,
)
