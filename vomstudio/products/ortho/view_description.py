"""Text descriptions of the viewing direction of an orthophoto."""

from __future__ import annotations

import math

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import tr
from vomstudio.geology.notation import format_azimuth, format_compass_point
from vomstudio.geometry.vectors import wrap360
from vomstudio.geometry.view_frame import MIN_STEEP_DEG, ROUNDING_DEG
from vomstudio.products.ortho.view_directions import AS_GIVEN, ViewDirection

MAX_UPRIGHT_PLUNGE_DEG = 45.0
"""Maximum plunge for the label *up*; in steeper views, the upward arrow shows its azimuth."""


def end_labels(view: ViewDirection) -> tuple[str, str, str]:
    """Return the labels for the left end, the right end, and the upward arrow."""
    right = view.frame.right
    up_text = tr("up")
    if abs(view.plunge_deg) >= MIN_STEEP_DEG:
        up_text = "N" if view.is_north_known else "y"
    elif _is_map_like(view):
        up_text = _direction_label(view, -view.frame.down)
    return _direction_label(view, -right), _direction_label(view, right), up_text


def _is_map_like(view: ViewDirection) -> bool:
    return abs(view.plunge_deg) > MAX_UPRIGHT_PLUNGE_DEG + ROUNDING_DEG


def _direction_label(view: ViewDirection, direction: FloatArray) -> str:
    azimuth = _azimuth_deg(direction)
    if view.is_north_known:
        return format_compass_point(azimuth)
    return tr("{azimuth:03d}, local", azimuth=round(azimuth) % 360)


def _azimuth_deg(direction: FloatArray) -> float:
    return wrap360(math.degrees(math.atan2(direction[0], direction[1])))


def axis_labels(view: ViewDirection, unit: str) -> tuple[str, str]:
    """Return the labels of the horizontal and the vertical axis of a picture.

    Parameters
    ----------
    view : ViewDirection
    unit : str

    Returns
    -------
    (str, str)
    """
    if not view.is_north_known:
        horizontal_title = tr("distance ({unit})", unit=unit)
        if _is_map_like(view):
            return horizontal_title, horizontal_title
        return horizontal_title, tr("distance up ({unit})", unit=unit)
    horizontal_title = _distance_label(view.frame.right, unit)
    if _is_map_like(view):
        return horizontal_title, _distance_label(-view.frame.down, unit)
    return horizontal_title, tr("distance up ({unit})", unit=unit)


def _distance_label(direction: FloatArray, unit: str) -> str:
    wind = format_compass_point(_azimuth_deg(direction)).partition(" ")[0]
    return tr("distance toward {direction} ({unit})", direction=wind, unit=unit)


def direction_text(view: ViewDirection) -> str:
    """Describe the viewing direction, and the sense in which an axis is viewed."""
    trend = format_azimuth(view.trend_deg, 1)
    if view.sense == AS_GIVEN:
        return tr(
            "View toward {trend}/{plunge:.1f} (trend/plunge, °)",
            trend=trend,
            plunge=view.plunge_deg,
        )
    return tr(
        "View toward {trend}/{plunge:.1f} (trend/plunge, °), {sense}",
        trend=trend,
        plunge=view.plunge_deg,
        sense=tr(view.sense),
    )


def unknown_direction_text(view: ViewDirection) -> str | None:
    """Describe the unknown properties of an unregistered model; None if all are known."""
    if view.is_north_known:
        return None if view.is_metric else tr("Not registered: scale unknown")
    if view.is_metric:
        return tr("Not registered: north unknown")
    return tr("Not registered: north and scale unknown")
