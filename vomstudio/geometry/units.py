"""Lengths and areas in words, in the unit that suits them."""

from __future__ import annotations

import math
from collections.abc import Container, Sequence
from dataclasses import dataclass

from vomstudio.core.words import tr

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "km": 1000.0, "ft": 0.3048, "us-ft": 1200 / 3937}
"""By the name of a unit of length as users type it."""


@dataclass(frozen=True)
class Axes:
    """What is known of the axes in which coordinates are written. All files and labels take from
    here what they say of axes and units.

    metric : the unit is the metre, else it is the model's own, of unknown length
    north : y is North and z Up, else no direction is known
    """

    metric: bool = True
    north: bool = True

    @property
    def unit(self) -> str:
        """The unit of coordinates and lengths, for the heads of files, in English."""
        return "metres" if self.metric else "model units"

    @property
    def titles(self) -> tuple[str, str, str]:
        """Over the columns of a table: names of the axes with their unit."""
        names = ("E", "N", "Z") if self.north else ("x", "y", "z")
        unit = "m" if self.metric else tr("units")
        first, second, third = (f"{name} ({unit})" for name in names)
        return first, second, third

    @property
    def description(self) -> str:
        """For the heads of files, in English."""
        if self.metric and self.north:
            return "x East, y North, z Up, metres"
        return f"x, y, z of a local frame without north, in {self.unit}"

    @property
    def wkt(self) -> str:
        """An engineering CRS for a frame without a place on Earth. GIS programs would read a file
        without one as East and North."""
        unit = 'UNIT["metre",1]' if self.metric else 'UNIT["unknown",1]'
        if self.metric and self.north:
            name, axes = "Local frame", 'AXIS["Easting",EAST],AXIS["Northing",NORTH]'
        else:
            name, axes = "Model frame without north", 'AXIS["X",OTHER],AXIS["Y",OTHER]'
        name += ", metres" if self.metric else ", model units"
        return f'LOCAL_CS["{name}",LOCAL_DATUM["Model",32767],{unit},{axes}]'


WORLD = Axes()
UNPLACED = Axes(metric=False, north=False)

NOTHING_M = 1e-7
"""A length below this is rounding, not measurement."""


def without_metres(name: str, beside: Container[str] = ()) -> str:
    """For a column or figure that is called `NAME_m`, `NAME_m2` or `NAME_1_per_m` where nobody
    knows the unit: `NAME`, or `NAME_units` where that is the name of another one `beside` it."""
    for ending, instead in _OF_UNITS:
        if name.endswith(ending):
            bare = name.removesuffix(ending) + instead
            return f"{bare}_units" if bare in beside else bare
    return name


def columns_of(names: Sequence[str], *, metric: bool) -> list[str]:
    """The names over a table's columns; metric : its lengths are in metres"""
    return [name if metric else without_metres(name, names) for name in names]


_OF_UNITS = (("_1_per_m2", "_1_per_area"), ("_1_per_m", "_1_per_length"), ("_m2", ""), ("_m", ""))


def length_text(value_m: float | None, digits: int = 3, *, metric: bool = True) -> str:
    """A length to so many significant digits, whole units at least; `metric` is False for a model
    of unknown scale, whose lengths are in units of its file."""
    if value_m is None:
        return "–"
    if not metric:
        return tr("{length} units", length=_rounded(value_m, digits))
    if abs(value_m) < NOTHING_M:
        return "0 mm"
    for unit, size in (("mm", 1e-3), ("cm", 1e-2), ("m", 1.0)):
        text = _rounded(value_m / size, digits)
        if abs(float(text)) < {"mm": 10.0, "cm": 100.0, "m": 1000.0}[unit]:
            return f"{text} {unit}"
    return f"{_rounded(value_m / 1000.0, digits)} km"


def round_length(longest: float) -> float:
    """The largest 1, 2 or 5 times a power of ten that is at most `longest`: for scale bars."""
    power = 10.0 ** math.floor(math.log10(longest))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= longest * (1.0 + 1e-9))


def bar_text(length_m: float, *, metric: bool = True) -> str:
    """What stands at a scale bar of a round length: no more digits than it has."""
    if not metric:
        return tr("{length} units", length=f"{length_m:g}")
    for unit, size in (("km", 1e3), ("m", 1.0), ("cm", 1e-2)):
        if length_m >= size:
            return f"{length_m / size:g} {unit}"
    return f"{length_m * 1e3:g} mm"


def area_text(value_m2: float | None, digits: int = 3, *, metric: bool = True) -> str:
    if value_m2 is None:
        return "–"
    if not metric:
        return tr("{area} units²", area=_rounded(value_m2, digits))
    if abs(value_m2) < NOTHING_M**2:
        return "0 cm²"
    for unit, size, below in (("cm²", 1e-4, 100.0), ("m²", 1.0, 1e4)):
        text = _rounded(value_m2 / size, digits)
        if abs(float(text)) < below:
            return f"{text} {unit}"
    return f"{_rounded(value_m2 / 1e6, digits)} km²"


def _rounded(value: float, digits: int) -> str:
    """Significant digits without an exponent; no digit before the point is lost."""
    if not math.isfinite(value) or value == 0.0:
        return f"{value:.0f}"
    # 0.9996 has its first digit one place higher once it is rounded.
    first = math.floor(math.log10(abs(float(f"{value:.{digits - 1}e}"))))
    decimals = max(0, digits - 1 - first)
    return f"{value:.{decimals}f}"
