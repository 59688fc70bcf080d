"""What is a place: the limits of coordinates, decided here for fields, tables, files and arrays.

A coordinate beyond them is a slip of the finger, a cell of another column or a value that stands
for "none"; kept, it would draw nothing, lose all digits of the others, or overflow.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.findings import Finding

FARTHEST_M = 1e12
"""Metres from the origin of any frame: its square, and that of a thousandth, are still exact
enough, and no frame on Earth reaches there, in millimetres either."""
FARTHEST_DIAMETERS = 10.0
"""How far from the box of a model a place on it may be asked for, in diagonals of that box."""


LEAST_ERROR, LARGEST_ERROR = 1e-6, 1e6
"""Of stated errors, one sigma, in metres or degrees: nobody measures better, or states worse. Their
squares and the inverses of these are still exact enough."""


def why_no_error(value: float) -> Finding | None:
    """Return a finding if a stated error (one sigma) is not plausible; None also if it is NaN."""
    if np.isnan(value) or LEAST_ERROR <= value <= LARGEST_ERROR:
        return None
    return Finding("accuracy.out-of-range", value=value, minimum=LEAST_ERROR, maximum=LARGEST_ERROR)


def no_places(points: FloatArray) -> BoolArray:
    """(n,) which of the points (n, 3) are not finite, or no metres on Earth."""
    return np.asarray(~(np.abs(points) <= FARTHEST_M).all(axis=1))


def why_no_coordinate(values: Iterable[float]) -> Finding | None:
    """Return a finding about the first number that cannot be a coordinate in metres, if any."""
    for value in values:
        if not abs(value) <= FARTHEST_M:
            return Finding("coordinate.out-of-range", value=value)
    return None


def why_not_at(point: Sequence[float], bounds: FloatArray) -> Finding | None:
    """Return a finding if a point is too far from a model to be a place on it.

    point : (3,) and bounds : (2, 3) lowest and highest corner of the model, in the same frame
    """
    if (finding := why_no_coordinate(point)) is not None:
        return finding
    low, high = np.asarray(bounds, float)
    size = float(np.linalg.norm(high - low))
    outside = np.maximum(np.maximum(low - point, np.asarray(point) - high), 0.0)
    away = float(np.linalg.norm(outside))
    if not np.isfinite(size) or away <= FARTHEST_DIAMETERS * size:
        return None
    return Finding("coordinate.far-from-model", times=away / max(size, 1e-300))


def why_not_on_earth(longitude_deg: float, latitude_deg: float) -> Finding | None:
    """Return a finding if these are not a longitude and a latitude."""
    if not abs(latitude_deg) <= 90.0:
        return Finding("coordinate.latitude", value=latitude_deg)
    if not abs(longitude_deg) <= 360.0:
        return Finding("coordinate.longitude", value=longitude_deg)
    return None
