"""Which unit each axis of a file is in, by the coordinate reference system that it names.

The only place that decides this, for every format: horizontal and vertical unit are taken from the
CRS (compound ones have two), heights without a unit of their own have that of the horizontal axes,
and what a file states of its heights beside the CRS goes before both (CONVENTIONS).
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
from vomstudio.geometry.units import METRES

Units = tuple[str, str, str]
"""Of x, y and z: "m", "ft", "us-ft", "degree", "unknown", or another unit's name."""

UNKNOWN: Units = ("unknown", "unknown", "unknown")
MOST_DEGREES = 400.0
"""No coordinate in degrees, or gons, is beyond it."""
_SAME = 2e-7
"""Relative: files write the US survey foot with seven digits; the two feet differ by 2e-6."""
_WORDS = {
    "m": to_translate("metres"),
    "ft": to_translate("feet"),
    "us-ft": to_translate("US survey feet"),
    "degree": to_translate("degrees"),
}


@dataclass(frozen=True)
class StatedAxes:
    """What a file says of its axes.

    crs : "EPSG:n" or WKT, in whose x, y (and z) the model is kept; None where it is none with
        east, north and up
    kind : of the CRS that was named; "local" is one with a unit and no place on Earth
    units : as the file states them
    unit_m, height_m : metres in a unit of x and y, and of z; None where it is unknown or no length
    has_heights : whether heights have a statement of their own, beside that of x and y
    overruled : the unit of heights that the CRS names, where the file states another beside it
    grows : whither x, y and z grow where that is not east (or along a meridian), north and up
    """

    crs: str | None = None
    kind: Literal["projected", "geographic", "geocentric", "local", "none"] = "none"
    units: Units = UNKNOWN
    unit_m: float | None = None
    height_m: float | None = None
    has_heights: bool = False
    overruled: str | None = None
    grows: frozenset[Literal["west", "south", "down"]] = frozenset()

    @property
    def metres(self) -> tuple[float, float, float]:
        """Metres per unit of x, y and z; 1 where unknown, and for degrees."""
        flat = self.unit_m or 1.0
        return flat, flat, self.height_m or flat

    @property
    def height_factor(self) -> float:
        """What brings heights to the unit of x and y, in which the model is kept; of a local
        system, which has no axes to keep to, both are brought to metres by `unit_factor`."""
        if self.kind not in ("projected", "local") or not self.unit_m or not self.height_m:
            return 1.0
        return self.height_m / self.unit_m

    @property
    def unit_factor(self) -> float:
        return self.unit_m if self.kind == "local" and self.unit_m else 1.0


def stated_axes(text: str | None, height_unit: str | None = None) -> StatedAxes:
    """text : a code, a name or WKT, as a file names its CRS; None where it names none.
    height_unit : what it says of its heights beside that, a name of `METRES`.

    Raises InputError where the text is no CRS.
    """
    own = None if height_unit is None else METRES.get(height_unit)
    if text is None or not text.strip():
        high = height_unit or "unknown"
        return StatedAxes(units=("unknown", "unknown", high), height_m=own, has_heights=bool(own))
    from pyproj import CRS
    from pyproj.exceptions import CRSError

    plain = text.strip()
    try:
        crs = CRS.from_user_input(f"EPSG:{plain}" if plain.isdigit() else plain)
    except CRSError as error:
        raise InputError(Finding("frame.unknown-crs", crs=plain[:80]), field="CRS") from error
    parts = [_bare(part) for part in crs.sub_crs_list] if crs.is_compound else [_bare(crs)]
    flat = next((part for part in parts if not part.is_vertical), None)
    axes = [] if flat is None else flat.axis_info
    up = next((part.axis_info for part in parts if part.is_vertical), axes[2:3])
    grows = _unusual(axes[:2], up)
    kind = "none" if flat is None else _kind_of(flat)
    name, unit_m = _unit_of(axes[0]) if axes else ("unknown", None)
    high, height_m = _unit_of(up[0]) if up else (name, unit_m)
    overruled = high if up and height_unit not in (None, high) else None
    if height_unit is not None:
        high, height_m = height_unit, own
    has_heights = bool(up) or height_unit is not None
    if kind == "geographic":
        unit_m = None
        if not has_heights:
            high, height_m = "unknown", None
    # The name of a compound system says another unit of z than the model is then kept in.
    mixed = unit_m is not None and height_m is not None and not _same(unit_m, height_m)
    kept = None
    if flat is not None and kind not in ("local", "none") and not grows:
        # A shift to another datum beside a system of the register is the register's business.
        bare = mixed or overruled is not None or (crs.is_bound and flat.to_epsg() is not None)
        kept = _name_of(flat if bare else crs)
    return StatedAxes(
        kept, kind, (name, name, high), unit_m, height_m, has_heights, overruled, grows
    )


