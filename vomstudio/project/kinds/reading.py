"""Orientation measured in the field with a compass, referred to grid north."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate as _
from vomstudio.core.words import tr
from vomstudio.geology.notation import format_error_deg
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geometry.matrices import Point
from vomstudio.geometry.units import length_text
from vomstudio.project import catalogue as of
from vomstudio.project import kind
from vomstudio.project.figures import Subject
from vomstudio.project.kind import Kind, Lookup, NetAppearance, Sketch, centre
from vomstudio.project.measurement import Measurement, MeasurementContext, NearestPick
from vomstudio.project.records import TypedFeature


@dataclass(frozen=True)
class Reading(TypedFeature):
    """Compass reading.

    Attributes
    ----------
    azimuth_deg, inclination_deg : float
        Dip direction and dip of a plane, or trend and plunge of a line.
    turned_deg : float
        Correction added to the azimuth that was read (declination minus convergence).
    position : Point or None
        Position in the World frame, or None if it was not recorded.
    source : str
        File that contains the reading.
    station : str
        Number of the station of the reading, or "". A station can have any number of readings.
    """

    id: str
    name: str
    type_id: str
    geometry: Literal["plane", "line"]
    azimuth_deg: float
    inclination_deg: float
    turned_deg: float = 0.0
    position: Point | None = None
    source: str = ""
    set_name: str = ""
    overturned: bool = False
    notes: str = ""
    domain: str = ""
    station: str = ""


def measure(context: MeasurementContext, readings: Sequence[Reading]) -> list[Measurement]:
    """Measure compass readings."""
    return [_measure(reading) for reading in readings]


def _measure(reading: Reading) -> Measurement:
    points = np.array([] if reading.position is None else [reading.position], float).reshape(-1, 3)
    azimuth, inclination = reading.azimuth_deg, reading.inclination_deg
    return Measurement(
        points,
        None,
        None,
        None,
        None,
        None,
        plane=Plane(azimuth, inclination) if reading.geometry == "plane" else None,
        line=Line(azimuth, inclination) if reading.geometry == "line" else None,
        kind="reading",
    )


def is_plane(reading: Reading) -> bool:
    """Return whether a reading is a plane."""
    return reading.geometry == "plane"


def sketch(subject: Subject, measurements: Lookup) -> Sketch | None:
    """Return the drawing of a reading at its position, or None if this was not recorded."""
    if not len(subject.measured.points):
        return None
    midpoint = centre(subject.measured)
    return Sketch(subject.measured.points, midpoint, sign=midpoint)


def remarks(subject: Subject) -> list[str]:
    """Return the azimuth correction and the angle to the nearest pick."""
    reading: Reading = subject.feature
    lines = []
    if reading.turned_deg:
        lines.append(tr("azimuth as read {turned_deg:+.2f} deg", turned_deg=reading.turned_deg))
    nearest_pick = subject.nearest()
    if nearest_pick is not None:
        place = (
            ""
            if nearest_pick.distance_m is None
            else tr(", {distance_m:.2f} m away", distance_m=nearest_pick.distance_m)
        )
        lines.append(
            tr(
                "{angle_deg:.1f} deg from {nearest}{place}",
                angle_deg=nearest_pick.angle_deg,
                nearest=nearest_pick.name,
                place=place,
            )
        )
    return lines


def comparison_finding(nearest: NearestPick | None) -> Finding:
    """Return the finding about the angle and distance to the nearest pick.

    Parameters
    ----------
    nearest : NearestPick or None

    Returns
    -------
    Finding
    """
    if nearest is None:
        return Finding("reading.no-pick")
    values = {
        "angle": format_error_deg(nearest.angle_deg),
        "angle_deg": nearest.angle_deg,
        "pick": nearest.name,
    }
    if nearest.distance_m is None:
        return Finding("reading.similar-pick", **values)
    return Finding(
        "reading.nearest-pick",
        **values,
        distance=length_text(nearest.distance_m),
        distance_m=nearest.distance_m,
    )


def about(subject: Subject) -> list[str]:
    """Describe a reading and the nearest pick of its type."""
    reading: Reading = subject.feature
    lines = [comparison_finding(subject.nearest()).message]
    if reading.turned_deg:
        lines.append(Finding("reading.turned", turned_deg=reading.turned_deg).message)
    if reading.source:
        lines.append(tr("From {source}", source=reading.source))
    return lines


KIND = Kind(
    name="reading",
    order=60,
    record=Reading,
    title=_("Reading"),
    icon="compass-outline",
    measure=measure,
    figures=(
        *of.NAME_FIGURES,
        of.STATION,
        *of.PLANE,
        of.TREND,
        of.PLUNGE,
        of.OVERTURNED,
        *of.PLACE,
        replace(of.METHOD, value=lambda subject: "compass"),
        of.FRAME,
        of.ANGLE_TO_PICK,
        *of.VERDICT,
        of.NOTES,
    ),
    attributes=(
        kind.NAME,
        kind.TYPE,
        kind.SET,
        kind.STATION,
        kind.DOMAIN,
        kind.OVERTURNED,
        kind.NOTES,
    ),
    sketch=sketch,
    remarks=remarks,
    about=about,
    orientations=("plane", "line"),
    evidence="read",
    plane=is_plane,
    net=NetAppearance(" (compass)", "P"),
)
