"""Check that lengths in a coordinate reference system match lengths on the ground.

A map projection scales distances but not heights. If the scale differs from 1 by more than
`MAX_SCALE_ERROR`, dips and lengths are wrong: in Web Mercator at 46 degrees north, a bed that dips
30 degrees appears to dip 21.9 degrees.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.io.gis.crs import crs_name, utm_zone

MAX_SCALE_ERROR = 0.005
"""Maximum relative deviation of the point scale from 1 and between two directions."""
_UTM_ZONE = re.compile(r"EPSG:32([67])(0[1-9]|[1-5]\d|60)")
_UTM_SCALE = 0.9996
_EARTH_RADIUS_M = 6_371_000.0
_AREA_TOLERANCE_DEG = 0.1


@dataclass(frozen=True)
class MapScale:
    """Point scale of a projection at the location of some data.

    Parameters
    ----------
    scale : float
        Length on the map divided by length on the ground, in the direction and at the location
        where it differs most from 1.
    anisotropy : float
        Largest scale divided by smallest scale at the same location, minus 1.
    is_in_area : bool
        Whether the data are within the area of use of the CRS.
    suggested_crs : str
        ``EPSG:n`` of the UTM zone (WGS 84) that contains the data.
    """

    scale: float
    anisotropy: float
    is_in_area: bool
    suggested_crs: str

    @property
    def is_metric(self) -> bool:
        """Whether map lengths equal lengths on the ground within `MAX_SCALE_ERROR`."""
        return abs(self.scale - 1.0) <= MAX_SCALE_ERROR and self.anisotropy <= MAX_SCALE_ERROR


def map_scale(crs: str, bounds: FloatArray) -> MapScale | None:
    """Compute the point scale of a projected CRS at the location of some data.

    Parameters
    ----------
    crs : str
        Code, name or WKT.
    bounds : (2, 2) or (2, 3) float
        Minimum and maximum x, y of the data, in the unit of the CRS.

    Returns
    -------
    MapScale or None
        Point scale, or None if the projection is not defined at the data.

    References
    ----------
    Snyder, J. P. (1987), Map projections: a working manual, USGS Professional Paper 1395, p. 20
    (Tissot's indicatrix); computed by PROJ.
    """
    from pyproj import CRS, Proj
    from pyproj.exceptions import ProjError

    system = CRS.from_user_input(crs)
    horizontal_crs = system.sub_crs_list[0] if system.is_compound else system
    horizontal_crs = (
        horizontal_crs.source_crs
        if horizontal_crs.is_bound and horizontal_crs.source_crs is not None
        else horizontal_crs
    )
    projection = Proj(horizontal_crs)
    x, y = _sample_positions(bounds)
    try:
        longitude, latitude = projection(x, y, inverse=True, errcheck=True)
        factors = projection.get_factors(longitude, latitude, errcheck=True)
    except ProjError:
        return None
    largest_scales = np.atleast_1d(factors.tissot_semimajor)
    smallest_scales = np.atleast_1d(factors.tissot_semiminor)
    if not (
        np.isfinite(largest_scales).all()
        and np.isfinite(smallest_scales).all()
        and (smallest_scales > 0).all()
    ):
        return None
    scales = np.concatenate([largest_scales, smallest_scales])
    worst_scale = float(scales[np.argmax(np.abs(scales - 1.0))])
    centre = float(longitude[-1]), float(latitude[-1])
    return MapScale(
        scale=worst_scale,
        anisotropy=float((largest_scales / smallest_scales).max() - 1.0),
        is_in_area=_is_in_area(horizontal_crs.area_of_use, longitude, latitude),
        suggested_crs=utm_zone(*centre),
    )


def check_metric(
    crs: str, bounds: FloatArray, *, file: str | Path | None = None, field: str = "CRS"
) -> tuple[Finding, ...]:
    """Check that a projected CRS is metric at the location of some data.

    Parameters
    ----------
    crs : str
        Code, name or WKT of a projected CRS.
    bounds : (2, 2) or (2, 3) float
        Minimum and maximum x, y of the data, in the unit of the CRS.
    file, field : optional
        File of the data, and option or column that specifies the CRS, for error messages.

    Returns
    -------
    tuple of Finding
        ``frame.outside-area`` if the data are outside the area of use of the CRS; empty if the
        bounds are not finite.

    Raises
    ------
    InputError
        With the code ``frame.not-metric`` if lengths differ from those on the ground, or vary with
        direction, by more than `MAX_SCALE_ERROR`; with ``frame.undefined-place`` if the projection
        is not defined at the data; with ``frame.swapped-axes`` if the CRS would be metric after
        swapping x and y.
    """
    bounds = np.asarray(bounds, np.float64)[:, :2]
    if not np.isfinite(bounds).all() or _is_inside_utm_zone(crs, bounds):
        return ()
    scale = map_scale(crs, bounds)
    if scale is None or not (scale.is_metric or scale.is_in_area):
        swapped_scale = map_scale(crs, bounds[:, ::-1])
        if swapped_scale is not None and swapped_scale.is_metric and swapped_scale.is_in_area:
            raise InputError(
                Finding("frame.swapped-axes", crs=crs_name(crs)), file=file, field="x, y"
            )
    if scale is None:
        raise InputError(
            Finding("frame.undefined-place", crs=crs_name(crs)), file=file, field=field
        )
    values = {
        "crs": crs_name(crs),
        "scale": scale.scale,
        "anisotropy": scale.anisotropy,
        "suggested_crs": scale.suggested_crs,
    }
    if not scale.is_metric:
        raise InputError(
            Finding("frame.not-metric", **values),
            file=file,
            field=field,
        )
    return () if scale.is_in_area else (Finding("frame.outside-area", **values),)


def degrees_finding(bounds: FloatArray) -> Finding | None:
    """Return ``frame.maybe-degrees`` if x and y may be longitude and latitude, or None.

    Parameters
    ----------
    bounds : (2, 3) float
        Lower-left and upper-right corners of data without a CRS.
    """
    low, high = np.asarray(bounds, np.float64)
    if not (np.isfinite(low).all() and np.isfinite(high).all()):
        return None
    span, height = float(np.hypot(*(high - low)[:2])), float(high[2] - low[2])
    is_in_range = max(abs(low[0]), abs(high[0])) <= 180.0 and max(abs(low[1]), abs(high[1])) <= 90.0
    if not is_in_range or height <= 0.0 or span * 100.0 >= height:
        return None
    return Finding("frame.maybe-degrees", span=span, height=height)


def _sample_positions(bounds: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return x and y of the corners, of the midpoints of the edges and finally of the centre."""
    (x0, y0), (x1, y1) = np.asarray(bounds, np.float64)[:, :2]
    xm, ym = (x0 + x1) / 2.0, (y0 + y1) / 2.0
    x = np.array([x0, x0, x1, x1, x0, x1, xm, xm, xm])
    y = np.array([y0, y1, y0, y1, ym, ym, y0, y1, ym])
    return x, y


def _is_in_area(area: object, longitude: FloatArray, latitude: FloatArray) -> bool:
    if area is None:
        return True
    west, south, east, north = area.bounds  # type: ignore[attr-defined]
    tolerance = _AREA_TOLERANCE_DEG
    is_inside = (latitude >= south - tolerance) & (latitude <= north + tolerance)
    if west <= east:
        is_inside &= (longitude >= west - tolerance) & (longitude <= east + tolerance)
    else:  # across the date line
        is_inside &= (longitude >= west - tolerance) | (longitude <= east + tolerance)
    return bool(is_inside.all())


def _is_inside_utm_zone(crs: str, bounds: FloatArray) -> bool:
    """Return whether data in a WGS 84 UTM zone are certainly within that zone.

    The check avoids importing PROJ, which would delay the first display of a model.
    """
    if (zone := _UTM_ZONE.fullmatch(crs)) is None:
        return False
    (x0, y0), (x1, y1) = bounds
    if zone[1] == "7":
        y0, y1 = 1e7 - y1, 1e7 - y0
    if y0 < 0.0 or y1 > 9.3e6:
        return False
    latitude = y1 / _UTM_SCALE / _EARTH_RADIUS_M
    half_width = math.radians(2.9) * math.cos(latitude) * _EARTH_RADIUS_M
    return bool(max(abs(x0 - 5e5), abs(x1 - 5e5)) <= half_width)
