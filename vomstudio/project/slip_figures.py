"""Figures of slip: the line in its plane, the sense of movement, and the plane itself.

The catalogue lists them in the order of `SLIP`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from vomstudio.core.words import to_translate as _
from vomstudio.core.words import tr
from vomstudio.geology.slip import CONFIDENCES, SENSES
from vomstudio.project.figures import Subject, figure_in_degrees, text_figure
from vomstudio.project.records import Feature


def _sense(subject: Subject) -> str | None:
    return getattr(subject.feature, "slip", None) or None


def _sense_text(subject: Subject) -> str:
    sense = _sense(subject)
    return "" if sense is None else tr({str(code): text for code, text in SENSES}[sense])


def _confidence(subject: Subject) -> str | None:
    """Return the confidence of the sense of slip, or None if the sense was removed."""
    return getattr(subject.feature, "slip_confidence", None) or None if _sense(subject) else None


def _confidence_text(subject: Subject) -> str:
    confidence = _confidence(subject)
    return (
        ""
        if confidence is None
        else tr({str(code): text for code, text in CONFIDENCES}[confidence])
    )


def _plane_name(subject: Subject) -> str | None:
    host = subject.records.get(getattr(subject.feature, "plane_id", ""))
    return (host.name or host.id) if isinstance(host, Feature) else None


def _plane_attribute(name: str) -> Callable[[Subject], Any]:
    return lambda subject: (
        None if subject.measured.on_plane is None else getattr(subject.measured.on_plane, name)
    )


RAKE = figure_in_degrees(
    "rake_deg",
    _("Rake"),
    _("Rake of a line in its plane: 0 to 180 from the right-hand-rule strike, 90 down dip"),
    lambda subject: subject.measured.rake_deg,
    "angle",
    short="rake",
    words=("rake",),
)
SLIP_RAKE = figure_in_degrees(
    "slip_rake_deg",
    _("Slip rake"),
    _("Rake of the hanging wall's motion: -180 to 180, positive if reverse, 0 sinistral"),
    lambda subject: subject.measured.slip_rake_deg,
    "angle",
    short="slip_rake",
    words=("slip_rake",),
)
SLIP_SENSE = text_figure(
    "slip_sense",
    _("Slip"),
    _("Sense of slip as seen on the plane: normal, reverse, sinistral or dextral"),
    _sense,
    short="slip_sense",
    words=("slip",),
    format_text=_sense_text,
)
SLIP_CONFIDENCE = text_figure(
    "slip_confidence",
    _("Confidence"),
    _("Confidence in the sense of slip: certain, probable or supposed"),
    _confidence,
    short="slip_conf",
    words=("slip_confidence",),
    format_text=_confidence_text,
)
ON_PLANE = text_figure(
    "on_plane",
    _("On plane"),
    _("Plane that contains the line"),
    _plane_name,
    short="on_plane",
    words=("on_plane",),
)
ON_PLANE_DIP_DIRECTION = figure_in_degrees(
    "on_plane_dip_direction_deg",
    _("Its dip dir."),
    _("Dip direction of the plane that contains the line"),
    _plane_attribute("dip_direction_deg"),
    "azimuth",
    short="onplane_dd",
)
ON_PLANE_DIP = figure_in_degrees(
    "on_plane_dip_deg",
    _("Its dip"),
    _("Dip of the plane that contains the line"),
    _plane_attribute("dip_deg"),
    "angle",
    short="onplanedip",
)

SLIP = (
    RAKE,
    SLIP_RAKE,
    SLIP_SENSE,
    SLIP_CONFIDENCE,
    ON_PLANE,
    ON_PLANE_DIP_DIRECTION,
    ON_PLANE_DIP,
)
