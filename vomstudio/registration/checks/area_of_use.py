"""Check whether coordinates lie in the area of use of a CRS."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray

# Tolerated distance beyond the area of use.
AREA_TOLERANCE_DEG = 1.0


def is_inside_area(world: FloatArray, crs: str | None) -> BoolArray:
    """Find the coordinates inside the area of use of a CRS.

    Parameters
    ----------
    world : (n, 3) ndarray
    crs : str or None

    Returns
    -------
    (n,) ndarray of bool
        All False if `crs` is None or has no area of use.
    """
    distance_to_area = area_distance_function(crs)
    if distance_to_area is None:
        return np.zeros(len(world), bool)
    return np.array(
        [distance_to_area(x, y)[0] <= AREA_TOLERANCE_DEG for x, y in world[:, :2].tolist()], bool
    )


def area_distance_function(
    crs: str | None,
) -> Callable[[float, float], tuple[float, float, float]] | None:
    """Return a function for the distance beyond the area of use of a CRS.

    Parameters
    ----------
    crs : str or None

    Returns
    -------
    callable or None
        Function that returns the distance, the longitude and the latitude of a position x, y, all
        in degrees. None if the CRS has no area.
    """
    from pyproj import CRS, Transformer

    area = None if crs is None else CRS.from_user_input(crs).area_of_use
    if crs is None or area is None:
        return None
    to_degrees = Transformer.from_crs(crs, "EPSG:4326", always_xy=True)
    west, south, east, north = area.bounds

    def distance_to_area(x: float, y: float) -> tuple[float, float, float]:
        longitude, latitude = to_degrees.transform(x, y)[:2]
        if not np.isfinite([longitude, latitude]).all():
            return np.inf, np.nan, np.nan
        width = (east - west) % 360.0 or 360.0
        degrees_east = (longitude - west) % 360.0
        longitude_offset_deg = (
            0.0 if degrees_east <= width else min(degrees_east - width, 360.0 - degrees_east)
        )
        return (
            max(longitude_offset_deg, south - latitude, latitude - north, 0.0),
            longitude,
            latitude,
        )

    return distance_to_area
