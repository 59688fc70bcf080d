"""Orientations and points of surfaces for GemPy and LoopStructural.

- GemPy 3 (`gempy.API.io_API`): orientations as X, Y, Z, azimuth (dip direction), dip, polarity (-1
  if overturned) and formation; points on surfaces as X, Y, Z, formation. `nugget` is the variance
  that GemPy adds to the gradient of an orientation. It follows from the half-angle of the 95 %
  region of the plane (2.45 standard deviations) or, if that is unknown, is GemPy's default of 0.01.
- LoopStructural (`GeologicalModel.data`): X, Y, Z, feature_name, and nx, ny, nz of the upward
  normal (downward for an overturned bed, that is, towards the younger side); points on surfaces by
  `interface`, one number for each surface of a feature.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from vomstudio.geometry.rotation_errors import CHI2_TWO
from vomstudio.io.exchange.columns import Row, delimited_text, round_angle
from vomstudio.io.gis.layers import Layer

UNKNOWN_NUGGET = 0.01
GEMPY_ORIENTATION_COLUMNS = ("X", "Y", "Z", "azimuth", "dip", "polarity", "formation", "nugget")
GEMPY_POINT_COLUMNS = ("X", "Y", "Z", "formation")
LOOPSTRUCTURAL_COLUMNS = ("X", "Y", "Z", "feature_name", "nx", "ny", "nz", "interface")


def surface_name(kind: object, set_name: object) -> str:
    """Return the name of a surface: the set of a feature, or else its type, or "surface"."""
    return str(set_name or kind or "surface")


def gempy_orientations(rows: Sequence[Row]) -> str:
    """Return the table of the planes that have a position."""
    return delimited_text(GEMPY_ORIENTATION_COLUMNS, [_gempy_row(row) for row in rows], ",")


def _gempy_row(row: Row) -> list[Any]:
    return [
        row["x"],
        row["y"],
        row["z"],
        round_angle(row["dip_direction_deg"]),
        round_angle(row["dip_deg"]),
        -1 if row["overturned"] else 1,
        surface_name(row["kind"], row["set"]),
        nugget(row),
    ]


def nugget(row: Row) -> float:
    """Return the variance of each component of a plane's unit normal.

    If the error of the plane is unknown, this is `UNKNOWN_NUGGET`.
    """
    error = row["total95_deg"]
    return UNKNOWN_NUGGET if error is None else math.radians(error) ** 2 / CHI2_TWO


def gempy_points(layers: Sequence[Layer]) -> str:
    """Return the table of the vertices of traces."""
    rows = [
        (*point.tolist(), surface_name(kind, set_name))
        for kind, set_name, points in _traces(layers)
        for point in points
    ]
    return delimited_text(GEMPY_POINT_COLUMNS, rows, ",")


def loopstructural_table(rows: Sequence[Row], layers: Sequence[Layer]) -> str:
    """Return the table of planes and of the vertices of traces.

    Planes have the components of their normals, and vertices the number of their surface.
    """
    out: list[list[Any]] = []
    for row in rows:
        sign = -1.0 if row["overturned"] else 1.0
        normal = [sign * row[f"normal_{axis}"] + 0.0 for axis in "xyz"]
        name = str(row["kind"] or "surface")
        out.append([row["x"], row["y"], row["z"], name, *normal, None])
    surface_ids: dict[tuple[str, str], int] = {}
    for kind, set_name, points in _traces(layers):
        surface = str(kind or "surface"), surface_name(kind, set_name)
        number = surface_ids.setdefault(surface, sum(key[0] == surface[0] for key in surface_ids))
        out += [[*point.tolist(), surface[0], None, None, None, number] for point in points]
    return delimited_text(LOOPSTRUCTURAL_COLUMNS, out, ",")


def _traces(layers: Sequence[Layer]) -> list[tuple[object, object, Any]]:
    """Return the type, set and vertices of each trace."""
    traces: list[tuple[object, object, Any]] = []
    for layer in layers:
        if layer.name != "traces":
            continue
        missing_cells = [None] * len(layer.shapes)
        kinds, sets = (layer.columns.get(name, missing_cells) for name in ("kind", "set"))
        traces += list(zip(kinds, sets, layer.shapes, strict=True))
    return traces
