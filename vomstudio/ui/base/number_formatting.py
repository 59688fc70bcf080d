"""Formatting of numbers with uniform notation, units and digits in the window."""

from __future__ import annotations

import re
from functools import lru_cache

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import tr
from vomstudio.geology.notation import format_error_deg
from vomstudio.geology.slip import SENSES
from vomstudio.geometry.units import area_text, length_text
from vomstudio.project.figures import number
from vomstudio.project.kinds import find_kind
from vomstudio.project.measurement import Measurement

area, length = area_text, length_text
"""Functions that format an area or a length with a suitable unit."""

__all__ = [
    "area",
    "extent_points",
    "format_error_deg",
    "gigabytes_text",
    "length",
    "marked_attitude",
    "natural_sort_key",
    "number",
    "orientation_text",
    "slip_names",
]


def orientation_text(measurement: Measurement, notation: str) -> str:
    """Return the attitude of a feature with its 95 % error, or a summary for other kinds.

    The text is a dash if the feature has neither.
    """
    if measurement.plane is not None or measurement.line is not None:
        return measurement.attitude(notation)
    feature_kind = find_kind(measurement.kind)
    return (feature_kind.headline(measurement) if feature_kind is not None else None) or "–"


MARKS = {"good": "●", "doubtful": "▲", "poor": "■"}
"""Marks of verdicts in plain text, with the shapes of the coloured marks."""


def marked_attitude(measurement: Measurement, notation: str) -> str:
    """Return the attitude with its error and the mark of its verdict, for plain text.

    Parameters
    ----------
    measurement : Measurement
    notation : str
        Notation of planes.

    Returns
    -------
    str
    """
    text = orientation_text(measurement, notation)
    return text if measurement.verdict is None else f"{text} {MARKS[measurement.verdict.quality]}"


def slip_names() -> dict[str, str]:
    """Return the translated name of each sense of slip, keyed by code."""
    return {code: tr(name) for code, name in dict(SENSES).items()}


def extent_points(measurement: Measurement) -> FloatArray:
    """Return (n, 3) World points that span the extent of a feature."""
    fit = measurement.fit
    if fit is None or fit.extent is None or len(measurement.points) > 1:
        return measurement.points
    half_axes = 0.5 * fit.extent * fit.axes[:2]
    return np.concatenate([measurement.points, fit.centroid + half_axes, fit.centroid - half_axes])


def gigabytes_text(size_bytes: float) -> str:
    """Return a number of bytes in gigabytes, with one decimal below 10 GB."""
    value = size_bytes / 1e9
    return f"{value:.1f} GB" if value < 9.95 else f"{value:.0f} GB"


@lru_cache(maxsize=100_000)
def natural_sort_key(name: str) -> tuple[tuple[int, int, str], ...]:
    """Return a key that sorts names by the numbers in them, so that B2 precedes B10."""
    return tuple(
        (0, len(part.lstrip("0")), part.lstrip("0"))
        if part.isdecimal()
        else (1, 0, part.casefold())
        for part in re.split(r"(\d+)", name)
        if part
    )
