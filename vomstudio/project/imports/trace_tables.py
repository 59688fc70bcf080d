"""Traces in tables of points, separated by blank lines or identified by a column.

Blank lines between objects are written by Move ("Insert line break between objects"; described in
Move2FracPaq.m of FracPaQ).
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import IntArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.io.gate.stated_crs import StatedCrs, table_crs
from vomstudio.io.text.column_names import normalise_name
from vomstudio.io.text.group_columns import group_words
from vomstudio.io.text.tables import (
    PointGroups,
    TextTable,
    coordinate_columns,
    read_points,
    read_table,
)
from vomstudio.project.imports.listed_rows import ListedRow, ReadingReport, stated_plane
from vomstudio.project.tables.feature_lists import WKT_COLUMN

_TRACE_COLUMNS = (
    *("trace", "traceid", "tracename", "polyline", "polylineid", "line", "lineid", "linename"),
    *("stick", "stickid", "fracture", "fractureid", "fault", "plane", "planeid", "surface"),
    *("feature", "featureid", "object", "objectid", "group", "groupid", "name", "label", "id"),
    *("fid", "segment", "part"),
)
"""Names of columns that identify the trace of each point, the most specific first."""
_STATION_COLUMNS = ("station", "number", "photo", "what")
_WORDS = ("kind", "type", "set", "notes", "note", "description", "name")
MIN_POINTS_PER_TRACE = 2


def trace_table_rows(
    path: Path, lines: list[str], report: ReadingReport
) -> Iterator[ListedRow] | None:
    """Return the traces of a table of points, or None if the table does not group its points.

    Parameters
    ----------
    path : Path
    lines : list of str
        Lines of the table.
    report : ReadingReport
        Receives findings.

    Raises
    ------
    InputError
        If the table has no header and does not group its points.
    """
    if path.stem.casefold().rpartition("_")[2] == "stations":
        return None
    try:
        table = read_table(path)
        columns = coordinate_columns(table)
    except InputError:
        # The reader of stations reports what is wrong.
        return None
    if any(table.has(name) for name in (*_STATION_COLUMNS, WKT_COLUMN)) or not len(table):
        return None
    frame, findings = table_crs(path, table.comments)
    column = _group_column(table, columns)
    if column is not None or table.separators:
        by = "segment" if column is None else str(column + 1)
        groups = read_points(path, by)
        report.findings += [*findings, *groups.warnings]
        return _grouped_rows(table, column, groups, frame, report)
    codes = _blocks(table, lines)
    if codes is not None:
        report.findings += findings
        points = table.numbers(columns)
        blocks = (points[codes == code] for code in range(int(codes.max()) + 1))
        return (ListedRow("traces", block, frame=frame) for block in blocks)
    if table.names is None:
        raise InputError(Finding("import.no-trace-column"), file=path)
    return None


def _group_column(table: TextTable, coordinates: list[int]) -> int | None:
    """Return the column whose values are shared by the points of a trace, or None."""
    if table.names is None:
        candidates = [column for column in range(table.width) if column not in coordinates]
    else:
        names = [normalise_name(name) for name in table.names]
        candidates = [names.index(name) for name in _TRACE_COLUMNS if name in names]
    for column in candidates:
        labels, codes = table.label_codes(column)
        run_count = 1 + int((np.diff(codes) != 0).sum())
        is_shared = len(labels) * MIN_POINTS_PER_TRACE <= len(table)
        if is_shared and (table.names is not None or run_count == len(labels)):
            return column
    return None


def _blocks(table: TextTable, lines: list[str]) -> IntArray | None:
    """Return the block (n,) of each row if blank lines separate blocks of rows, or None."""
    is_blank = np.array([not line.strip() for line in lines], np.bool_)
    blank_count = np.cumsum(is_blank)[table.line_numbers - 1]
    _, codes, counts = np.unique(blank_count, return_inverse=True, return_counts=True)
    is_divided = len(counts) > 1 and counts.min() >= MIN_POINTS_PER_TRACE
    return np.asarray(codes, np.int64) if is_divided else None


def _grouped_rows(
    table: TextTable,
    column: int | None,
    groups: PointGroups,
    frame: StatedCrs,
    report: ReadingReport,
) -> Iterator[ListedRow]:
    words: dict[str, dict[str, str]] = {}
    if column is not None and table.names is not None:
        columns = {
            name: table.cells(i)
            for i, name in enumerate(table.names)
            if i != column and (name.casefold() in _WORDS or "dip" in name.casefold())
        }
        words, findings = group_words(columns, table.labels(column), [True] * len(table))
        report.findings += [finding for finding in findings if finding not in report.findings]
    for i, label in enumerate(groups.ids):
        values = {name.casefold(): cells.get(label, "") for name, cells in words.items()}
        name = values.get("name") or ("" if label.isdecimal() else label)
        points = groups.points[groups.offsets[i] : groups.offsets[i + 1]]
        yield ListedRow(
            "traces",
            points,
            {**values, "name": name, "id": label},
            frame,
            plane=stated_plane(values),
        )
