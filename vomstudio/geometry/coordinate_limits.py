"""Limits of coordinates for fields, tables, files and arrays.

A coordinate beyond these limits is a typing error, a value from another column or a placeholder for
a missing value. It would hide the model, lose the digits of other coordinates, or overflow.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.findings import Finding

MAX_COORDINATE_M = 1e12
"""Maximum distance from the origin of any frame, m. The squares of this value and of its thousandth
are still accurate, and no frame on Earth extends this far, even in millimetres.
"""
MAX_DISTANCE_DIAMETERS = 10.0
"""Maximum distance of a point from the bounding box of its model, in diagonals of the box."""


MIN_ERROR, MAX_ERROR = 1e-6, 1e6
"""Limits of stated errors, one sigma, in metres or degrees. Their squares and inverse squares are
still accurate.
"""


def check_error(value: float) -> Finding | None:
    """Return a finding if a stated one-sigma error is implausible and not NaN.

    Parameters
    ----------
    value : float
        One-sigma error, metres or degrees.

    Returns
    -------
    Finding or None
    """
    if np.isnan(value) or MIN_ERROR <= value <= MAX_ERROR:
        return None
    return Finding("accuracy.out-of-range", value=value, minimum=MIN_ERROR, maximum=MAX_ERROR)


def find_invalid_points(points: FloatArray) -> BoolArray:
    """Find points with a coordinate that is not finite or exceeds `MAX_COORDINATE_M`.

    Parameters
    ----------
    points : (n, 3) ndarray

    Returns
    -------
    (n,) ndarray of bool
        True for invalid points.
    """
    return np.asarray(~(np.abs(points) <= MAX_COORDINATE_M).all(axis=1))


def check_coordinates(values: Iterable[float]) -> Finding | None:
    """Return a finding about the first number that cannot be a coordinate in metres, if any.

    Parameters
    ----------
    values : iterable of float
        Metres.

    Returns
    -------
    Finding or None
    """
    for value in values:
        if not abs(value) <= MAX_COORDINATE_M:
            return Finding("coordinate.out-of-range", value=value)
    return None


def check_near_model(point: Sequence[float], bounds: FloatArray) -> Finding | None:
    """Return a finding if a point is too far from a model to lie on it.

    Parameters
    ----------
    point : (3,) sequence of float
    bounds : (2, 3) ndarray
        Minimum and maximum corners of the model in the frame of the point.

    Returns
    -------
    Finding or None
    """
    if (finding := check_coordinates(point)) is not None:
        return finding
    low, high = np.asarray(bounds, float)
    size = float(np.linalg.norm(high - low))
    distances = np.maximum(np.maximum(low - point, np.asarray(point) - high), 0.0)
    distance = float(np.linalg.norm(distances))
    if not np.isfinite(size) or distance <= MAX_DISTANCE_DIAMETERS * size:
        return None
    return Finding("coordinate.far-from-model", times=distance / max(size, 1e-300))


def check_longitude_latitude(longitude_deg: float, latitude_deg: float) -> Finding | None:
    """Return a finding if a longitude or latitude is out of range.

    Parameters
    ----------
    longitude_deg, latitude_deg : float

    Returns
    -------
    Finding or None
    """
    if not abs(latitude_deg) <= 90.0:
        return Finding("coordinate.latitude", value=latitude_deg)
    if not abs(longitude_deg) <= 360.0:
        return Finding("coordinate.longitude", value=longitude_deg)
    return None
