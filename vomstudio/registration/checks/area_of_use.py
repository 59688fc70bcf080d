"""Whether coordinates lie in the area that a CRS is made for."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray

# Systems of coordinates are used this far beyond their area without harm, degrees.
BEYOND_DEG = 1.0


def inside_area(world: FloatArray, crs: str | None) -> BoolArray:
    """(n,) which of the coordinates (n, 3) lie in the area of a CRS; none of them without one."""
    beyond = degrees_beyond(crs)
    if beyond is None:
        return np.zeros(len(world), bool)
    return np.array([beyond(x, y)[0] <= BEYOND_DEG for x, y in world[:, :2].tolist()], bool)


def degrees_beyond(crs: str | None) -> Callable[[float, float], tuple[float, float, float]] | None:
    """What tells how many degrees x and y lie outside of the area of a CRS, and their longitude and
    latitude; None where it has none."""
    from pyproj import CRS, Transformer

    area = None if crs is None else CRS.from_user_input(crs).area_of_use
    if crs is None or area is None:
        return None
    to_degrees = Transformer.from_crs(crs, "EPSG:4326", always_xy=True)
    west, south, east, north = area.bounds

    def beyond(x: float, y: float) -> tuple[float, float, float]:
        longitude, latitude = to_degrees.transform(x, y)[:2]
        if not np.isfinite([longitude, latitude]).all():
            return np.inf, np.nan, np.nan
        width = (east - west) % 360.0 or 360.0
        along = (longitude - west) % 360.0
        side = 0.0 if along <= width else min(along - width, 360.0 - along)
        return max(side, south - latitude, latitude - north, 0.0), longitude, latitude

    return beyond
