"""Ground control: points with surveyed coordinates, and where they are seen in the photos.

Control points are a table `label, x, y, z` with, where wanted, `sigma` (metres) and `use` (control
or check); marks are a table `label, photo, x, y`, in pixels of the photo as stored, from the outer
corner of its top left pixel, x to the right and y down. Labels that are marked and not in the table
of control points are tie points: places that the photos share.

Beside the photos, as `control.csv` and `marks.csv`, both are found without being named.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vomstudio.errors import InputError, TargetError, UsageError
from vomstudio.files.atomic import write_bytes
from vomstudio.files.backup import set_aside
from vomstudio.io.text.tables import TextTable, read_table

CONTROL, MARKS = "control.csv", "marks.csv"
"""Their names beside the photos."""

_CRS = re.compile(r"# (?:EPSG:\d+|[A-Z]+CRS\[.*\])")
_CONTROL = {"", "control", "yes", "true", "1", "gcp"}
_CHECK = {"check", "no", "false", "0"}


@dataclass(frozen=True)
class ControlPoint:
    """position : east, north, up in the CRS of the project, metres
    sigma_m : of each coordinate; None where the table does not say
    check : it judges the model and does not place it
    """

    label: str
    position: tuple[float, float, float]
    sigma_m: float | None = None
    check: bool = False


@dataclass(frozen=True)
class Mark:
    """photo : its name, as in the folder, or the last part of it
    x, y : pixels; (0.5, 0.5) is the centre of the top left pixel
    """

    label: str
    photo: str
    x: float
    y: float


def read_control(path: str | Path) -> list[ControlPoint]:
    """The points of a table, or of a file of another program (`io.control_files`). Raises
    InputError with file, line and column."""
    from vomstudio.io.control import control_files

    if (foreign := control_files.points_of(path)) is not None:
        return foreign
    table = read_table(path)
    label, x, y, z = _columns(table, "label", "x", "y", "z")
    positions = table.numbers([x, y, z])
    _require_finite(table, positions, (x, y, z))
    sigmas = [np.nan] * len(table)
    if table.has("sigma"):
        column = table.find("sigma")
        sigmas = list(table.numbers([column])[:, 0])
        for row, sigma in enumerate(sigmas):
            if sigma <= 0:
                raise _at(table, row, column, "is the error of a point and must be positive")
    uses = [""] * len(table)
    if table.has("use"):
        column = table.find("use")
        uses = [cell.casefold() for cell in table.cells(column)]
        for row, use in enumerate(uses):
            if use not in _CONTROL | _CHECK:
                raise _at(table, row, column, f"'{use}' is neither control nor check")
    points = []
    seen: dict[str, int] = {}
    for row, name in enumerate(table.labels(label)):
        if not name:
            raise _at(table, row, label, "is empty; every point needs a label")
        if name in seen:
            first = int(table.line_numbers[seen[name]])
            raise _at(table, row, label, f"'{name}' is in line {first} too; give each its own")
        seen[name] = row
        place = (float(positions[row, 0]), float(positions[row, 1]), float(positions[row, 2]))
        known = None if np.isnan(sigmas[row]) else float(sigmas[row])
        points.append(ControlPoint(name, place, known, uses[row] in _CHECK))
    if not points:
        raise InputError("has no points", file=path)
    return points


def read_marks(path: str | Path) -> list[Mark]:
    """The marks of a table, or of a file of another program. Raises InputError with file, line and
    column."""
    from vomstudio.io.control import control_files

    if (foreign := control_files.marks_of(path)) is not None:
        return foreign
    table = read_table(path)
    label, photo, x, y = _columns(table, "label", "photo", "x", "y")
    pixels = table.numbers([x, y])
    _require_finite(table, pixels, (x, y))
    names = [name.replace("\\", "/") for name in table.cells(photo)]
    marks = [
        Mark(text, name, float(place[0]), float(place[1]))
        for text, name, place in zip(table.labels(label), names, pixels, strict=True)
    ]
    if not marks:
        raise InputError("has no marks", file=path)
    seen: dict[tuple[str, str], int] = {}
    for row, mark in enumerate(marks):
        first = seen.setdefault((mark.label, mark.photo), row)
        if first != row:
            line = int(table.line_numbers[first])
            raise _at(table, row, label, f"is marked in {mark.photo} in line {line} already")
    return marks


def write_control(
    path: Path, points: Iterable[ControlPoint], crs: str | None = None
) -> Path | None:
    """Write the table of points, whole or not at all; without points there is none afterwards.

    crs : "EPSG:n" of the points, or WKT in one line where there is no code, which the table then
        states in a comment; None where not known
    Returns where a table was put that held more than these columns. Raises TargetError.
    """
    rows = [
        [p.label, *map(_digits, p.position), "" if p.sigma_m is None else _digits(p.sigma_m),
         "check" if p.check else "control"]
        for p in points
    ]  # fmt: skip
    comment = f"# {crs}\n" if crs is not None and _CRS.fullmatch(f"# {crs}") else ""
    return _write(path, ["label", "x", "y", "z", "sigma", "use"], rows, comment)


def write_marks(path: Path, marks: Iterable[Mark]) -> Path | None:
    """Write the table of marks, whole or not at all; without marks there is none afterwards.

    Returns where a table was put that held more than these columns. Raises TargetError.
    """
    rows = [[m.label, m.photo, _digits(m.x), _digits(m.y)] for m in marks]
    return _write(path, ["label", "photo", "x", "y"], rows)


def _write(
    path: Path, header: Sequence[str], rows: Sequence[Sequence[str]], comment: str = ""
) -> Path | None:
    kept = set_aside(path) if path.exists() and not _is_plain(path, header) else None
    if not rows:
        try:
            path.unlink(missing_ok=True)
        except OSError as error:
            raise TargetError(f"it cannot be removed ({error.strerror}).", file=path) from error
        return kept
    text = io.StringIO()
    # Unquoted, a line that begins with # or > is none of the table.
    odd = any(not row[0][:1].isalnum() for row in rows)
    writer = csv.writer(
        text, lineterminator="\n", quoting=csv.QUOTE_ALL if odd else csv.QUOTE_MINIMAL
    )
    writer.writerow(header)
    writer.writerows(rows)
    write_bytes(path, (comment + text.getvalue()).encode(), force=True)
    return kept


def _is_plain(path: Path, header: Sequence[str]) -> bool:
    """Whether a table holds nothing that would be lost if it were written anew."""
    try:
        with path.open(encoding="utf-8") as stream:
            first = stream.readline().rstrip("\n").replace('"', "")
            if _CRS.fullmatch(first):
                first = stream.readline().rstrip("\n").replace('"', "")
            return first == ",".join(header) and not any(row.startswith("#") for row in stream)
    except (OSError, UnicodeDecodeError):
        return False


def _digits(value: float) -> str:
    """As short as tells it apart from every other number."""
    return repr(float(value)).removesuffix(".0")


def _columns(table: TextTable, *names: str) -> list[int]:
    if table.names is None:
        raise InputError(
            f"has no header; its first line must name the columns {', '.join(names)}",
            file=table.path,
        )
    try:
        return [table.find(name) for name in names]
    except UsageError as error:
        raise InputError(
            error.message, file=table.path, line=table.header_line, field=error.field
        ) from error


def _require_finite(table: TextTable, values: np.ndarray, columns: tuple[int, ...]) -> None:
    bad = np.argwhere(~np.isfinite(values))
    if len(bad):
        raise _at(table, int(bad[0, 0]), columns[int(bad[0, 1])], "is missing or not a number")


def _at(table: TextTable, row: int, column: int, message: str) -> InputError:
    line = int(table.line_numbers[row])
    return InputError(message, file=table.path, line=line, field=table.label(column))
