"""Tables that other programs write, recognised by their columns.

- Traces, planes and lineations of CloudCompare's Compass plugin (`ccCompassExport::SaveCSV`).
- Facets of CloudCompare's Facets plugin (`qFacets::ExecuteExportFacetsInfo`).
- Annotations of PRo3D (`PRo3D.Base.Annotation.CSVExport`).
- Traces in two dimensions of FracPaQ (`readTraces.m`).
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.io.gate.stated_crs import StatedCrs, table_crs
from vomstudio.io.text.column_names import normalise_name
from vomstudio.project.imports.compass_names import split_path
from vomstudio.project.imports.listed_rows import (
    ListedRow,
    ReadingReport,
    plane_from_angles,
    to_number,
)

Cells = Mapping[str, str]
_COMPASS_TRACES = {"name", "traceid", "pointid", "startx", "starty", "startz", "endx", "endz"}
_COMPASS_PLANES = {"name", "strike", "dip", "dipdir", "cx", "cy", "cz", "nx", "ny", "nz", "rms"}
_COMPASS_LINES = {"name", "sx", "sy", "sz", "ex", "ey", "ez", "trend", "plunge", "length"}
_COMPASS_THICKNESSES = {"name", "sx", "sy", "sz", "ex", "ey", "ez", "trend", "plunge", "thickness"}
_FACETS = {"index", "centerx", "centery", "centerz", "normalx", "rms", "dipdir", "dip", "surface"}
_PRO3D = {"key", "geometry", "projection", "semantic", "dipangle", "dipazimuth", "surfacename"}
_MIN_CELLS, _MAX_SAMPLED_LINES = 4, 200
_STREAM_DIGITS = 6
"""Significant digits of numbers that Facets writes."""
MAX_ROUNDING_M = 0.01


def program_table_rows(
    path: Path, lines: list[str], report: ReadingReport
) -> Iterator[ListedRow] | None:
    """Return the rows of a table of another program, or None for other tables.

    Parameters
    ----------
    path : Path
    lines : list of str
        Lines of the table.
    report : ReadingReport
        Receives findings and the parts that are left out.
    """
    if _is_fracpaq(lines):
        return _fracpaq_rows(lines)
    comments = [line[1:].strip() for line in lines if line.startswith("#")]
    body = [line for line in lines if line.strip() and not line.startswith("#")]
    if not body:
        return None
    delimiter = max(",;\t", key=body[0].count)
    names = [normalise_name(name) for name in body[0].replace('"', "").split(delimiter)]
    readers = (
        (_COMPASS_TRACES, _compass_traces),
        (_COMPASS_PLANES, _compass_planes),
        (_COMPASS_LINES, _compass_lines),
        (_COMPASS_THICKNESSES, _compass_thicknesses),
        (_FACETS, _facet_rows),
        (_PRO3D, _pro3d_rows),
    )
    for columns, read in readers:
        if columns <= set(names):
            frame, findings = table_crs(path, comments)
            report.findings += findings
            cells = list(_cells(path, body, names, delimiter))
            return read(cells, frame, report)
    return None


def _cells(path: Path, body: list[str], names: list[str], delimiter: str) -> Iterator[Cells]:
    """Yield the cells of each row by normalised column name; a short row has fewer.

    Raises InputError if the table cannot be read.
    """
    reader = csv.reader(body[1:], delimiter=delimiter)
    while True:
        try:
            row = next(reader)
        except StopIteration:
            return
        except csv.Error as error:
            message = Finding("table.unreadable", reason=error)
            raise InputError(message, file=path, line=reader.line_num) from error
        yield {name: cell.strip() for name, cell in zip(names, row, strict=False) if name}


def _numbers(cells: Cells, *names: str) -> list[float]:
    return [to_number(cells.get(name)) for name in names]


def _compass_traces(
    table: list[Cells], frame: StatedCrs, report: ReadingReport
) -> Iterator[ListedRow]:
    """Yield the traces of a table of segments."""
    traces: dict[tuple[str, str], list[Cells]] = {}
    for cells in table:
        key = (cells.get("traceid", ""), cells.get("name", ""))
        traces.setdefault(key, []).append(cells)
    for (_, path_name), segments in traces.items():
        starts = [_numbers(cells, "startx", "starty", "startz") for cells in segments]
        ends = [_numbers(cells, "endx", "endy", "endz") for cells in segments]
        name, groups = split_path(path_name)
        if starts[1:] != ends[:-1]:
            report.skipped.append((path_name, Finding("import.gaps")))
            continue
        points = np.array([starts[0], *ends])
        yield ListedRow("traces", points, {"name": name}, frame, groups, notes=path_name)


def _compass_planes(
    table: list[Cells], frame: StatedCrs, report: ReadingReport
) -> Iterator[ListedRow]:
    for cells in table:
        path_name = cells.get("name", "")
        plane = plane_from_angles(*_numbers(cells, "dipdir", "dip"))
        if plane is None:
            report.skipped.append((path_name, Finding("import.no-orientation")))
            continue
        # The global position is missing if the project of CloudCompare has no cloud.
        has_global_position = all(name in cells for name in ("gx", "gy", "gz"))
        position = _numbers(
            cells, *(("gx", "gy", "gz") if has_global_position else ("cx", "cy", "cz"))
        )
        name, groups = split_path(path_name)
        yield ListedRow(
            "planes", np.array([position]), {"name": name}, frame, groups, plane, path_name
        )


def _compass_lines(
    table: list[Cells], frame: StatedCrs, report: ReadingReport
) -> Iterator[ListedRow]:
    for cells in table:
        path_name = cells.get("name", "")
        points = np.array([_numbers(cells, "sx", "sy", "sz"), _numbers(cells, "ex", "ey", "ez")])
        name, groups = split_path(path_name)
        yield ListedRow("lineations", points, {"name": name}, frame, groups, notes=path_name)


def _compass_thicknesses(
    table: list[Cells], frame: StatedCrs, report: ReadingReport
) -> Iterator[ListedRow]:
    reason = Finding("import.no-counterpart")
    report.skipped += [(cells.get("name", ""), reason) for cells in table]
    return iter(())


def _facet_rows(table: list[Cells], frame: StatedCrs, report: ReadingReport) -> Iterator[ListedRow]:
    rounding_m = 0.0
    for cells in table:
        label = cells.get("index", "")
        plane = plane_from_angles(*_numbers(cells, "dipdir", "dip"))
        if plane is None:
            report.skipped.append((label, Finding("import.no-orientation")))
            continue
        names = ["globalcenterx", "globalcentery", "globalcenterz"]
        if not set(names) <= cells.keys():
            # Versions before 2.13.1 write local coordinates only.
            names = ["centerx", "centery", "centerz"]
        rounding_m = max(rounding_m, *(_rounding_error(cells.get(name, "")) for name in names))
        family = cells.get("familyind", "")
        yield ListedRow(
            "planes",
            np.array([_numbers(cells, *names)]),
            {"id": label, "set": family if family.isdigit() else ""},
            frame,
            plane=plane,
            notes=f"CloudCompare Facets {label}",
        )
    if rounding_m > MAX_ROUNDING_M:
        report.findings.append(Finding("import.coordinates-rounded", rounding=f"{rounding_m:.2g}"))


def _rounding_error(text: str) -> float:
    """Return the largest rounding error of a number with six significant digits, or 0."""
    value = to_number(text)
    if not np.isfinite(value) or not value:
        return 0.0
    mantissa = text.lower().partition("e")[0].strip("+-").lstrip("0.").replace(".", "")
    if len(mantissa) > _STREAM_DIGITS:
        return 0.0
    return 0.5 * float(10.0 ** (np.floor(np.log10(abs(value))) + 1 - _STREAM_DIGITS))


def _pro3d_rows(table: list[Cells], frame: StatedCrs, report: ReadingReport) -> Iterator[ListedRow]:
    for cells in table:
        label = cells.get("text") or cells.get("key", "")
        plane = plane_from_angles(*_numbers(cells, "dipazimuth", "dipangle"))
        if plane is None:
            report.skipped.append((label, Finding("import.no-orientation")))
            continue
        yield ListedRow(
            "planes",
            np.array([_numbers(cells, "x", "y", "z")]),
            {"name": cells.get("text", ""), "id": cells.get("key", "")},
            frame,
            (cells.get("groupname", ""),),
            plane,
            notes=f"PRo3D {cells.get('surfacename', '')}".strip(),
            structure=cells.get("groupname", ""),
        )


def _is_fracpaq(lines: list[str]) -> bool:
    """Return whether each line contains the x and y of the nodes of one trace."""
    counts = set()
    for line in lines[:_MAX_SAMPLED_LINES]:
        if not line.strip():
            continue
        cells = line.strip().split("\t")
        if not np.isfinite([to_number(cell) for cell in cells]).all():
            return False
        counts.add(len(cells))
    return (
        len(counts) > 1 and all(n % 2 == 0 for n in counts) and min(counts, default=0) >= _MIN_CELLS
    )


def _fracpaq_rows(lines: list[str]) -> Iterator[ListedRow]:
    """Yield traces without heights."""
    for line in lines:
        if line.strip():
            values = np.array([to_number(cell) for cell in line.strip().split("\t")])
            nodes = values[: len(values) // 2 * 2].reshape(-1, 2)
            yield ListedRow("traces", np.column_stack([nodes, np.full(len(nodes), np.nan)]))
