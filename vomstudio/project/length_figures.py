"""Figures of lengths and areas measured on a model, and their texts.

Kinds without an orientation list their figures in `project/kinds`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import floor, hypot, log10
from typing import Any

from vomstudio.core.words import to_translate as _
from vomstudio.core.words import tr
from vomstudio.geology.notation import format_attitude
from vomstudio.geology.orientation import Line
from vomstudio.geometry.units import area_text, length_text
from vomstudio.project import catalogue as of
from vomstudio.project.figures import Figure, Subject
from vomstudio.project.measurement import Measurement

MAX_LENGTH_DIGITS = 6
"""Maximum number of significant digits of a length."""


def _registration_error_name(quantity: str) -> str:
    name, unit = quantity.rsplit("_", 1)
    return f"{name}_registration95_{unit}"


def _thickness_error(figures: Mapping[str, float]) -> float | None:
    """Return the 95 % error of a thickness, including that of the registration if known.

    Returns None if it is unknown.
    """
    error = figures.get("thickness_total95_m")
    return figures.get("thickness_error95_m") if error is None else error


def _find_error(name: str, figures: Mapping[str, float]) -> float | None:
    """Return the 95 % error of a figure with all known parts, or None if it is unknown."""
    if name == "thickness_m":
        return _thickness_error(figures)
    distance_error = figures.get("distance_error95_m") if name == "distance_m" else None
    return figures.get(_registration_error_name(name)) if distance_error is None else distance_error


def _format_with_error(value: float, error: float | None, *, is_metric: bool) -> str:
    """Format a length with its error, rounded to the last digit of the error."""
    if not error:
        return length_text(value, is_metric=is_metric)
    digits = 3
    if value > 0.0:
        digits = floor(log10(value)) - floor(log10(error)) + 2
    text = length_text(value, min(max(digits, 3), MAX_LENGTH_DIGITS), is_metric=is_metric)
    return f"{text} ± {length_text(error, 2, is_metric=is_metric)}"


def _direction(figures: Mapping[str, float]) -> str:
    """Format the direction of a distance with its 95 % error if it is known."""
    parts = ("direction_points95_deg", "direction_registration95_deg")
    errors = [figures[name] for name in parts if name in figures]
    line = Line(figures["trend_deg"], figures["plunge_deg"])
    return format_attitude(line, hypot(*errors) if errors else None)


def _area(figures: Mapping[str, float], *, is_metric: bool) -> str:
    text = area_text(figures["area_m2"], is_metric=is_metric)
    error = figures.get(_registration_error_name("area_m2"))
    return text if error is None else f"{text} ± {area_text(error, is_metric=is_metric)}"


# The main figure of a dimension is the first of these that it has.
_HEADLINE_ORDER: tuple[str, ...] = ("thickness_m", "area_m2", "length_m", "distance_m")


def headline(measurement: Measurement) -> str | None:
    """Return the main figure of a dimension with its error, or None if it has no figures."""
    figures, metric = measurement.dimension, measurement.metric
    if not figures:
        return None
    for name in _HEADLINE_ORDER:
        if name in figures:
            if name == "area_m2":
                return _area(figures, is_metric=metric)
            return _format_with_error(figures[name], _find_error(name, figures), is_metric=metric)
    return "–"


def words(measurement: Measurement) -> list[str]:
    """Return the figures of a dimension as text, the main one first."""
    figures = measurement.dimension or {}

    def length(value: float, digits: int = 3) -> str:
        return length_text(value, digits, is_metric=measurement.metric)

    def length_with_error(name: str) -> str:
        error = _find_error(name, figures)
        return _format_with_error(abs(figures[name]), error, is_metric=measurement.metric)

    lines = []
    if (value := figures.get("thickness_m")) is not None:
        error = _thickness_error(figures)
        lines.append(
            tr("Thickness {length}, 95 % error unknown", length=length(value))
            if error is None
            else tr(
                "Thickness {length}, 95 % error ± {error}",
                length=length(value),
                error=length(error, 2),
            )
        )
        if (registered := figures.get("thickness_registration95_m")) is not None:
            lines.append(tr("Due to registration ± {error}", error=length(registered, 2)))
    if "area_m2" in figures:
        lines.append(_area(figures, is_metric=measurement.metric))
    for name, text in (
        ("length_m", _("Length along the line {length}")),
        ("distance_m", _("Distance {length}")),
        ("perimeter_m", _("Perimeter {length}")),
    ):
        if name in figures:
            lines.append(tr(text, length=length_with_error(name)))
    if "horizontal_m" in figures:
        up = figures["vertical_m"]
        lines.append(
            tr(
                "Horizontal {horizontal}, upward {vertical}"
                if up >= 0.0
                else "Horizontal {horizontal}, downward {vertical}",
                horizontal=length_with_error("horizontal_m"),
                vertical=length_with_error("vertical_m"),
            )
        )
    if "trend_deg" in figures:
        lines.append(tr("Trend/plunge {direction}", direction=_direction(figures)))
    if any(_registration_error_name(name) in figures for name in ("area_m2", "distance_m")):
        lines.append(tr("± includes the 95 % error of the registration."))
    return lines


def figure_value(name: str) -> Callable[[Subject], Any]:
    """Return a function for one figure of the dimension of a subject."""
    return lambda subject: (subject.measured.dimension or {}).get(name)


def length_figure(name: str, title: str, explanation: str, short: str = "") -> Figure:
    """Create a figure of a dimension, in metres."""
    return Figure(name, title, explanation, figure_value(name), "length", "m", short=short)


AREA = replace(of.AREA, explanation=_("Area inside the points"), value=figure_value("area_m2"))
AREA_REGISTRATION = Figure(
    "area_registration95_m2",
    _("Reg. ± area"),
    _("95 % error of the area due to the registered scale"),
    figure_value("area_registration95_m2"),
    "area",
    "m2",
    short="reg_area",
)
LENGTH = replace(
    length_figure("length_m", _("Length"), _("Length of the line through all points")),
    words=("length",),
)
LENGTH_REGISTRATION = length_figure(
    "length_registration95_m",
    _("Reg. ± length"),
    _("95 % error of the length due to the registered scale"),
    short="reg_length",
)
PERIMETER = length_figure("perimeter_m", _("Perimeter"), _("Perimeter of the area"))
PERIMETER_REGISTRATION = length_figure(
    "perimeter_registration95_m",
    _("Reg. ± perim."),
    _("95 % error of the perimeter due to the registered scale"),
    short="reg_perime",
)
