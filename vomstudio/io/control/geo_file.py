"""Camera position file `geo.txt` of OpenDroneMap.

The first line states the coordinate system. Each further line describes a photo as
`image x y [z] [yaw pitch roll] [horizontal_accuracy vertical_accuracy]`.

Yaw, pitch and roll follow the convention of OpenDroneMap. At pitch 0, the camera points
straight down and the top of the photo faces forward. At pitch 90, the camera looks forward.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.geometry.coordinate_limits import check_error
from vomstudio.io.control.formats.opendronemap import is_odm, parse_projection
from vomstudio.io.text.file_text import MAX_OBJECTS, read_text
from vomstudio.io.text.rows import is_comma_number, shorten

_COLUMNS = ("x", "y", "z", "yaw", "pitch", "roll", "horizontal_accuracy", "vertical_accuracy")


@dataclass(frozen=True, eq=False)
class GeoFile:
    """Content of a `geo.txt` file.

    Attributes
    ----------
    crs : str
        CRS in a form that pyproj accepts.
    line : int
        Line number of the header.
    coordinates : (n, 3) float64
        Coordinates as written; NaN for a missing height.
    angles : (n, 3) float64
        Yaw, pitch and roll; NaN if not stated.
    sigma : (n, 2) float64
        Horizontal and vertical accuracy; NaN if not stated.
    """

    path: Path
    crs: str
    line: int
    photos: tuple[str, ...]
    lines: tuple[int, ...]
    coordinates: FloatArray
    angles: FloatArray
    sigma: FloatArray


def is_geo(path: Path) -> bool:
    """Return whether a file starts with a coordinate system followed by a photo name."""
    if not is_odm(path):
        return False
    rows = _rows(path)
    cells = rows[1][1] if len(rows) > 1 else []
    return bool(cells) and _number(cells[0]) is None


def read_geo(path: Path) -> GeoFile:
    """Read a `geo.txt` file. Raises InputError with line and column."""
    rows = _rows(path)
    line, header = rows[0][0], " ".join(rows[0][1])
    crs = parse_projection(path, line, header)
    photos, lines, values = list[str](), list[int](), list[list[float]]()
    first_lines: dict[str, int] = {}
    for line_number, cells in rows[1:]:
        name_end = _end_of_name(cells)
        name = " ".join(cells[:name_end]).replace("\\", "/")
        if name in first_lines:
            raise InputError(
                Finding("table.repeated-label", label=shorten(name), first_line=first_lines[name]),
                file=path,
                line=line_number,
                field="image",
            )
        first_lines[name] = line_number
        value_cells = cells[name_end : name_end + len(_COLUMNS)]
        if len(value_cells) < 2:
            raise InputError(
                _too_few_cells_finding(cells),
                file=path,
                line=line_number,
                field="x",
            )
        row_numbers = [
            _value(path, line_number, n, value_cell)
            for n, value_cell in zip(_COLUMNS, value_cells, strict=False)
        ]
        row_numbers += [float("nan")] * (len(_COLUMNS) - len(row_numbers))
        photos.append(name)
        lines.append(line_number)
        values.append(row_numbers)
    if not photos:
        raise InputError(Finding("control.no-photos"), file=path, line=line)
    table = np.array(values, np.float64)
    for row, column in np.argwhere(table[:, 6:] <= 0):
        raise InputError(
            Finding("table.not-positive"),
            file=path,
            line=lines[int(row)],
            field=_COLUMNS[6 + int(column)],
        )
    for row, column in np.ndindex(len(table), table.shape[1] - 6):
        if (finding := check_error(float(table[row, 6 + column]))) is not None:
            raise InputError(finding, file=path, line=lines[row], field=_COLUMNS[6 + column])
    return GeoFile(
        path, crs, line, tuple(photos), tuple(lines), table[:, :3], table[:, 3:6], table[:, 6:]
    )


def _rows(path: Path) -> list[tuple[int, list[str]]]:
    text, _ = read_text(path, MAX_OBJECTS)
    return [
        (line_number, [cell.strip() for cell in line.split("\t")] if "\t" in line else line.split())
        for line_number, line in enumerate(text.split("\n"), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]


def _too_few_cells_finding(cells: list[str]) -> Finding:
    """Return the finding for a line without coordinates or with another delimiter."""
    text = " ".join(cells)
    delimiter = next((delimiter for delimiter in ",;" if text.count(delimiter) >= 2), None)
    if delimiter is not None:
        return Finding("table.other-delimiter", delimiter=delimiter)
    return Finding("table.column-count", count=len(cells), columns=("image", "x", "y"))


def _end_of_name(cells: list[str]) -> int:
    """Return the number of cells of the photo name, which may contain spaces.

    The name ends before the first two adjacent numbers; without them, it is one cell.
    """
    for index in range(1, len(cells) - 1):
        if _number(cells[index]) is not None and _number(cells[index + 1]) is not None:
            return index
    return 1


def _number(cell: str) -> float | None:
    try:
        value = float(cell)
    except ValueError:
        return None
    return value if isfinite(value) else None


def _value(path: Path, line: int, name: str, cell: str) -> float:
    value = _number(cell)
    if value is not None:
        return value
    if name not in ("x", "y") and not is_comma_number(cell):
        # Cells after the numbers belong to other programs.
        return float("nan")
    finding = Finding("table.not-a-number", cell=shorten(cell))
    if is_comma_number(cell):
        finding = Finding("table.decimal-comma", cell=shorten(cell))
    raise InputError(finding, file=path, line=line, field=name)
