"""Units of the axes of a file according to the coordinate reference system it states.

This is the only module that determines the units, for every format. The horizontal and vertical
units are those of the CRS (a compound CRS has two); heights without a unit have the unit of the
horizontal axes; a unit of heights that a file states in addition to the CRS overrides both.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isclose, isfinite
from typing import Any, Literal

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.units import METRES_PER_UNIT

Units = tuple[str, str, str]
"""Units of x, y and z: "m", "ft", "us-ft", "degree", "unknown", or another name."""

UNKNOWN_UNITS: Units = ("unknown", "unknown", "unknown")
MAX_DEGREES = 400.0
"""Maximum coordinate in degrees or gons."""
_UNIT_TOLERANCE = 2e-7
"""Relative tolerance: the US survey foot has seven digits in files, and the feet differ by 2e-6."""
_UNIT_NAMES = {
    "m": to_translate("metres"),
    "ft": to_translate("feet"),
    "us-ft": to_translate("US survey feet"),
    "degree": to_translate("degrees"),
}


@dataclass(frozen=True)
class StatedAxes:
    """Axes stated by a file.

    Parameters
    ----------
    crs : str or None
        "EPSG:n" or WKT for the stored x, y (and z); None if not stated, for a local system, and if
        the axes are not east, north and up.
    kind : str
        Kind of the stated CRS; "local" is a CRS with a unit but without a position on Earth.
    units : Units
        Units as stated by the file.
    unit_m, height_m : float or None
        Metres per unit of x and y, and of z; None if unknown or not a length.
    has_heights : bool
        Whether the unit of heights is stated separately from that of x and y.
    replaced_height_unit : str or None
        Unit of heights of the CRS if the file states a different one.
    unusual_directions : frozenset of str
        Directions of axes other than east (or along a meridian), north and up.
    """

    crs: str | None = None
    kind: Literal["projected", "geographic", "geocentric", "local", "none"] = "none"
    units: Units = UNKNOWN_UNITS
    unit_m: float | None = None
    height_m: float | None = None
    has_heights: bool = False
    replaced_height_unit: str | None = None
    unusual_directions: frozenset[Literal["west", "south", "down"]] = frozenset()

    @property
    def metres(self) -> tuple[float, float, float]:
        """Metres per unit of x, y and z.

        The horizontal factors are 1 for unknown units and degrees; an unknown vertical factor is
        replaced by the horizontal one.
        """
        horizontal_m = self.unit_m or 1.0
        return horizontal_m, horizontal_m, self.height_m or horizontal_m

    @property
    def height_factor(self) -> float:
        """Factor from the unit of heights to the unit of x and y.

        In a local system, `unit_factor` converts both to metres.
        """
        if self.kind not in ("projected", "local") or not self.unit_m or not self.height_m:
            return 1.0
        return self.height_m / self.unit_m

    @property
    def unit_factor(self) -> float:
        """Metres per unit of a local system; 1 for other systems."""
        return self.unit_m if self.kind == "local" and self.unit_m else 1.0


def stated_axes(text: str | None, height_unit: str | None = None) -> StatedAxes:
    """Determine the axes that a file states.

    Parameters
    ----------
    text : str or None
        Code, name or WKT of the CRS; None if the file states no CRS.
    height_unit : str, optional
        Unit of heights that the file states in addition to the CRS, as a key of `METRES_PER_UNIT`.

    Raises
    ------
    InputError
        If the text is not a CRS.
    """
    stated_height_m = None if height_unit is None else METRES_PER_UNIT.get(height_unit)
    if text is None or not text.strip():
        vertical_unit = height_unit or "unknown"
        return StatedAxes(
            units=("unknown", "unknown", vertical_unit),
            height_m=stated_height_m,
            has_heights=bool(stated_height_m),
        )
    from pyproj import CRS
    from pyproj.exceptions import CRSError

    crs_text = text.strip()
    try:
        crs = CRS.from_user_input(f"EPSG:{crs_text}" if crs_text.isdigit() else crs_text)
    except CRSError as error:
        raise InputError(Finding("frame.unknown-crs", crs=crs_text[:80]), field="CRS") from error
    parts = (
        [_remove_datum_shift(part) for part in crs.sub_crs_list]
        if crs.is_compound
        else [_remove_datum_shift(crs)]
    )
    horizontal_part = next((part for part in parts if not part.is_vertical), None)
    axes = [] if horizontal_part is None else horizontal_part.axis_info
    vertical_axes = next((part.axis_info for part in parts if part.is_vertical), axes[2:3])
    unusual_directions = _unusual_directions(axes[:2], vertical_axes)
    kind = "none" if horizontal_part is None else _crs_kind(horizontal_part)
    horizontal_unit, unit_m = _axis_unit(axes[0]) if axes else ("unknown", None)
    vertical_unit, height_m = (
        _axis_unit(vertical_axes[0]) if vertical_axes else (horizontal_unit, unit_m)
    )
    replaced_height_unit = (
        vertical_unit if vertical_axes and height_unit not in (None, vertical_unit) else None
    )
    if height_unit is not None:
        vertical_unit, height_m = height_unit, stated_height_m
    has_heights = bool(vertical_axes) or height_unit is not None
    if kind == "geographic":
        unit_m = None
        if not has_heights:
            vertical_unit, height_m = "unknown", None
    # A compound system may state a unit of z other than that of the stored model.
    has_mixed_units = (
        unit_m is not None and height_m is not None and not _are_equal_units(unit_m, height_m)
    )
    stored_crs = None
    if horizontal_part is not None and kind not in ("local", "none") and not unusual_directions:
        # The datum shift of a system with an EPSG code is defined by the EPSG register.
        uses_horizontal_part = (
            has_mixed_units
            or replaced_height_unit is not None
            or (crs.is_bound and horizontal_part.to_epsg() is not None)
        )
        stored_crs = _crs_name(horizontal_part if uses_horizontal_part else crs)
    return StatedAxes(
        stored_crs,
        kind,
        (horizontal_unit, horizontal_unit, vertical_unit),
        unit_m,
        height_m,
        has_heights,
        replaced_height_unit,
        unusual_directions,
    )


def _unusual_directions(
    horizontal_axes: Any, vertical_axes: Any
) -> frozenset[Literal["west", "south", "down"]]:
    """Return the directions of pyproj axes other than east, north and up.

    Both axes of a polar system point along meridians in the same direction.
    """
    directions = {str(axis.direction) for axis in horizontal_axes}
    unusual_directions: set[Literal["west", "south", "down"]] = set()
    if len(directions) == 2:
        unusual_directions |= {
            direction for direction in ("west", "south") if direction in directions
        }
    if vertical_axes and str(vertical_axes[0].direction) == "down":
        unusual_directions.add("down")
    return frozenset(unusual_directions)


def _remove_datum_shift(crs: Any) -> Any:
    """Return a CRS without the shift to another datum that some files add."""
    return crs.source_crs if crs.is_bound and crs.source_crs is not None else crs


def _crs_kind(crs: Any) -> Literal["projected", "geographic", "geocentric", "local", "none"]:
    if crs.is_projected:
        return "projected"
    if crs.is_geocentric:
        return "geocentric"
    if crs.is_geographic:
        return "geographic"
    return "local" if crs.is_engineering and len(crs.axis_info) >= 2 else "none"


def _are_equal_units(first_factor: float, second_factor: float) -> bool:
    return isclose(first_factor, second_factor, rel_tol=_UNIT_TOLERANCE)


def _axis_unit(axis: Any) -> tuple[str, float | None]:
    """Return the name of the unit of a pyproj axis and its length in metres.

    The length is None for angles and unknown units.
    """
    name, factor = str(axis.unit_name), float(axis.unit_conversion_factor)
    if name in ("degree", "grad", "gon", "radian") or (
        axis.direction in ("north", "east") and _are_equal_units(factor, 0.017453292519943295)
    ):
        return ("degree" if _are_equal_units(factor, 0.017453292519943295) else name), None
    if not isfinite(factor) or factor <= 0 or (name == "unknown" and factor == 1.0):
        return "unknown", None
    for unit_name, metres in METRES_PER_UNIT.items():
        if _are_equal_units(factor, metres):
            return unit_name, factor
    return name, factor


def _crs_name(crs: Any) -> str:
    """Return "EPSG:n" if a CRS has a code with the same units, otherwise WKT."""
    code = crs.to_epsg()
    if code is not None:
        from pyproj import CRS

        epsg_axes = CRS.from_epsg(code).axis_info
        if all(
            _are_equal_units(epsg_axis.unit_conversion_factor, crs_axis.unit_conversion_factor)
            for epsg_axis, crs_axis in zip(epsg_axes, crs.axis_info, strict=False)
        ):
            return f"EPSG:{code}"
    return str(crs.to_wkt())


def unit_text(unit: str) -> str:
    """Return the name of a unit for a sentence."""
    return tr(_UNIT_NAMES[unit]) if unit in _UNIT_NAMES else unit


def unit_findings(axes: StatedAxes) -> tuple[Finding, ...]:
    """Return the findings about converted or assumed units; empty for metres."""
    horizontal_unit, _, vertical_unit = axes.units
    findings: list[Finding] = []
    if axes.has_heights and horizontal_unit == "unknown":
        findings.append(Finding("frame.height-unit-only", height_unit=unit_text(vertical_unit)))
    if axes.unusual_directions:
        findings.append(Finding("frame.axes-unused"))
    if axes.replaced_height_unit is not None:
        findings.append(
            Finding(
                "frame.height-unit-replaced",
                height_unit=unit_text(vertical_unit),
                crs_unit=unit_text(axes.replaced_height_unit),
            )
        )
    is_converted = (
        (axes.kind == "local" and axes.unit_factor != 1.0)
        or not _are_equal_units(axes.height_factor, 1.0)
        or (
            axes.kind == "projected"
            and axes.unit_m is not None
            and not _are_equal_units(axes.unit_m, 1.0)
        )
    )
    if is_converted:
        findings.append(
            Finding(
                "frame.unit-converted",
                unit=unit_text(horizontal_unit),
                height_unit=unit_text(vertical_unit),
            )
        )
    return tuple(findings)


def axes_problem(axes: StatedAxes, bounds: FloatArray) -> Finding | None:
    """Return the reason why coordinates have no true scale or up direction, or None.

    Parameters
    ----------
    axes : StatedAxes
    bounds : (2, 3) float
        Lower-left and upper-right corners of the data, as written.
    """
    if axes.kind == "geocentric":
        return Finding("frame.geocentric")
    if "down" in axes.unusual_directions:
        return Finding("frame.depths")
    if axes.unusual_directions and float(np.asarray(bounds)[:, 1].sum()) > 0:
        # Negative coordinates show that y nevertheless increases to the north, as in GIS.
        return Finding("frame.other-axes")
    if axes.kind != "geographic":
        return None
    if float(np.abs(np.asarray(bounds)[:, :2]).max(initial=0.0)) > MAX_DEGREES:
        return Finding("frame.not-degrees")
    return Finding("frame.degrees", suggested_crs=suggested_zone(bounds))


def suggested_zone(bounds: FloatArray) -> str:
    """Return ``EPSG:n`` of the UTM zone (WGS 84) at the centre of data in degrees.

    Returns ``EPSG:326xx`` if the centre is not finite.
    """
    longitude, latitude = np.asarray(bounds, np.float64)[:, :2].mean(axis=0)
    if not np.isfinite([longitude, latitude]).all():
        return "EPSG:326xx"
    zone = int((longitude + 180.0) % 360.0 // 6.0) + 1
    return f"EPSG:{(32600 if latitude >= 0 else 32700) + zone}"
