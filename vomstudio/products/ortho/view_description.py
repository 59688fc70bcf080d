"""Text descriptions of the viewing direction of an orthophoto."""

from __future__ import annotations

import math

from vomstudio.core.words import tr
from vomstudio.geology.notation import format_azimuth, format_wind
from vomstudio.geometry.vectors import wrap360
from vomstudio.geometry.view_frame import STEEP_DEG
from vomstudio.products.ortho.view_directions import ViewDirection


def end_labels(view: ViewDirection) -> tuple[str, str, str]:
    """Return the labels for the left end, the right end, and the upward arrow."""
    frame = view.frame
    azimuth = wrap360(math.degrees(math.atan2(frame.right[0], frame.right[1])))
    steep = abs(view.plunge_deg) >= STEEP_DEG
    if not view.north_known:
        left_text, right_text = (
            tr("{azimuth:03d}, local", azimuth=round(a) % 360) for a in (azimuth + 180.0, azimuth)
        )
        return left_text, right_text, "y" if steep else tr("up")
    return format_wind(azimuth + 180.0), format_wind(azimuth), "N" if steep else tr("up")


def direction_text(view: ViewDirection) -> str:
    """Describe the viewing direction and its sense."""
    trend = format_azimuth(view.trend_deg, 1)
    return tr(
        "View toward {trend}/{plunge:.1f} (trend/plunge, °), {sense}",
        trend=trend,
        plunge=view.plunge_deg,
        sense=tr(view.sense),
    )


def unknown_direction_text(view: ViewDirection) -> str | None:
    """Describe the unknown properties of an unregistered model, or return None if none."""
    if view.north_known:
        return None if view.metric else tr("Not registered: scale unknown")
    if view.metric:
        return tr("Not registered: north unknown")
    return tr("Not registered: north and scale unknown")