def _unusual(flat: Any, up: Any) -> frozenset[Literal["west", "south", "down"]]:
    """Of pyproj axes. Both axes of a polar system point along meridians, the same way."""
    ways = {str(axis.direction) for axis in flat}
    found: set[Literal["west", "south", "down"]] = set()
    if len(ways) == 2:
        found |= {way for way in ("west", "south") if way in ways}
    if up and str(up[0].direction) == "down":
        found.add("down")
    return frozenset(found)


def _bare(crs: Any) -> Any:
    """Without the shift to another datum that files add to it."""
    return crs.source_crs if crs.is_bound and crs.source_crs is not None else crs


def _kind_of(crs: Any) -> Literal["projected", "geographic", "geocentric", "local", "none"]:
    if crs.is_projected:
        return "projected"
    if crs.is_geocentric:
        return "geocentric"
    if crs.is_geographic:
        return "geographic"
    return "local" if crs.is_engineering and len(crs.axis_info) >= 2 else "none"


def _same(one: float, other: float) -> bool:
    return isclose(one, other, rel_tol=_SAME)


def _unit_of(axis: Any) -> tuple[str, float | None]:
    """Name and metres of the unit of a pyproj axis."""
    name, factor = str(axis.unit_name), float(axis.unit_conversion_factor)
    if name in ("degree", "grad", "gon", "radian") or (
        axis.direction in ("north", "east") and _same(factor, 0.017453292519943295)
    ):
        return ("degree" if _same(factor, 0.017453292519943295) else name), None
    if not isfinite(factor) or factor <= 0 or (name == "unknown" and factor == 1.0):
        return "unknown", None
    for known, metres in METRES.items():
        if _same(factor, metres):
            return known, factor
    return name, factor


def _name_of(crs: Any) -> str:
    """ "EPSG:n" where the code means the same with the same units, else WKT."""
    code = crs.to_epsg()
    if code is not None:
        from pyproj import CRS

        meant = CRS.from_epsg(code).axis_info
        if all(
            _same(a.unit_conversion_factor, b.unit_conversion_factor)
            for a, b in zip(meant, crs.axis_info, strict=False)
        ):
            return f"EPSG:{code}"
    return str(crs.to_wkt())


def unit_text(unit: str) -> str:
    """The name of a unit within a sentence."""
    return tr(_WORDS[unit]) if unit in _WORDS else unit


def unit_findings(axes: StatedAxes) -> tuple[Finding, ...]:
    """Return what a reader of a file with these axes converts or assumes; none for plain metres."""
    flat, _, high = axes.units
    findings: list[Finding] = []
    if axes.has_heights and flat == "unknown":
        findings.append(Finding("frame.height-unit-only", height_unit=unit_text(high)))
    if axes.grows:
        findings.append(Finding("frame.axes-unused"))
    if axes.overruled is not None:
        findings.append(
            Finding(
                "frame.height-unit-replaced",
                height_unit=unit_text(high),
                crs_unit=unit_text(axes.overruled),
            )
        )
    is_converted = (
        (axes.kind == "local" and axes.unit_factor != 1.0)
        or not _same(axes.height_factor, 1.0)
        or (axes.kind == "projected" and axes.unit_m is not None and not _same(axes.unit_m, 1.0))
    )
    if is_converted:
        findings.append(
            Finding("frame.unit-converted", unit=unit_text(flat), height_unit=unit_text(high))
        )
    return tuple(findings)


def refusal(axes: StatedAxes, bounds: FloatArray) -> Finding | None:
    """Return why coordinates with these axes have no true scale, or no up; else None.

    Parameters
    ----------
    axes : StatedAxes
    bounds : (2, 3) float
        Lowest and highest corner of the data, as written.
    """
    if axes.kind == "geocentric":
        return Finding("frame.geocentric")
    if "down" in axes.grows:
        return Finding("frame.depths")
    if axes.grows and float(np.asarray(bounds)[:, 1].sum()) > 0:
        # Coordinates below zero show that the file counts to the north all the same, as GIS do.
        return Finding("frame.other-axes")
    if axes.kind != "geographic":
        return None
    if float(np.abs(np.asarray(bounds)[:, :2]).max(initial=0.0)) > MOST_DEGREES:
        return Finding("frame.not-degrees")
    return Finding("frame.degrees", suggested_crs=suggested_zone(bounds))


def suggested_zone(bounds: FloatArray) -> str:
    """Return ``EPSG:n`` of the UTM zone (WGS 84) at the middle of data in degrees."""
    longitude, latitude = np.asarray(bounds, np.float64)[:, :2].mean(axis=0)
    if not np.isfinite([longitude, latitude]).all():
        return "EPSG:326xx"
    zone = int((longitude + 180.0) % 360.0 // 6.0) + 1
    return f"EPSG:{(32600 if latitude >= 0 else 32700) + zone}"
