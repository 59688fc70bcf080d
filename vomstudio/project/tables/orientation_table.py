"""The orientation table: one row per plane or line, the same in files, JSON and the window.

`COLUMNS` is the contract; what stands in them are the figures of the document's catalogue, from
which the window's table, `fit`, and every export take theirs.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache
from itertools import islice
from operator import itemgetter
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.files.atomic import write_bytes
from vomstudio.core.files.spreadsheet_cells import comment_line, escape_formula
from vomstudio.core.version import __version__
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geometry.units import WORLD, Axes
from vomstudio.project import catalogue
from vomstudio.project.figures import Figure, Subject
from vomstudio.project.measurement import Measurement, of_fit

if TYPE_CHECKING:
    from vomstudio.core.arrays import FloatArray
    from vomstudio.geology.profiles import Thresholds
    from vomstudio.geology.quality import Kind as JudgedAs
    from vomstudio.geology.quality import Verdict
    from vomstudio.geometry.planes import PlaneFit

Row = dict[str, Any]
"""One value per column of `COLUMNS`: str, float, int, bool, or None where not applicable."""

COLUMNS: tuple[str, ...] = tuple(figure.name for figure in catalogue.ORIENTATION)
_NAMES = frozenset(COLUMNS)

NOTATION = (
    "angles in degrees: azimuths clockwise from north, dip and plunge downward; strike by the "
    "right-hand rule (dip direction - 90); pole = downward normal; normal = upward"
)
UNITS = (
    "{axes}; extent, rms and resolution in {unit}, area in square {unit}; lambda1 to 3 sum to 1; "
    "confidence95 = semi-axes of the joint 95 % region; empty = not applicable"
)


_PORTION = 256
"""So many rows are made and written at a time: what they hold stays near the processor while one
column after the other goes through it, which of 50,000 at once took twice as long."""
_NUMBERS = {float, NoneType}
_WORDS = {str, NoneType}
_AS_THEY_ARE = {str, bool, int, NoneType}


def row_of(subject: Subject, figures: Iterable[Figure]) -> Row:
    """Those of a subject's figures that have a column; the other columns are empty."""
    row: Row = dict.fromkeys(COLUMNS)
    for name, value in _with_column(tuple(figures)):
        row[name] = plain(value(subject))
    return row


def rows_of(subjects: Sequence[Subject], figures: Iterable[Figure]) -> list[Row]:
    """`row_of` of many subjects with the same figures, in a fifth of the time: column by column."""
    rows: list[Row] = []
    wanted = _with_column(tuple(figures))
    for first in range(0, len(subjects), _PORTION):
        portion = subjects[first : first + _PORTION]
        columns: dict[str, list[Any]] = dict.fromkeys(COLUMNS, [None] * len(portion))
        for name, value in wanted:
            columns[name] = _plain_column([value(subject) for subject in portion])
        each = zip(*columns.values(), strict=True)
        rows += [dict(zip(COLUMNS, values, strict=True)) for values in each]
    return rows


@lru_cache(maxsize=64)
def _with_column(figures: tuple[Figure, ...]) -> list[tuple[str, Callable[[Subject], Any]]]:
    return [(figure.name, figure.value) for figure in figures if figure.name in _NAMES]


def plane_row(
    fit: PlaneFit,
    verdict: Verdict,
    *,
    resolution_m: float | None = None,
    registration_error_deg: float | None = None,
    stretch_error_deg: float | None = None,
    plane: Plane | None = None,
    judged_as: JudgedAs = "trace",
    outcrop_normal: FloatArray | None = None,
    bend_deg: float | None = None,
    **metadata: Any,
) -> Row:
    """The row of a fitted plane.

    fit, verdict: in World. resolution_m: of the model around the points. registration_error_deg:
    95 % half-angle of the model's rotation, which is added to that of fit and resolution in
    `total95_deg`. stretch_error_deg: 95 % half-angle in view of doubtful stretches, below which
    that is not. plane: the fit's attitude where it is known already. judged_as, outcrop_normal,
    bend_deg: as the verdict was given.
    metadata: any other of `COLUMNS` (id, name, kind, set, overturned, area_m2, model, frame,
    notes). Raises TypeError for a name that is no column.
    """
    own = of_fit(fit, plane)
    own["registration_error_deg"] = registration_error_deg
    own["stretch_error_deg"] = stretch_error_deg
    measured = Measurement(
        np.zeros((0, 3)),
        resolution_m,
        outcrop_normal,
        fit,
        verdict,
        None,
        judged_as=judged_as,
        bend_deg=bend_deg,
        **own,
    )
    row = _bare(measured, *catalogue.PLANE, *catalogue.PLACE, *catalogue.FITTED, *catalogue.VERDICT)
    return _with_metadata(row, metadata)


