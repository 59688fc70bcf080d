"""Lengths and areas as text, in a suitable unit."""

from __future__ import annotations

import math
from collections.abc import Container, Sequence
from dataclasses import dataclass

from vomstudio.core.words import tr

METRES_PER_UNIT = {
    "m": 1.0,
    "cm": 0.01,
    "mm": 0.001,
    "km": 1000.0,
    "ft": 0.3048,
    "us-ft": 1200 / 3937,
}
"""Metres per unit of length, by the name that users type."""


@dataclass(frozen=True)
class Axes:
    """Axes of coordinates, the single source of axes and units in files and labels.

    Attributes
    ----------
    metric : bool
        Whether the unit is the metre; if False, it is the unit of the model, of unknown length.
    north : bool
        Whether y is North and z is Up; if False, no direction is known.
    """

    metric: bool = True
    north: bool = True

    @property
    def unit(self) -> str:
        """Unit of coordinates and lengths for file headers, in English."""
        return "metres" if self.metric else "model units"

    @property
    def titles(self) -> tuple[str, str, str]:
        """Names of the axes with their unit, for column headers."""
        names = ("E", "N", "Z") if self.north else ("x", "y", "z")
        unit = "m" if self.metric else tr("units")
        first_title, second_title, third_title = (f"{name} ({unit})" for name in names)
        return first_title, second_title, third_title

    @property
    def description(self) -> str:
        """Description for file headers, in English."""
        if self.metric and self.north:
            return "x East, y North, z Up, metres"
        return f"x, y, z of a local frame without north, in {self.unit}"

    @property
    def wkt(self) -> str:
        """Engineering CRS for a frame without a position on Earth.

        GIS programs would read a file without a CRS as East and North.
        """
        unit = 'UNIT["metre",1]' if self.metric else 'UNIT["unknown",1]'
        if self.metric and self.north:
            name, axes = "Local frame", 'AXIS["Easting",EAST],AXIS["Northing",NORTH]'
        else:
            name, axes = "Model frame without north", 'AXIS["X",OTHER],AXIS["Y",OTHER]'
        name += ", metres" if self.metric else ", model units"
        return f'LOCAL_CS["{name}",LOCAL_DATUM["Model",32767],{unit},{axes}]'


WORLD_AXES = Axes()
UNPLACED_AXES = Axes(metric=False, north=False)

MAX_ROUNDING_M = 1e-7
"""Maximum length that is considered a rounding error."""


def strip_metric_suffix(name: str, other_names: Container[str] = ()) -> str:
    """Return the name of a column without its metric suffix, for an unknown unit.

    `NAME_m` and `NAME_m2` become `NAME`; `NAME_1_per_m` and `NAME_1_per_m2` become
    `NAME_1_per_length` and `NAME_1_per_area`. If another column has the new name, `_units` is
    appended. Other names do not change.

    Parameters
    ----------
    name : str
    other_names : Container[str], optional
        Names of the other columns.

    Returns
    -------
    str
    """
    for suffix, replacement in UNIT_SUFFIXES:
        if name.endswith(suffix):
            base = name.removesuffix(suffix) + replacement
            return f"{base}_units" if base in other_names else base
    return name


def table_columns(names: Sequence[str], *, is_metric: bool) -> list[str]:
    """Return the column names of a table, without metric suffixes unless `is_metric`.

    Parameters
    ----------
    names : sequence of str
        Column names with metric suffixes.
    is_metric : bool
        Whether the lengths are in metres.

    Returns
    -------
    list of str
    """
    return [name if is_metric else strip_metric_suffix(name, names) for name in names]


UNIT_SUFFIXES = (
    ("_1_per_m2", "_1_per_area"),
    ("_1_per_m", "_1_per_length"),
    ("_m2", ""),
    ("_m", ""),
)


def length_text(length_m: float | None, digits: int = 3, *, is_metric: bool = True) -> str:
    """Format a length with the given significant digits, but at least to whole units.

    Parameters
    ----------
    length_m : float or None
    digits : int, optional
        Number of significant digits.
    is_metric : bool, optional
        Whether lengths are in metres; False for a model of unknown scale, whose lengths are in
        units of its file.

    Returns
    -------
    str
        A dash for None.
    """
    if length_m is None:
        return "–"
    if not is_metric:
        return tr("{length} units", length=_format_rounded(length_m, digits))
    if abs(length_m) < MAX_ROUNDING_M:
        return "0 mm"
    for unit, size in (("mm", 1e-3), ("cm", 1e-2), ("m", 1.0)):
        text = _format_rounded(length_m / size, digits)
        if abs(float(text)) < {"mm": 10.0, "cm": 100.0, "m": 1000.0}[unit]:
            return f"{text} {unit}"
    return f"{_format_rounded(length_m / 1000.0, digits)} km"


def round_length(max_length: float) -> float:
    """Return the largest 1, 2 or 5 times a power of ten up to a limit, for scale bars.

    Parameters
    ----------
    max_length : float
        Limit.

    Returns
    -------
    float
    """
    power = 10.0 ** math.floor(math.log10(max_length))
    return max(
        step * power for step in (1.0, 2.0, 5.0) if step * power <= max_length * (1.0 + 1e-9)
    )


def scale_bar_text(length_m: float, *, is_metric: bool = True) -> str:
    """Format the round length of a scale bar with as few digits as possible.

    Parameters
    ----------
    length_m : float
    is_metric : bool, optional
        See `length_text`.

    Returns
    -------
    str
    """
    if not is_metric:
        return tr("{length} units", length=f"{length_m:g}")
    for unit, size in (("km", 1e3), ("m", 1.0), ("cm", 1e-2)):
        if length_m >= size:
            return f"{length_m / size:g} {unit}"
    return f"{length_m * 1e3:g} mm"


def area_text(area_m2: float | None, digits: int = 3, *, is_metric: bool = True) -> str:
    """Format an area with the given significant digits, but at least to whole units.

    Parameters
    ----------
    area_m2 : float or None
    digits : int, optional
        Number of significant digits.
    is_metric : bool, optional
        See `length_text`.

    Returns
    -------
    str
        A dash for None.
    """
    if area_m2 is None:
        return "–"
    if not is_metric:
        return tr("{area} units²", area=_format_rounded(area_m2, digits))
    if abs(area_m2) < MAX_ROUNDING_M**2:
        return "0 cm²"
    for unit, size, limit in (("cm²", 1e-4, 100.0), ("m²", 1.0, 1e4)):
        text = _format_rounded(area_m2 / size, digits)
        if abs(float(text)) < limit:
            return f"{text} {unit}"
    return f"{_format_rounded(area_m2 / 1e6, digits)} km²"


def _format_rounded(value: float, digits: int) -> str:
    """Format significant digits without an exponent; digits before the point are never lost."""
    if not math.isfinite(value) or value == 0.0:
        return f"{value:.0f}"
    # The first digit of 0.9996 moves by one place when it is rounded.
    exponent = math.floor(math.log10(abs(float(f"{value:.{digits - 1}e}"))))
    decimals = max(0, digits - 1 - exponent)
    return f"{value:.{decimals}f}"
