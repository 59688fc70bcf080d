"""Numbers in words: the same notation, units and digits everywhere in the window."""

from __future__ import annotations

import re
from collections.abc import Mapping
from math import floor, isfinite, log10

import numpy as np
import numpy.typing as npt

from vomstudio.document.measurements import Measurement
from vomstudio.document.records import DimensionKind
from vomstudio.geology.notation import format_line, format_plane
from vomstudio.geometry.units import area_text, length_text
from vomstudio.workspace.wording import degrees as degrees
from vomstudio.workspace.wording import plane_text as plane_text

area, length = area_text, length_text
"""In words, with a unit that fits."""


def orientation_text(measured: Measurement, notation: str, decimals: int | None = 0) -> str:
    """A feature's plane or line in the notation of the house, or the figure of a dimension."""
    if measured.fit is not None:
        return plane_text(measured.fit, notation, decimals=decimals)
    if measured.plane is not None:
        return format_plane(measured.plane, notation, decimals or 0)
    if measured.line is not None:
        error = measured.max_confidence95_deg
        if decimals is None:
            decimals = 1 if error is not None and error < 1.0 else 0
        return format_line(measured.line, decimals)
    if measured.dimension:
        return dimension_text(measured.dimension, metric=measured.metric)
    return "–"


# The figure that a dimension is made for, first in this order where it has it.
_MAIN: tuple[str, ...] = ("thickness_m", "area_m2", "length_m", "distance_m")


def dimension_text(figures: Mapping[str, float], *, metric: bool = True) -> str:
    """The main figure of a dimension, with its error where that is known."""
    for name in _MAIN:
        if name in figures:
            if name == "area_m2":
                return area(figures[name], metric=metric)
            error = figures.get(name.replace("_m", "_error95_m"))
            text = length(figures[name], metric=metric)
            return text if error is None else f"{text} ± {length(error, 2, metric=metric)}"
    return "–"


DIMENSION_NAMES: dict[DimensionKind, str] = {
    "distance": "Distance",
    "polyline": "Polyline",
    "area": "Area",
    "thickness": "Thickness",
}


def slip_names() -> dict[str, str]:
    """Senses of slip as they are offered."""
    return {
        "": "none",
        "normal": "normal",
        "reverse": "reverse",
        "sinistral": "sinistral (left-lateral)",
        "dextral": "dextral (right-lateral)",
    }


def drawn_points(measured: Measurement) -> npt.NDArray[np.float64]:
    """(n, 3) World points that show how far a feature reaches."""
    fit = measured.fit
    if fit is None or fit.extent is None or len(measured.points) > 1:
        return measured.points
    reach = 0.5 * fit.extent * fit.axes[:2]
    return np.concatenate([measured.points, fit.centroid + reach, fit.centroid - reach])


def number(value: float | None, digits: int = 3) -> str:
    """A ratio or an index, to so many significant digits."""
    if value is None:
        return "–"
    if not isfinite(value):
        return "∞"
    if value == 0 or abs(value) >= 1e6:
        return f"{value:.{digits}g}"
    decimals = max(0, digits - 1 - floor(log10(abs(value))))
    return f"{value:.{decimals}f}"


def gigabytes(size: float) -> str:
    """Of bytes, with two digits that mean something."""
    value = size / 1e9
    return f"{value:.1f} GB" if value < 9.95 else f"{value:.0f} GB"


def natural(name: str) -> tuple[tuple[int, int, str], ...]:
    """For sorting: B2 before B10."""
    return tuple(
        (0, int(part), "") if part.isdecimal() else (1, 0, part.casefold())
        for part in re.split(r"(\d+)", name)
        if part
    )