def orientation_row(plane: Plane, **metadata: Any) -> Row:
    """The row of a plane known by its attitude alone (a compass reading); metadata as in
    `plane_row`, x, y, z among them."""
    measured = Measurement(np.zeros((0, 3)), None, None, None, None, None, plane=plane)
    return _with_metadata(_bare(measured, *catalogue.PLANE), metadata)


def line_row(line: Line, **metadata: Any) -> Row:
    """The row of a line; metadata as in `plane_row`, x, y, z and rake_deg among them."""
    measured = Measurement(np.zeros((0, 3)), None, None, None, None, None, line=line)
    return _with_metadata(_bare(measured, *catalogue.LINE), metadata)


def _bare(measured: Measurement, *figures: Figure) -> Row:
    """Of something that is no feature of a document."""
    return row_of(Subject(None, measured), figures)


def write_orientation_csv(
    path: str | Path,
    rows: Iterable[Mapping[str, Any]],
    *,
    crs: str | None = None,
    north: str | None = None,
    notes: Sequence[str] = (),
    axes: Axes = WORLD,
    limits: Thresholds | None = None,
    more: Sequence[str] = (),
    force: bool = False,
) -> None:
    """Write rows as UTF-8 CSV, whole or not at all.

    crs: of x, y, z ("EPSG:32615"), None where none was declared. north: what azimuths count from.
    notes: further lines for the `#` block. axes: what is known of x, y, z. limits: by
    which the rows were judged, None where none has a verdict. more: names of columns that follow.
    Raises `TargetError`.
    """
    if north is None:
        north = "y axis of the coordinates as given" if crs is None else f"grid north of {crs}"
    head = [
        f"VOM Studio {__version__}, orientation table",
        f"CRS: {crs or 'none declared, coordinates as given'}",
        f"north: {north}",
        f"notation: {NOTATION}",
        f"units: {UNITS.format(axes=axes.description, unit=axes.unit)}",
        *([] if limits is None else [f"profile: {limits.description}"]),
        *notes,
    ]
    lines = [comment_line(text).rstrip("\n") for text in head]
    names = (*COLUMNS, *more)
    lines.append(",".join(names))
    rest = iter(rows)
    while portion := list(islice(rest, _PORTION)):
        columns = map(_csv_column, _columns_of(portion, names))
        lines += map(",".join, zip(*columns, strict=True))
    write_bytes(path, ("\n".join(lines) + "\n").encode("utf-8", "replace"), force=force)


def _columns_of(rows: Sequence[Mapping[str, Any]], names: Sequence[str]) -> Iterable[Sequence[Any]]:
    try:
        return zip(*map(itemgetter(*names), rows), strict=True)
    except KeyError:
        # A row that holds only what it knows.
        return ([row.get(name) for row in rows] for name in names)


def _with_metadata(row: Row, metadata: Mapping[str, Any]) -> Row:
    unknown = metadata.keys() - row.keys()
    if unknown:
        raise TypeError(f"not columns of the orientation table: {', '.join(sorted(unknown))}")
    row.update(metadata)
    return row


def plain(value: Any) -> Any:
    """None for what is undefined or infinite, as CSV and JSON want it."""
    if type(value) is float:
        return value if math.isfinite(value) else None
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    return int(value) if isinstance(value, np.integer) else value


def _plain_column(values: list[Any]) -> list[Any]:
    """`plain` of each, where most of them are what they should be."""
    classes = set(map(type, values))
    if classes <= _AS_THEY_ARE:
        return values
    if classes <= _NUMBERS:
        return [v if v is None or math.isfinite(v) else None for v in values]
    return [plain(value) for value in values]


def _csv_column(values: Sequence[Any]) -> list[str]:
    """`csv_cell` of each. The cells of a column are mostly of one class, and words come again."""
    classes = set(map(type, values))
    if classes == {float} and all(map(math.isfinite, values)):
        # Formatted together: each alone takes half as long again.
        return ("%.12g\n" * len(values) % tuple(values)).splitlines()
    if classes <= _NUMBERS:
        return ["" if v is None or not math.isfinite(v) else f"{v:.12g}" for v in values]
    if classes <= _WORDS:
        known = {value: csv_cell(value) for value in set(values)}
        return [known[value] for value in values]
    return [csv_cell(value) for value in values]


def csv_cell(value: Any) -> str:
    if value is None:
        return ""
    match value:
        case bool() | np.bool_():
            return "true" if value else "false"
        case float() | np.floating():
            return f"{value:.12g}" if math.isfinite(value) else ""
        case int() | np.integer():
            return str(value)
    return csv_text(str(value))


_QUOTED = re.compile(r'[,"\n\r]')


def csv_text(text: str) -> str:
    text = escape_formula(text)
    # A leading # would make the row a comment for whoever reads it.
    if text[:1] == "#" or _QUOTED.search(text) or text != text.strip():
        return '"' + text.replace('"', '""') + '"'
    return text
