"""Parsing and properties of coordinate reference systems."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import lru_cache
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.files.regular import read_small_file
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.gis.axis_units import stated_axes
from vomstudio.io.text.encodings import convert_to_utf8

if TYPE_CHECKING:
    import numpy.typing as npt

    from vomstudio.core.arrays import FloatArray

_MAX_BYTES = 100_000

_WGS_84_UTM = re.compile(r"EPSG:32[67](0[1-9]|[1-5]\d|60)")
_UTM = re.compile(
    r"(?:wgs[ _]?84\s*/?\s*)?utm(?:[ _-]?zone)?"
    r"[ _-]?(?P<number>0?[1-9]|[1-5]\d|60)\s?(?P<half>[ns])",
    re.IGNORECASE,
)


def parse_crs(text: str) -> tuple[str, float]:
    """Parse a projected CRS entered by a user.

    Parameters
    ----------
    text : str
        Text such as "32633", "EPSG:32633", "utm 33n" (WGS 84), an EPSG name, or WKT.

    Returns
    -------
    code : str
        "EPSG:n" or WKT.
    unit_m : float
        Metres per unit of x and y.

    Raises
    ------
    InputError
        If the text is not a CRS that can be used for x, y and z of a model.
    """
    from pyproj import CRS
    from pyproj.exceptions import CRSError

    stripped_text = text.strip()
    if stripped_text.isdigit():
        stripped_text = f"EPSG:{stripped_text}"
    if (zone := _UTM.fullmatch(stripped_text)) is not None:
        zone_number, hemisphere = int(zone["number"]), zone["half"].upper()
        stripped_text = f"EPSG:{(32600 if hemisphere == 'N' else 32700) + zone_number}"
    try:
        crs = CRS.from_user_input(stripped_text)
    except (CRSError, UnicodeError) as error:
        raise InputError(Finding("frame.unknown-crs", crs=text.strip()), field="CRS") from error
    if not crs.is_projected:
        raise InputError(Finding("frame.not-projected", crs=crs.name), field="CRS")
    axes = stated_axes(stripped_text)
    if axes.unusual_directions:
        raise InputError(Finding("frame.other-axes", crs=crs.name), field="CRS")
    if axes.height_factor != 1.0 or axes.crs is None or axes.unit_m is None:
        raise InputError(Finding("frame.other-height-unit", crs=crs.name), field="CRS")
    return axes.crs, axes.unit_m


def unit_in_metres(code: str) -> float:
    """Return the metres per unit of x and y of a CRS.

    Returns 1 for a CRS that `parse_crs` rejects.
    """
    if _WGS_84_UTM.fullmatch(code):
        # Avoid importing PROJ, which would delay the first display of a model.
        return 1.0
    try:
        return parse_crs(code)[1]
    except InputError:
        return 1.0


def world_crs(code: str | None, unit_m: float) -> str | None:
    """Return the CRS of the World frame, which is in metres, for the CRS of a model.

    Parameters
    ----------
    code : str or None
        CRS of the model.
    unit_m : float
        Metres per unit of x and y.

    Returns
    -------
    str or None
        `code` if its unit is the metre, otherwise the same projection in metres as WKT.
    """
    if code is None or unit_m == 1.0:
        return code
    from pyproj import CRS

    crs_fields = CRS.from_user_input(code).to_json_dict()
    parts = crs_fields.get("components", [crs_fields])
    for part in parts:
        part.pop("id", None)
        part["name"] = f"{part['name']}, in metres"
        # False eastings and northings have their own units in the parameters.
        for axis in part["coordinate_system"]["axis"]:
            axis["unit"] = "metre"
    crs_fields.pop("id", None)
    return str(CRS.from_json_dict(crs_fields).to_wkt())


def crs_name(code: str) -> str:
    """Return the name of a CRS, such as "WGS 84 / UTM zone 33N"."""
    from pyproj import CRS

    return str(CRS.from_user_input(code).name)


def convergence_deg(code: str, x: float, y: float) -> float | None:
    """Compute the meridian convergence at a point of a projected CRS.

    Parameters
    ----------
    code : str
    x, y : float
        Coordinates in the unit of the CRS.

    Returns
    -------
    float or None
        Angle from true north to grid north in degrees, positive to the east: grid azimuth = true
        azimuth - convergence. None if the CRS does not cover the point.
    """
    from pyproj import Proj
    from pyproj.exceptions import ProjError

    try:
        projection = Proj(code)
        longitude, latitude = projection(x, y, inverse=True, errcheck=True)
        value = float(projection.get_factors(longitude, latitude).meridian_convergence)
    except ProjError:
        return None
    return value if isfinite(value) else None


def utm_zone(longitude_deg: float, latitude_deg: float) -> str:
    """Return the code "EPSG:n" for the UTM zone (WGS 84) of a point given in degrees."""
    zone = min(int((longitude_deg + 180) // 6) + 1, 60)
    return f"EPSG:{(32600 if latitude_deg >= 0 else 32700) + zone}"


def parse_crs_option(text: str, field: str = "--crs") -> tuple[str, float]:
    """Parse a CRS with `parse_crs`, raising UsageError with the option `field`."""
    try:
        return parse_crs(text)
    except InputError as error:
        raise UsageError(error, field=field) from error


def metric_crs(text: str, field: str) -> str:
    """Parse a projected CRS in metres and return "EPSG:n" or WKT.

    Raises
    ------
    UsageError
        If the text is not a projected CRS in metres; states the option `field`.
    """
    code, unit = parse_crs_option(text, field)
    if unit != 1.0:
        raise UsageError(Finding("frame.not-in-metres", crs=crs_name(code)), field=field)
    return code


def degrees_to_grid(
    code: str, geographic_crs: str = "EPSG:4326"
) -> Callable[[float, float], tuple[float, float] | None]:
    """Return a function that projects longitude and latitude.

    Parameters
    ----------
    code : str
        Projected CRS in metres.
    geographic_crs : str
        CRS of longitude and latitude in degrees.

    Returns
    -------
    callable
        Function from longitude and latitude to x and y, or None if the CRS does not cover the
        point.
    """
    from pyproj import Transformer

    transformer = Transformer.from_crs(geographic_crs, code, always_xy=True)

    def to_grid(longitude: float, latitude: float) -> tuple[float, float] | None:
        x, y = transformer.transform(longitude, latitude)
        return (float(x), float(y)) if isfinite(x) and isfinite(y) else None

    return to_grid


def to_degrees(
    code: str, x: npt.ArrayLike, y: npt.ArrayLike
) -> tuple[FloatArray, FloatArray] | None:
    """Convert coordinates in a CRS to longitude and latitude (WGS 84).

    Parameters
    ----------
    code : str
    x, y : (n,) float

    Returns
    -------
    longitude, latitude : (n,) float
        Coordinates in degrees. Returns None instead if the CRS does not cover a point.
    """
    import numpy as np

    longitude, latitude = _wgs84_transformer(code).transform(np.asarray(x), np.asarray(y))
    degrees = np.asarray(longitude, np.float64), np.asarray(latitude, np.float64)
    return degrees if all(np.isfinite(part).all() for part in degrees) else None


@lru_cache(maxsize=4)
def _wgs84_transformer(code: str) -> Any:
    from pyproj import Transformer

    return Transformer.from_crs(code, "EPSG:4326", always_xy=True)


def read_sidecar(file: Path) -> str:
    """Return the text of the `NAME.prj` file next to a file.

    Raises
    ------
    FileNotFoundError
        If the file does not exist.
    OSError, InputError
        If the file cannot be read.
    """
    # Names in a Windows code page do not affect the numbers.
    return convert_to_utf8(read_small_file(sidecar_path(file), _MAX_BYTES)).decode(
        "utf-8", "replace"
    )


def sidecar_crs(model: Path, bounds: FloatArray | None = None) -> tuple[str | None, Finding | None]:
    """Return the CRS that is stated by the `NAME.prj` file next to a model.

    The file may state another unit of heights: see `vomstudio.io.gis.axis_units`. An outcrop is
    less than a degree wide, so a CRS in degrees next to a wider model belongs to another file.

    Parameters
    ----------
    model : Path
    bounds : (2, 3) float, optional
        Lower-left and upper-right corners of the model.

    Returns
    -------
    crs : str or None
        WKT, or a code such as ``EPSG:32633``.
    finding : Finding or None
        ``frame.crs-unreadable`` or ``frame.crs-unused`` if the file cannot be used.
    """
    name = sidecar_path(model).name
    try:
        text = read_sidecar(model)
    except FileNotFoundError:
        return None, None
    except (OSError, InputError) as error:
        return None, Finding("frame.crs-unreadable", file=name, crs=str(error))
    try:
        axes = stated_axes(text)
    except InputError:
        return None, Finding("frame.crs-unreadable", file=name, crs=_quote_text(text))
    if bounds is not None and _can_have_kind(axes.kind, bounds):
        return text, None
    if axes.kind != "projected":
        return None, Finding("frame.crs-unused", file=name, crs=_quote_text(text))
    if axes.height_factor != 1.0 or axes.unusual_directions:
        return text, None
    return axes.crs, None


def _quote_text(text: str) -> str:
    return " ".join(text.split())[:80] or tr("nothing")


def _can_have_kind(kind: str, bounds: FloatArray) -> bool:
    """Return whether coordinates may be "geographic" or "geocentric", as stated by `kind`.

    Returns False for other kinds.
    """
    import numpy as np

    if not np.isfinite(bounds).all():
        return False
    if kind == "geographic":
        max_coordinates, width = np.abs(bounds[:, :2]).max(axis=0), np.ptp(bounds[:, :2], axis=0)
        return bool((max_coordinates <= [360.0, 360.0]).all() and (width < 1.0).all())
    radius = float(np.linalg.norm(bounds.mean(axis=0)))
    return kind == "geocentric" and 6.2e6 < radius < 6.6e6


def sidecar_path(model: Path) -> Path:
    """Return the path of the CRS file `NAME.prj` of a model or table."""
    return model.with_suffix(".prj")
