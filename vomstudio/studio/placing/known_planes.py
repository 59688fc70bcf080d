"""Planes and lines of a project that were read by compass, as observations of a model's place."""

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
from vomstudio.geology.quality import wider_of
from vomstudio.geometry import transform
from vomstudio.io.control.observation_tables import CompassTable
from vomstudio.project.kinds import kind_of
from vomstudio.project.kinds.known_line import KnownLine, ReadKind, format_reading
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Model, OnAModel, Record, get_feature
from vomstudio.registration.results import Placed

MOST_DEG = 90.0
"""An error that is larger says nothing of a direction."""
_WITH_ERROR = re.compile(r"\s*(?:±|\+\s*/?\s*[-–−])\s*")
# The 95 % region of a direction reaches so many of its sigmas.
_REACH_95 = 2.4477


@dataclass(frozen=True, eq=False)
class OnModel:
    """What a reading is of, as the model shows it. direction : (3,) in the frame of the model's
    file, the normal of a plane; sigma_deg : its own error there, one sigma, None where not known"""

    direction: FloatArray
    sigma_deg: float | None


def directions_of(
    lines: Iterable[KnownLine], measured: Mapping[str, Measurement], model: Model
) -> dict[str, OnModel]:
    """Of the planes and lines that were read, by the id of the reading; without those that are gone
    or have no orientation. measured : the features that they are, by their own ids"""
    rows = transform.matrix(model.to_world)
    turn = rows[:3, :3] / transform.scale_of(rows)
    found = {}
    for line in lines:
        seen = measured.get(line.feature_id)
        if not line.is_read or seen is None:
            continue
        world = _direction(seen, line.kind == "plane")
        if world is not None:
            found[line.id] = OnModel(world @ turn, _own_error(seen, line.kind == "plane"))
    return found


def _direction(measured: Measurement, plane: bool) -> FloatArray | None:
    """(3,) World."""
    if not plane:
        return None if measured.line is None else np.asarray(measured.line.vector(), np.float64)
    if measured.fit is not None:
        return np.asarray(measured.fit.normal, np.float64)
    return None if measured.plane is None else np.asarray(measured.plane.normal(), np.float64)


def _own_error(measured: Measurement, plane: bool) -> float | None:
    """One sigma, degrees, of both directions alike."""
    largest, smallest = measured.max_confidence95_deg, measured.min_confidence95_deg
    if plane and measured.fit is not None:
        largest, smallest = wider_of(
            measured.fit,
            measured.judged_as,
            measured.resolution_m,
            measured.outcrop_normal,
            measured.stretch_error_deg,
        )
    if largest is None or smallest is None:
        return None
    return float(np.hypot(largest, smallest) / np.sqrt(2.0) / _REACH_95)


def placing(lines: Iterable[KnownLine], seen: Mapping[str, OnModel]) -> list[KnownLine]:
    """Those that place a model: the model shows what was read, and they do not only judge."""
    return [line for line in lines if line.is_complete and not line.check and line.id in seen]


def compass_table(lines: Sequence[KnownLine], seen: Mapping[str, OnModel]) -> CompassTable | None:
    """The readings that place a model as the table of the command has them; None without any. A
    stated error is that of the reading and that of the feature together."""
    used = placing(lines, seen)
    if not used:
        return None
    return CompassTable(
        tuple(line.name for line in used),
        np.array([line.kind == "plane" for line in used], bool),
        np.array([line.value for line in used], np.float64),
        np.array([line.inclination_deg for line in used], np.float64),
        np.array([seen[line.id].direction for line in used], np.float64),
        np.array([_together(line.sigma, seen[line.id].sigma_deg) for line in used], np.float64),
    )


def _together(reading_deg: float | None, feature_deg: float | None) -> float:
    if reading_deg is None:
        return float("nan")
    return min(float(np.hypot(reading_deg, feature_deg or 0.0)), MOST_DEG)


