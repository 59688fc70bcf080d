"""Text descriptions of the viewing direction of an orthophoto."""

from __future__ import annotations

import math

from vomstudio.core.words import tr
from vomstudio.geology.notation import format_azimuth, format_wind
from vomstudio.geometry.vectors import wrap360
from vomstudio.geometry.view_frame import STEEP_DEG
from vomstudio.products.ortho.view_directions import AS_GIVEN, ViewDirection


def end_labels(view: ViewDirection) -> tuple[str, str, str]:
    """Return the labels for the left end, the right end, and the upward arrow."""
    azimuth = _right_azimuth(view)
    is_steep = abs(view.plunge_deg) >= STEEP_DEG
    if not view.is_north_known:
        left_text, right_text = (
            tr("{azimuth:03d}, local", azimuth=round(a) % 360) for a in (azimuth + 180.0, azimuth)
        )
        return left_text, right_text, "y" if is_steep else tr("up")
    return format_wind(azimuth + 180.0), format_wind(azimuth), "N" if is_steep else tr("up")


def _right_azimuth(view: ViewDirection) -> float:
    right = view.frame.right
    return wrap360(math.degrees(math.atan2(right[0], right[1])))


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
    horizontal_title = tr("distance ({unit})", unit=unit)
    vertical_title = tr("distance up ({unit})", unit=unit)
    if view.is_north_known:
        wind = format_wind(_right_azimuth(view)).partition(" ")[0]
        horizontal_title = tr("distance toward {direction} ({unit})", direction=wind, unit=unit)
    if view.frame.is_vertical:
        vertical_title = (
            tr("distance toward N ({unit})", unit=unit) if view.is_north_known else horizontal_title
        )
    return horizontal_title, vertical_title


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
    """Describe the unknown properties of an unregistered model, or return None if none."""
    if view.is_north_known:
        return None if view.is_metric else tr("Not registered: scale unknown")
    if view.is_metric:
        return tr("Not registered: north unknown")
    return tr("Not registered: north and scale unknown")
