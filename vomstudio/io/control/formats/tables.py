"""Tables of our own.

Control points are a table `label, x, y, z` with, where wanted, `sigma` (metres) and `use` (control
or check); marks are a table `label, photo, x, y`, in pixels of the photo as stored, from the outer
corner of its top left pixel, x to the right and y down. A comment that begins with it states the
CRS: `# EPSG:32633`, or WKT in one line. Coordinates are in metres.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from vomstudio.errors import InputError, UsageError
from vomstudio.io.control.format import ControlFormat
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.io.control.projection import in_metres
from vomstudio.io.text.encodings import as_utf8
from vomstudio.io.text.tables import TABLE_ENDINGS, TextTable, read_table
from vomstudio.words import to_translate, tr

_IN_COMMENT = re.compile(
    r"[#\s]*(?:CRS\s*(?:[:=]\s*)?)?(EPSG:\d+\b|[A-Z]+CRS\[.*\])", re.IGNORECASE
)
_CONTROL = {"", "control", "yes", "true", "1", "gcp"}
_CHECK = {"check", "no", "false", "0"}


def points_of(path: Path) -> list[ControlPoint]:
    """Raises InputError with file, line and column."""
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
                raise _at(table, row, column, tr("The accuracy of a point must be positive."))
    uses = [""] * len(table)
    if table.has("use"):
        column = table.find("use")
        uses = [cell.casefold() for cell in table.cells(column)]
        for row, use in enumerate(uses):
            if use not in _CONTROL | _CHECK:
                raise _at(table, row, column, tr("'{use}' is neither control nor check.", use=use))
    points = []
    seen: dict[str, int] = {}
    for row, name in enumerate(table.labels(label)):
        if not name:
            raise _at(table, row, label, tr("The label is empty. Every point needs one."))
        if name in seen:
            first = int(table.line_numbers[seen[name]])
            raise _at(
                table,
                row,
                label,
                tr(
                    "The label '{name}' is also in line {line}. Give each point its own label.",
                    name=name,
                    line=first,
                ),
            )
        seen[name] = row
        place = (float(positions[row, 0]), float(positions[row, 1]), float(positions[row, 2]))
        known = None if np.isnan(sigmas[row]) else float(sigmas[row])
        points.append(ControlPoint(name, place, known, uses[row] in _CHECK))
    if not points:
        raise InputError(tr("The file has no points. Add some, or choose another file."), file=path)
    return points


def marks_of(path: Path) -> list[Mark]:
    """Raises InputError with file, line and column."""
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
        raise InputError(tr("The file has no marks. Add some, or choose another file."), file=path)
    seen: dict[tuple[str, str], int] = {}
    for row, mark in enumerate(marks):
        first = seen.setdefault((mark.label, mark.photo), row)
        if first != row:
            line = int(table.line_numbers[first])
            raise _at(
                table,
                row,
                label,
                tr(
                    "The point is already marked in {photo} in line {line}.",
                    photo=mark.photo,
                    line=line,
                ),
            )
    return marks


def crs_of(path: Path) -> str | None:
    """Raises InputError for one in degrees, which a table is not read in."""
    for comment in read_table(path).comments:
        if stated := _IN_COMMENT.match(comment):
            return in_metres(path, (), stated[1], _line_of(path, comment))[1]
    return None


def _line_of(path: Path, comment: str) -> int | None:
    """The line of a comment of a table; None where its encoding hides it."""
    lines = as_utf8(path.read_bytes()).decode("utf-8", "replace").splitlines()
    bare = (text.strip() for text in lines)
    return next(
        (n for n, t in enumerate(bare, 1) if t[:1] == "#" and t[1:].strip() == comment), None
    )


def _columns(table: TextTable, *names: str) -> list[int]:
    if table.names is None:
        raise InputError(
            tr(
                "The table has no header. Name the columns {names} in its first line.",
                names=", ".join(names),
            ),
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
        raise _at(
            table,
            int(bad[0, 0]),
            columns[int(bad[0, 1])],
            tr("The value is missing or not a number."),
        )


def _at(table: TextTable, row: int, column: int, message: str) -> InputError:
    line = int(table.line_numbers[row])
    return InputError(message, file=table.path, line=line, field=table.label(column))


CONTROL_FORMAT = ControlFormat(
    to_translate("table of control points"),
    matches=lambda path: True,
    points=points_of,
    marks=marks_of,
    crs=crs_of,
    certain=False,
    extensions=TABLE_ENDINGS,
)
