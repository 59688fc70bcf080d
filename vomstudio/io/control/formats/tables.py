"""Tables of our own.

Control points are a table `label, x, y, z` with, where wanted, `sigma` (metres) and `use` (control
or check); marks are a table `label, photo, x, y`, in pixels of the photo as stored, from the outer
corner of its top left pixel, x to the right and y down. A comment that begins with it states the
CRS: `# EPSG:32633`, or WKT in one line. Coordinates are in metres. Columns may have the names that
other programs give them, in a header that begins with `#`, as Metashape's do, or none at all.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import numpy.typing as npt

from vomstudio.errors import InputError
from vomstudio.files.regular import read_whole
from vomstudio.io.control.format import ControlFormat
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.io.control.projection import in_metres
from vomstudio.io.text.encodings import as_utf8
from vomstudio.io.text.file_text import MOST_OBJECTS
from vomstudio.io.text.named_columns import LABEL, PHOTO, WORLD, NamedTable
from vomstudio.io.text.tables import TABLE_ENDINGS, read_table
from vomstudio.words import to_translate, tr

_IN_COMMENT = re.compile(
    r"[#\s]*(?:CRS\s*(?:[:=]\s*)?)?(EPSG:\d+\b|[A-Z]+CRS\[.*\])", re.IGNORECASE
)
_POINTS, _MARKS = ("label", "x", "y", "z"), ("label", "photo", "x", "y")
"""The order of the columns where there is no header."""
_IN_PHOTO = tuple(name for name in PHOTO if name not in LABEL)
_ACROSS = ("x", "x px", "pixel x", "px", "u", "column", "col")
_DOWN = ("y", "y px", "pixel y", "py", "v", "row", "line")


def points_of(path: Path) -> list[ControlPoint]:
    """Raises InputError with file, line and column."""
    if not len(read_table(path, most=MOST_OBJECTS)):
        raise InputError(tr("The file has no points. Add some, or choose another file."), file=path)
    table = NamedTable(path, _POINTS)
    labels = table.words(LABEL, "label")
    table.require_once(labels)
    places, uses = table.columns(WORLD, _POINTS[1:]), table.uses()
    points = []
    for label, place, sigma, check in zip(labels, places, table.sigma(), uses, strict=True):
        x, y, z = place.tolist()
        points.append(ControlPoint(label, (x, y, z), _one_for_all(sigma), bool(check)))
    return points


def _one_for_all(sigma: npt.NDArray[np.float64]) -> float | None:
    """Of the coordinates (3,), NaN where not stated: the root mean square, as the formats of other
    programs are read."""
    known = sigma[np.isfinite(sigma)].tolist()
    if len(set(known)) <= 1:
        return known[0] if known else None
    return float(np.sqrt(np.mean(np.square(known))))


def marks_of(path: Path) -> list[Mark]:
    """Raises InputError with file, line and column."""
    if not len(read_table(path, most=MOST_OBJECTS)):
        raise InputError(tr("The file has no marks. Add some, or choose another file."), file=path)
    table = NamedTable(path, _MARKS)
    labels = table.words(LABEL, "label")
    names = [name.replace("\\", "/") for name in table.words(_IN_PHOTO, "photo")]
    pixels = table.columns((_ACROSS, _DOWN), ("x", "y"))
    marks = []
    seen: dict[tuple[str, str], int] = {}
    for row, (label, name, (x, y)) in enumerate(zip(labels, names, pixels.tolist(), strict=True)):
        first = seen.setdefault((label, name), row)
        if first != row:
            raise table.at(
                row,
                tr(
                    "The point is already marked in {photo} in line {line}.",
                    photo=name,
                    line=int(table.table.line_numbers[first]),
                ),
                "label",
            )
        marks.append(Mark(label, name, x, y))
    return marks


def crs_of(path: Path) -> str | None:
    """Raises InputError for one in degrees, which a table is not read in."""
    for comment in read_table(path, most=MOST_OBJECTS).comments:
        if stated := _IN_COMMENT.match(comment):
            return in_metres(path, (), stated[1], _line_of(path, comment))[1]
    return None


def _line_of(path: Path, comment: str) -> int | None:
    """The line of a comment of a table; None where its encoding hides it, or it
    cannot be read a second time."""
    try:
        lines = as_utf8(read_whole(path)).decode("utf-8", "replace").splitlines()
    except (InputError, OSError):
        return None
    bare = (text.strip() for text in lines)
    return next(
        (n for n, t in enumerate(bare, 1) if t[:1] == "#" and t[1:].strip() == comment), None
    )


CONTROL_FORMAT = ControlFormat(
    to_translate("table of control points"),
    matches=lambda path: True,
    points=points_of,
    marks=marks_of,
    crs=crs_of,
    certain=False,
    extensions=TABLE_ENDINGS,
)