def miss_deg(line: KnownLine, seen: OnModel, placed: Placed, turned_deg: float) -> float:
    """The angle between what was read and what the placed model shows, 0 to 90 degrees. turned_deg
    : added to the azimuth that was read"""
    one = CompassTable(
        (line.name,),
        np.array([line.kind == "plane"]),
        np.array([(line.value or 0.0) + turned_deg]),
        np.array([line.inclination_deg or 0.0]),
        seen.direction[None],
        np.array([np.nan]),
    )
    there = placed_direction(seen, placed)
    cosine = abs(float(one.vectors()[0] @ there))
    # An angle that is nearly nought is lost in its cosine.
    across = float(np.linalg.norm(np.cross(one.vectors()[0], there)))
    return float(np.degrees(np.arctan2(across, cosine)))


def placed_direction(seen: OnModel, placed: Placed) -> FloatArray:
    """(3,) World, a unit vector."""
    turn = np.asarray(placed.matrix)[:3, :3] / placed.scale
    return np.asarray(turn @ seen.direction, np.float64)


# --- what is typed ----------------------------------------------------------------------------
@dataclass(frozen=True)
class Typed:
    """azimuth_deg, inclination_deg : of a plane dip direction and dip, of a line trend and plunge
    sigma_deg : None where not typed"""

    azimuth_deg: float
    inclination_deg: float
    sigma_deg: float | None


def typed_reading(text: str, kind: ReadKind, notation: str) -> Typed:
    """What a text such as `213/45 ± 3` says, with two bare numbers of a plane in the notation.
    Raises InputError and UsageError."""
    said, *error = _WITH_ERROR.split(text.strip(), maxsplit=1)
    sigma = typed_sigma(error[0]) if error else None
    if kind == "plane":
        plane = parse_plane(said, notation)
        return Typed(plane.dip_direction_deg, plane.dip_deg, sigma)
    line = parse_line(said)
    if line.plunge_deg < 0.0:
        raise InputError(Finding("reading.points-up", text=said))
    return Typed(line.trend_deg, line.plunge_deg, sigma)


def field_text(measured: Measurement, kind: ReadKind, turned_deg: float, notation: str) -> str:
    """A reading of the field book, which is counted from grid north, as it would have been read
    where `turned_deg` is added; "" where it is not of this kind."""
    plane, line = measured.plane, measured.line
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


def typed_sigma(text: str) -> float:
    """The error of a reading in degrees. Raises UsageError."""
    try:
        number = float(text.strip().rstrip("°").replace(",", "."))
    except ValueError:
        number = float("nan")
    if not 0.0 < number <= MOST_DEG:
        raise UsageError(Finding("reading.invalid-error", text=text.strip()))
    return number


def why_not_read(
    record: Record | None, model: Model, measured: Measurement | None
) -> Finding | None:
    """Return why a record cannot be read by compass on a model; None if it can."""
    feature = None if record is None else get_feature({record.id: record}, record.id)
    if feature is None or not kind_of(feature).orientations:
        return Finding("selection.no-feature-read")
    if not isinstance(feature, OnAModel):
        return Finding("feature.not-on-model", feature=feature.name)
    if feature.model_id != model.id:
        return Finding("feature.on-other-model", feature=feature.name, model=model.name)
    if measured is None or (measured.plane is None and measured.line is None):
        return Finding("feature.no-attitude", feature=feature.name)
    return None


def reading_of(
    feature: Any, measured: Measurement, typed: Typed, others: Iterable[str]
) -> KnownLine:
    """The record of a reading of a feature. others : names that are taken"""
    return KnownLine(
        new_id("reading"),
        _name(feature.name, set(others)),
        kind_read(measured),
        feature.model_id,
        feature.model_hash,
        (),
        typed.azimuth_deg,
        typed.sigma_deg,
        inclination_deg=typed.inclination_deg,
        feature_id=feature.id,
    )


def kind_read(measured: Measurement) -> ReadKind:
    """Whether what was read of a feature is a plane, or a line."""
    return "plane" if measured.line is None else "lineation"


def _name(name: str, taken: set[str]) -> str:
    """That of the feature, which a geologist knows; a number where it was read before."""
    return next(
        each
        for n in range(1, len(taken) + 2)
        if (each := name if n == 1 else f"{name} ({n})") not in taken
    )
