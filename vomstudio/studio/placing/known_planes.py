"""Compass readings of planes and lines as observations for the placement of a model."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.geology.notation import parse_line, parse_plane
from vomstudio.geology.quality import governing_half_angles
from vomstudio.geometry import transform
from vomstudio.io.control.observation_tables import CompassTable
from vomstudio.project.kinds import get_kind
from vomstudio.project.kinds.known_line import KnownLine, ReadKind, format_reading
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Model, ModelFeature, Record, get_feature
from vomstudio.registration.results import ModelPlacement

MAX_SIGMA_DEG = 90.0
"""Maximum standard deviation; a larger one leaves the direction undefined."""
SIGMA_SEPARATOR = re.compile(r"\s*(?:±|\+\s*/?\s*[-–−])\s*")
# Radius of the 95 % region of a direction, in standard deviations.
SIGMAS_95 = 2.4477


@dataclass(frozen=True, eq=False)
class ModelDirection:
    """Direction, on the model, of a feature that was also measured with a compass.

    Parameters
    ----------
    direction : (3,) float64
        Direction in the file frame of the model; for a plane, its normal.
    sigma_deg : float or None
        Standard deviation of the direction, degrees; None if unknown.
    """

    direction: FloatArray
    sigma_deg: float | None


def measure_directions(
    lines: Iterable[KnownLine], measurements: Mapping[str, Measurement], model: Model
) -> dict[str, ModelDirection]:
    """Return the directions on the model, keyed by reading id.

    Readings are omitted if their feature is missing or has no orientation.

    Parameters
    ----------
    lines : iterable of KnownLine
    measurements : mapping of str to Measurement
        Measurements of the features, keyed by feature id.
    model : Model
    """
    rows = transform.matrix(model.to_world)
    rotation = rows[:3, :3] / transform.scale_factor(rows)
    directions = {}
    for line in lines:
        measurement = measurements.get(line.feature_id)
        if not line.is_read or measurement is None:
            continue
        world = _direction_vector(measurement, line.kind == "plane")
        if world is not None:
            directions[line.id] = ModelDirection(
                world @ rotation, _direction_sigma(measurement, line.kind == "plane")
            )
    return directions


def _direction_vector(measurement: Measurement, is_plane: bool) -> FloatArray | None:
    """Return the direction (3,) in the World frame, or None if it is undefined."""
    if not is_plane:
        return (
            None if measurement.line is None else np.asarray(measurement.line.vector(), np.float64)
        )
    if measurement.fit is not None:
        return np.asarray(measurement.fit.normal, np.float64)
    return None if measurement.plane is None else np.asarray(measurement.plane.normal(), np.float64)


def _direction_sigma(measurement: Measurement, is_plane: bool) -> float | None:
    """Return the standard deviation of a direction in degrees, or None if unknown."""
    major_deg, minor_deg = measurement.max_confidence95_deg, measurement.min_confidence95_deg
    if is_plane and measurement.fit is not None:
        major_deg, minor_deg = governing_half_angles(
            measurement.fit,
            measurement.verdict_kind,
            measurement.resolution_m,
            measurement.outcrop_normal,
            measurement.stretch_error_deg,
        )
    if major_deg is None or minor_deg is None:
        return None
    return float(np.hypot(major_deg, minor_deg) / np.sqrt(2.0) / SIGMAS_95)


def placement_readings(
    lines: Iterable[KnownLine], directions: Mapping[str, ModelDirection]
) -> list[KnownLine]:
    """Return the complete readings with a known direction that are not used only as checks."""
    return [line for line in lines if line.is_complete and not line.check and line.id in directions]


def compass_table(
    lines: Sequence[KnownLine], directions: Mapping[str, ModelDirection]
) -> CompassTable | None:
    """Return the compass table of the readings used for placement, or None if none is used.

    The errors in the table combine those of the reading and the feature.
    """
    used_placement_readings = placement_readings(lines, directions)
    if not used_placement_readings:
        return None
    return CompassTable(
        tuple(line.name for line in used_placement_readings),
        np.array([line.kind == "plane" for line in used_placement_readings], bool),
        np.array([line.value for line in used_placement_readings], np.float64),
        np.array([line.inclination_deg for line in used_placement_readings], np.float64),
        np.array([directions[line.id].direction for line in used_placement_readings], np.float64),
        np.array(
            [
                _combine_sigmas(line.sigma, directions[line.id].sigma_deg)
                for line in used_placement_readings
            ],
            np.float64,
        ),
    )


def _combine_sigmas(reading_sigma_deg: float | None, feature_sigma_deg: float | None) -> float:
    if reading_sigma_deg is None:
        return float("nan")
    return min(float(np.hypot(reading_sigma_deg, feature_sigma_deg or 0.0)), MAX_SIGMA_DEG)


def residual_deg(
    line: KnownLine, model_direction: ModelDirection, placement: ModelPlacement, turned_deg: float
) -> float:
    """Return the angle between a reading and its direction on the placed model.

    Parameters
    ----------
    line : KnownLine
    model_direction : ModelDirection
        Direction of the reading on the model.
    placement : ModelPlacement
    turned_deg : float
        Correction that is added to the azimuth, degrees.

    Returns
    -------
    float
        Angle in degrees, 0 to 90.
    """
    reading = CompassTable(
        (line.name,),
        np.array([line.kind == "plane"]),
        np.array([(line.value or 0.0) + turned_deg]),
        np.array([line.inclination_deg or 0.0]),
        model_direction.direction[None],
        np.array([np.nan]),
    )
    direction = placed_direction(model_direction, placement)
    cosine = abs(float(reading.vectors()[0] @ direction))
    # Avoids the arc cosine, which is inaccurate for very small angles.
    sine = float(np.linalg.norm(np.cross(reading.vectors()[0], direction)))
    return float(np.degrees(np.arctan2(sine, cosine)))


def placed_direction(model_direction: ModelDirection, placement: ModelPlacement) -> FloatArray:
    """Return a direction on the model as a unit vector (3,) in the World frame."""
    rotation = np.asarray(placement.matrix)[:3, :3] / placement.scale
    return np.asarray(rotation @ model_direction.direction, np.float64)


# --- input of the user ------------------------------------------------------------------------
@dataclass(frozen=True)
class ParsedReading:
    """Compass reading that was parsed from text.

    Parameters
    ----------
    azimuth_deg, inclination_deg : float
        Dip direction and dip of a plane, or trend and plunge of a line.
    sigma_deg : float or None
        Standard deviation, or None if it is not stated.
    """

    azimuth_deg: float
    inclination_deg: float
    sigma_deg: float | None


def parse_reading(text: str, kind: ReadKind, notation: str) -> ParsedReading:
    """Parse a reading such as `213/45 ± 3`; `notation` applies to planes.

    Raises
    ------
    InputError, UsageError
    """
    angles, *error = SIGMA_SEPARATOR.split(text.strip(), maxsplit=1)
    sigma = parse_sigma(error[0]) if error else None
    if kind == "plane":
        plane = parse_plane(angles, notation)
        return ParsedReading(plane.dip_direction_deg, plane.dip_deg, sigma)
    line = parse_line(angles)
    if line.plunge_deg < 0.0:
        raise InputError(Finding("reading.points-up", text=angles))
    return ParsedReading(line.trend_deg, line.plunge_deg, sigma)


def field_text(measurement: Measurement, kind: ReadKind, turned_deg: float, notation: str) -> str:
    """Return a field measurement as the text of a compass reading before correction.

    Field measurements refer to grid north; `turned_deg` is the correction that would be added to
    the reading. Returns "" for a measurement of another kind.
    """
    plane, line = measurement.plane, measurement.line
    if kind == "plane" and plane is not None:
        azimuth, inclination = plane.dip_direction_deg, plane.dip_deg
    elif kind == "lineation" and line is not None:
        azimuth, inclination = line.trend_deg, line.plunge_deg
    else:
        return ""
    azimuth = round((azimuth - turned_deg) % 360.0, 2) % 360.0
    return format_reading(
        KnownLine("", "", kind, "", "", (), azimuth, inclination_deg=inclination), notation
    )


def parse_sigma(text: str) -> float:
    """Parse the standard deviation of a reading in degrees. Raises UsageError."""
    try:
        number = float(text.strip().rstrip("°").replace(",", "."))
    except ValueError:
        number = float("nan")
    if not 0.0 < number <= MAX_SIGMA_DEG:
        raise UsageError(Finding("reading.invalid-error", text=text.strip()))
    return number


def reading_problem(
    record: Record | None, model: Model, measurement: Measurement | None
) -> Finding | None:
    """Return why a record cannot have a compass reading on a model, or None if it can."""
    feature = None if record is None else get_feature({record.id: record}, record.id)
    if feature is None or not get_kind(feature).orientations:
        return Finding("selection.no-feature-read")
    if not isinstance(feature, ModelFeature):
        return Finding("feature.not-on-model", feature=feature.name)
    if feature.model_id != model.id:
        return Finding("feature.on-other-model", feature=feature.name, model=model.name)
    if measurement is None or (measurement.plane is None and measurement.line is None):
        return Finding("feature.no-attitude", feature=feature.name)
    return None


def create_reading(
    feature: Any,
    measurement: Measurement,
    parsed_reading: ParsedReading,
    other_names: Iterable[str],
) -> KnownLine:
    """Create the record of a reading; `other_names` are the names that are in use."""
    return KnownLine(
        new_id("reading"),
        _unique_name(feature.name, set(other_names)),
        reading_kind(measurement),
        feature.model_id,
        feature.model_hash,
        (),
        parsed_reading.azimuth_deg,
        parsed_reading.sigma_deg,
        inclination_deg=parsed_reading.inclination_deg,
        feature_id=feature.id,
    )


def reading_kind(measurement: Measurement) -> ReadKind:
    """Return the kind of a reading of this feature: a plane or a line."""
    return "plane" if measurement.line is None else "lineation"


def _unique_name(name: str, used_names: set[str]) -> str:
    """Return the name of the feature, with a number if the name is already in use."""
    return next(
        unused_name
        for n in range(1, len(used_names) + 2)
        if (unused_name := name if n == 1 else f"{name} ({n})") not in used_names
    )
