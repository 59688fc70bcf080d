"""The orientation table: one row per plane or line, the same in files, JSON and the window.

`COLUMNS` is the contract. `plane_row` is the one place where a fit becomes a row; the window's
table, `fit`, and every export take their figures from it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.files.atomic import write_bytes
from vomstudio.geology.orientation import Line, Plane
from vomstudio.version import __version__

if TYPE_CHECKING:
    from vomstudio.geology.quality import Verdict
    from vomstudio.geometry.planes import PlaneFit

Row = dict[str, Any]
"""One value per column of `COLUMNS`: str, float, int, bool, or None where not applicable."""

COLUMNS: tuple[str, ...] = (
    "id", "name", "kind", "geometry", "set", "dip_direction_deg", "dip_deg", "strike_rhr_deg",
    "pole_trend_deg", "pole_plunge_deg", "trend_deg", "plunge_deg", "rake_deg", "overturned",
    "undefined", "x", "y", "z", "normal_x", "normal_y", "normal_z", "n_points", "extent_m",
    "area_m2", "rms_m", "lambda1", "lambda2", "lambda3", "coplanarity", "collinearity", "M", "K",
    "max_angular_error_deg", "min_angular_error_deg", "max_confidence95_deg",
    "min_confidence95_deg", "error_rake_deg", "dip_error_deg", "dip_direction_error_deg",
    "registration_error_deg", "total95_deg", "resolution_m", "extent_over_resolution", "quality",
    "quality_reason", "method", "model", "frame", "notes",
)  # fmt: skip

NOTATION = (
    "angles in degrees: azimuths clockwise from north, dip and plunge downward; strike by the "
    "right-hand rule (dip direction - 90); pole = downward normal; normal = upward"
)
UNITS = (
    "x east, y north, z up, extent, rms and resolution in metres, area in square metres; lambda1 "
    "to 3 sum to 1; confidence95 = semi-axes of the joint 95 % region; empty = not applicable"
)


def plane_row(
    fit: PlaneFit,
    verdict: Verdict,
    *,
    resolution_m: float | None = None,
    registration_error_deg: float | None = None,
    **metadata: Any,
) -> Row:
    """The row of a fitted plane.

    fit, verdict: in World. resolution_m: of the model around the points. registration_error_deg:
    95 % half-angle of the model's rotation, which is added to the fit's own in `total95_deg`.
    metadata: any other of `COLUMNS` (id, name, kind, set, overturned, area_m2, model, frame,
    notes). Raises TypeError for a name that is no column.
    """
    row = orientation_row(Plane.from_normal(fit.normal))
    extent = _number(fit.extent)
    total = None
    if registration_error_deg is not None and fit.max_confidence95_deg is not None:
        total = min(math.hypot(fit.max_confidence95_deg, registration_error_deg), 90.0)
    row.update(
        undefined=bool(fit.undefined),
        n_points=int(fit.n),
        extent_m=extent,
        rms_m=_number(fit.rms),
        coplanarity=_number(fit.coplanarity),
        collinearity=_number(fit.collinearity),
        M=_number(fit.M),
        K=_number(fit.K),
        max_angular_error_deg=_number(fit.max_angular_error_deg),
        min_angular_error_deg=_number(fit.min_angular_error_deg),
        max_confidence95_deg=_number(fit.max_confidence95_deg),
        min_confidence95_deg=_number(fit.min_confidence95_deg),
        error_rake_deg=_number(fit.error_rake_deg),
        dip_error_deg=_number(fit.dip_error_deg),
        dip_direction_error_deg=_number(fit.dip_direction_error_deg),
        registration_error_deg=_number(registration_error_deg),
        total95_deg=_number(total),
        resolution_m=_number(resolution_m),
        extent_over_resolution=extent / resolution_m if extent and resolution_m else None,
        quality=verdict.quality,
        quality_reason="; ".join(verdict.reasons),
        method=fit.method,
    )
    row.update(zip("xyz", (_number(c) for c in fit.centroid), strict=True))
    normal = [float(c) for c in fit.normal]
    row.update(zip(("normal_x", "normal_y", "normal_z"), normal, strict=True))
    lambdas = (_number(value) for value in fit.eigenvalues)
    row.update(zip(("lambda1", "lambda2", "lambda3"), lambdas, strict=True))
    return _with_metadata(row, metadata)


def orientation_row(plane: Plane, **metadata: Any) -> Row:
    """The row of a plane known by its attitude alone (a compass reading); metadata as in
    `plane_row`, x, y, z among them."""
    row = _empty_row()
    pole = plane.pole()
    row.update(
        geometry="plane",
        dip_direction_deg=plane.dip_direction_deg,
        dip_deg=plane.dip_deg,
        strike_rhr_deg=plane.strike_rhr_deg,
        pole_trend_deg=pole.trend_deg,
        pole_plunge_deg=pole.plunge_deg,
        undefined=plane.undefined,
    )
    normal = [float(c) for c in plane.normal()]
    row.update(zip(("normal_x", "normal_y", "normal_z"), normal, strict=True))
    return _with_metadata(row, metadata)


def line_row(line: Line, **metadata: Any) -> Row:
    """The row of a line; metadata as in `plane_row`, x, y, z and rake_deg among them."""
    row = _empty_row()
    row.update(
        geometry="line",
        trend_deg=line.trend_deg,
        plunge_deg=line.plunge_deg,
        undefined=line.undefined,
    )
    return _with_metadata(row, metadata)


def write_orientation_csv(
    path: str | Path,
    rows: Iterable[Mapping[str, Any]],
    *,
    crs: str | None = None,
    north: str | None = None,
    notes: Sequence[str] = (),
    force: bool = False,
) -> None:
    """Write rows as UTF-8 CSV, whole or not at all.

    crs: of x, y, z ("EPSG:32615"), None where none was declared. north: what azimuths count from.
    notes: further lines for the `#` block. Raises `TargetError`.
    """
    if north is None:
        north = "y axis of the coordinates as given" if crs is None else f"grid north of {crs}"
    head = [
        f"VOM Studio {__version__}, orientation table",
        f"CRS: {crs or 'none declared, coordinates as given'}",
        f"north: {north}",
        f"notation: {NOTATION}",
        f"units: {UNITS}",
        *notes,
    ]
    lines = [f"# {' '.join(text.split())}" for text in head]
    lines.append(",".join(COLUMNS))
    lines += [",".join(_csv_cell(row.get(name)) for name in COLUMNS) for row in rows]
    write_bytes(path, ("\n".join(lines) + "\n").encode("utf-8", "replace"), force=force)


def _empty_row() -> Row:
    return dict.fromkeys(COLUMNS)


def _with_metadata(row: Row, metadata: Mapping[str, Any]) -> Row:
    unknown = metadata.keys() - row.keys()
    if unknown:
        raise TypeError(f"not columns of the orientation table: {', '.join(sorted(unknown))}")
    row.update(metadata)
    return row


def _number(value: float | None) -> float | None:
    """None for what is undefined or infinite, as CSV and JSON want it."""
    return float(value) if value is not None and math.isfinite(value) else None


def _csv_cell(value: Any) -> str:
    match value:
        case None:
            return ""
        case bool() | np.bool_():
            return "true" if value else "false"
        case float() | np.floating():
            return f"{value:.12g}" if math.isfinite(value) else ""
        case int() | np.integer():
            return str(value)
    text = str(value)
    # A leading # would make the row a comment for whoever reads it.
    if text[:1] == "#" or any(mark in text for mark in ',"\n\r') or text != text.strip():
        return '"' + text.replace('"', '""') + '"'
    return text
