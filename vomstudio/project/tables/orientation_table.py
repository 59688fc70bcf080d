"""Orientation table: one row per plane or line, as in files, JSON and the window.

`COLUMNS` defines the public format. The values are the figures of the project's catalogue, which
the table of the window, `fit` and every export use as well.
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
from vomstudio.geometry.units import WORLD_AXES, Axes
from vomstudio.project import catalogue
from vomstudio.project.figures import Figure, Subject, cache_normal_covariances
from vomstudio.project.measurement import Measurement, fit_fields

if TYPE_CHECKING:
    from vomstudio.core.arrays import FloatArray
    from vomstudio.geology.profiles import Thresholds
    from vomstudio.geology.quality import Kind as JudgedAs
    from vomstudio.geology.quality import Verdict
    from vomstudio.geometry.planes import FittedPlane

Row = dict[str, Any]
"""One value per column in `COLUMNS`: str, float, int, bool, or None if not applicable."""

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


_PLANE_FIGURES = (*catalogue.PLANE, *catalogue.PLACE, *catalogue.FIT_FIGURES, *catalogue.VERDICT)
BATCH_ROWS = 256
"""Rows per batch. Small batches stay in the processor cache while their columns are converted,
which halves the time compared with 50,000 rows at once."""
_NUMBER_TYPES = {float, NoneType}
_TEXT_TYPES = {str, NoneType}
_PLAIN_TYPES = {str, bool, int, NoneType}


def create_row(subject: Subject, figures: Iterable[Figure]) -> Row:
    """Return a row with the figures of the subject that have a column, and None elsewhere."""
    row: Row = dict.fromkeys(COLUMNS)
    for name, value in _table_figures(tuple(figures)):
        row[name] = to_python_value(value(subject))
    return row


def build_rows(subjects: Sequence[Subject], figures: Iterable[Figure]) -> list[Row]:
    """Return `create_row` for subjects with the same figures, five times faster by columns."""
    rows: list[Row] = []
    table_figures = _table_figures(figures := tuple(figures))
    has_covariances = not set(figures).isdisjoint(catalogue.NORMAL_COVARIANCE)
    for start in range(0, len(subjects), BATCH_ROWS):
        batch = subjects[start : start + BATCH_ROWS]
        if has_covariances:
            cache_normal_covariances(batch)
        columns: dict[str, list[Any]] = dict.fromkeys(COLUMNS, [None] * len(batch))
        for name, value in table_figures:
            columns[name] = _plain_column([value(subject) for subject in batch])
        values_of_rows = zip(*columns.values(), strict=True)
        rows += [dict(zip(COLUMNS, values, strict=True)) for values in values_of_rows]
    return rows


@lru_cache(maxsize=64)
def _table_figures(figures: tuple[Figure, ...]) -> list[tuple[str, Callable[[Subject], Any]]]:
    return [(figure.name, figure.value) for figure in figures if figure.name in _NAMES]


def plane_row(
    fit: FittedPlane,
    verdict: Verdict,
    *,
    resolution_m: float | None = None,
    registration_error_deg: float | None = None,
    stretch_error_deg: float | None = None,
    plane: Plane | None = None,
    verdict_kind: JudgedAs = "trace",
    outcrop_normal: FloatArray | None = None,
    bend_deg: float | None = None,
    **metadata: Any,
) -> Row:
    """Return the row of a fitted plane.

    Parameters
    ----------
    fit, verdict : FittedPlane, Verdict
        Fit and verdict in the World frame.
    resolution_m : float or None
        Resolution of the model around the points.
    registration_error_deg : float or None
        95 % half-angle of the rotation of the model, which is added to the errors of fit and
        resolution in `total95_deg`.
    stretch_error_deg : float or None
        95 % half-angle due to doubtful stretches, which is a lower bound of the total error.
    plane : Plane or None
        Attitude of the fit if it is already known.
    verdict_kind, outcrop_normal, bend_deg
        Inputs of the verdict.
    **metadata
        Other columns (id, name, kind, set, overturned, area_m2, model, frame, notes).

    Raises
    ------
    TypeError
        If a name is not a column.
    """
    fields = fit_fields(fit, plane)
    fields["registration_error_deg"] = registration_error_deg
    fields["stretch_error_deg"] = stretch_error_deg
    measurement = Measurement(
        np.zeros((0, 3)),
        resolution_m,
        outcrop_normal,
        fit,
        verdict,
        None,
        verdict_kind=verdict_kind,
        bend_deg=bend_deg,
        **fields,
    )
    return _add_metadata(_detached_row(measurement, *_PLANE_FIGURES), metadata)


def plane_rows(
    fits: Sequence[FittedPlane],
    verdicts: Sequence[Verdict],
    planes: Sequence[Plane],
    *,
    resolution_m: float | None,
) -> list[Row]:
    """Return `plane_row` for many fits, several times faster.

    Parameters
    ----------
    fits, verdicts : sequence of FittedPlane, sequence of Verdict
        Fits and verdicts in the World frame.
    planes : sequence of Plane
        Attitudes of the fits.
    resolution_m : float or None
        Resolution of the model around the points.

    Returns
    -------
    list of Row
    """
    no_points = np.zeros((0, 3))
    measurements = (
        Measurement(no_points, resolution_m, None, fit, verdict, None, **fit_fields(fit, plane))
        for fit, verdict, plane in zip(fits, verdicts, planes, strict=True)
    )
    return build_rows([Subject(None, measurement) for measurement in measurements], _PLANE_FIGURES)


def orientation_row(plane: Plane, **metadata: Any) -> Row:
    """Return the row of a plane for which only the attitude is known (a compass reading).

    The metadata are the same as for `plane_row`, plus x, y, z.
    """
    measurement = Measurement(np.zeros((0, 3)), None, None, None, None, None, plane=plane)
    return _add_metadata(_detached_row(measurement, *catalogue.PLANE), metadata)


def line_row(line: Line, **metadata: Any) -> Row:
    """Return the row of a line; metadata as for `plane_row`, plus x, y, z and rake_deg."""
    measurement = Measurement(np.zeros((0, 3)), None, None, None, None, None, line=line)
    return _add_metadata(_detached_row(measurement, *catalogue.LINE), metadata)


def _detached_row(measurement: Measurement, *figures: Figure) -> Row:
    """Return the row of a measurement that does not belong to a feature."""
    return create_row(Subject(None, measurement), figures)


def write_orientation_csv(
    path: str | Path,
    rows: Iterable[Mapping[str, Any]],
    *,
    crs: str | None = None,
    north: str | None = None,
    notes: Sequence[str] = (),
    axes: Axes = WORLD_AXES,
    limits: Thresholds | None = None,
    extra_columns: Sequence[str] = (),
    force: bool = False,
) -> None:
    """Write rows as UTF-8 CSV, completely or not at all.

    Parameters
    ----------
    path : str or Path
    rows : iterable of mapping
    crs : str or None
        CRS of x, y, z ("EPSG:32615"), or None if none was declared.
    north : str or None
        North reference of the azimuths.
    notes : sequence of str
        Additional lines for the `#` comment block.
    axes : Axes
        Axes of x, y, z.
    limits : Thresholds or None
        Thresholds with which the rows were judged, or None if no row has a verdict.
    extra_columns : sequence of str
        Names of additional columns after `COLUMNS`.
    force : bool, optional
        Whether to replace existing files.

    Raises
    ------
    TargetError
        If the file cannot be written.
    """
    if north is None:
        north = "y axis of the coordinates as given" if crs is None else f"grid north of {crs}"
    header = [
        f"VOM Studio {__version__}, orientation table",
        f"CRS: {crs or 'none declared, coordinates as given'}",
        f"north: {north}",
        f"notation: {NOTATION}",
        f"units: {UNITS.format(axes=axes.description, unit=axes.unit)}",
        *([] if limits is None else [f"profile: {limits.description}"]),
        *notes,
    ]
    lines = [comment_line(text).rstrip("\n") for text in header]
    names = (*COLUMNS, *extra_columns)
    lines.append(",".join(names))
    remaining_rows = iter(rows)
    while batch := list(islice(remaining_rows, BATCH_ROWS)):
        columns = map(_csv_column, _to_columns(batch, names))
        lines += map(",".join, zip(*columns, strict=True))
    write_bytes(path, ("\n".join(lines) + "\n").encode("utf-8", "replace"), force=force)


def _to_columns(rows: Sequence[Mapping[str, Any]], names: Sequence[str]) -> Iterable[Sequence[Any]]:
    try:
        return zip(*map(itemgetter(*names), rows), strict=True)
    except KeyError:
        # A row may contain only a part of the columns.
        return ([row.get(name) for row in rows] for name in names)


def _add_metadata(row: Row, metadata: Mapping[str, Any]) -> Row:
    unknown_keys = metadata.keys() - row.keys()
    if unknown_keys:
        raise TypeError(f"not columns of the orientation table: {', '.join(sorted(unknown_keys))}")
    row.update(metadata)
    return row


def to_python_value(value: Any) -> Any:
    """Return a value as a Python object, or None if it is undefined or infinite.

    CSV and JSON use the same rule.
    """
    if type(value) is float:
        return value if math.isfinite(value) else None
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    return int(value) if isinstance(value, np.integer) else value


def _plain_column(values: list[Any]) -> list[Any]:
    """Return `to_python_value` of each value; fast for columns of a single type."""
    classes = set(map(type, values))
    if classes <= _PLAIN_TYPES:
        return values
    if classes <= _NUMBER_TYPES:
        return [value if value is None or math.isfinite(value) else None for value in values]
    return [to_python_value(value) for value in values]


def _csv_column(values: Sequence[Any]) -> list[str]:
    """Return `csv_cell` of each value; fast for columns of one type and repeated words."""
    classes = set(map(type, values))
    if classes == {float} and all(map(math.isfinite, values)):
        # Formatting all values together is 1.5 times as fast.
        return ("%.12g\n" * len(values) % tuple(values)).splitlines()
    if classes <= _NUMBER_TYPES:
        return [
            "" if value is None or not math.isfinite(value) else f"{value:.12g}" for value in values
        ]
    if classes <= _TEXT_TYPES:
        cells = {value: csv_cell(value) for value in set(values)}
        return [cells[value] for value in values]
    return [csv_cell(value) for value in values]


def csv_cell(value: Any) -> str:
    """Format a value as a CSV cell."""
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


_QUOTED_CHARACTERS = re.compile(r'[,"\n\r]')


def csv_text(text: str) -> str:
    """Escape and quote a text as a CSV cell."""
    text = escape_formula(text)
    # A leading # would turn the row into a comment.
    if text[:1] == "#" or _QUOTED_CHARACTERS.search(text) or text != text.strip():
        return '"' + text.replace('"', '""') + '"'
    return text
