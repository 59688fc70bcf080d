"""Tables of control points and marks.

Control points are a table `label, x, y, z` with optional `sigma` (metres) and `use` (control or
check). Marks are a table `label, photo, x, y` in pixels of the stored photo, measured from the
outer corner of its top-left pixel, with x to the right and y down. The CRS is stated by a comment
(`# EPSG:32633`, or WKT on one line) or by `NAME.prj` next to the table. Coordinates are in metres.
Columns may have the names used by other programs, in a header that begins with `#` as in Metashape,
or no names.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate
from vomstudio.io.control.format import ControlFormat
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.io.control.projection import project_points
from vomstudio.io.gate.stated_crs import table_crs
from vomstudio.io.text.file_text import MAX_OBJECTS
from vomstudio.io.text.named_columns import LABEL_NAMES, PHOTO_NAMES, WORLD, NamedTable
from vomstudio.io.text.tables import TABLE_EXTENSIONS, read_table

_POINT_COLUMNS, _MARK_COLUMNS = ("label", "x", "y", "z"), ("label", "photo", "x", "y")
"""Order of the columns in a table without a header."""
_PHOTO_COLUMN = tuple(name for name in PHOTO_NAMES if name not in LABEL_NAMES)
_X_COLUMNS = ("x", "x px", "pixel x", "px", "u", "column", "col")
_Y_COLUMNS = ("y", "y px", "pixel y", "py", "v", "row", "line")


def read_points(path: Path) -> list[ControlPoint]:
    """Return the points of a table. Raises InputError with file, line and column."""
    if not len(read_table(path, max_lines=MAX_OBJECTS)):
        raise InputError(Finding("control.no-points"), file=path)
    table = NamedTable(path, _POINT_COLUMNS)
    labels = table.words(LABEL_NAMES, "label")
    table.require_unique(labels)
    positions, is_check_point = table.columns(WORLD, _POINT_COLUMNS[1:]), table.is_check_point()
    points = []
    for label, position, sigma, check in zip(
        labels, positions, table.sigma(), is_check_point, strict=True
    ):
        x, y, z = position.tolist()
        points.append(ControlPoint(label, (x, y, z), _common_sigma(sigma), bool(check)))
    return points


def _common_sigma(sigma: FloatArray) -> float | None:
    """Return the root mean square of the coordinate errors (3,), or None if not stated."""
    stated_sigma = sigma[np.isfinite(sigma)].tolist()
    if len(set(stated_sigma)) <= 1:
        return stated_sigma[0] if stated_sigma else None
    return float(np.sqrt(np.mean(np.square(stated_sigma))))


def read_marks(path: Path) -> list[Mark]:
    """Return the marks of a table. Raises InputError with file, line and column."""
    if not len(read_table(path, max_lines=MAX_OBJECTS)):
        raise InputError(Finding("control.no-marks"), file=path)
    table = NamedTable(path, _MARK_COLUMNS)
    labels = table.words(LABEL_NAMES, "label")
    names = [name.replace("\\", "/") for name in table.words(_PHOTO_COLUMN, "photo")]
    pixels = table.columns((_X_COLUMNS, _Y_COLUMNS), ("x", "y"))
    marks = []
    first_rows: dict[tuple[str, str], int] = {}
    for row, (label, name, (x, y)) in enumerate(zip(labels, names, pixels.tolist(), strict=True)):
        first_row = first_rows.setdefault((label, name), row)
        if first_row != row:
            raise table.cell_error(
                row,
                Finding(
                    "control.mark-repeated",
                    photo=name,
                    first_line=int(table.table.line_numbers[first_row]),
                    label=label,
                ),
                "label",
            )
        marks.append(Mark(label, name, x, y))
    return marks


def read_crs(path: Path) -> str | None:
    """Return the CRS that is stated by the table or its `.prj` file, or None.

    Raises
    ------
    InputError
        If the CRS is unknown, in degrees or not in metres.
    """
    stated_crs, findings = table_crs(path, read_table(path, max_lines=MAX_OBJECTS).comments)
    if findings and stated_crs.text is None:
        raise InputError(findings[0], file=path, field="CRS")
    return project_points(path, (), stated_crs.text)[1]


CONTROL_FORMAT = ControlFormat(
    to_translate("control point table"),
    matches=lambda path: True,
    points=read_points,
    marks=read_marks,
    crs=read_crs,
    is_certain=False,
    extensions=TABLE_EXTENSIONS,
)
