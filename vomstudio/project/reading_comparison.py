"""Comparison of compass readings with picks on the model, in degrees."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import angle_between_lines, angle_between_planes
from vomstudio.project.figures import Subject
from vomstudio.project.kind import get_kind
from vomstudio.project.measurement import Measurement, NearestPick
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import Feature, Model, ModelFeature, Record, TypedFeature, get

__all__ = ["NearestPick", "nearest_picks", "summary"]


@dataclass(frozen=True, eq=False)
class _Picks:
    """Picks of one type and geometry.

    The vectors are (n, 3). The points (m, 3) belong to the vectors with the row numbers `owner`
    (m,).
    """

    features: list[Feature]
    vectors: FloatArray
    points: FloatArray
    owner: IntArray
    measured: Mapping[str, Measurement]


def nearest_picks(
    records: Mapping[str, Record], measurements: Measurements
) -> dict[str, NearestPick]:
    """Return the nearest pick for each reading that has a counterpart.

    Planes are compared with picked planes of the same type, and lines with lines. Picks on a model
    without a north reference have no geographic direction and are excluded.
    """
    features = [record for record in records.values() if isinstance(record, TypedFeature)]
    readings = [feature for feature in features if get_kind(feature).evidence == "read"]
    if not readings:
        return {}
    measurements_by_id = measurements.of(records, [reading.id for reading in readings])
    groups: dict[tuple[str, bool], list[TypedFeature]] = {}
    for reading in readings:
        is_plane = measurements_by_id[reading.id].plane is not None
        groups.setdefault((reading.type_id, is_plane), []).append(reading)
    result: dict[str, NearestPick] = {}
    for (type_id, is_plane), group in groups.items():
        picks = _find_picks(
            records,
            measurements,
            [feature for feature in features if feature.type_id == type_id],
            is_plane,
        )
        if picks is not None:
            result |= _compare(group, measurements_by_id, picks)
    return result


def _find_picks(
    records: Mapping[str, Record],
    measurements: Measurements,
    candidates: Sequence[TypedFeature],
    is_plane: bool,
) -> _Picks | None:
    nature = "plane" if is_plane else "line"
    features = [
        candidate
        for candidate in candidates
        if (kind := get_kind(candidate)).evidence == "picked"
        and nature in kind.orientations
        and isinstance(candidate, ModelFeature)
        and (model := get(records, candidate.model_id, Model)) is not None
        and model.frame.has_north
    ]
    measurements_by_id = measurements.of(records, [feature.id for feature in features])
    features = [
        feature for feature in features if _vector(measurements_by_id[feature.id]) is not None
    ]
    if not features:
        return None
    vectors = np.array([_vector(measurements_by_id[feature.id]) for feature in features])
    points = [
        get_kind(feature).places(Subject(feature, measurements_by_id[feature.id], records))
        for feature in features
    ]
    owner = np.repeat(np.arange(len(features)), [len(point) for point in points])
    return _Picks(list(features), vectors, np.concatenate(points), owner, measurements_by_id)


def _compare(
    readings: Sequence[Feature], measurements: Mapping[str, Measurement], picks: _Picks
) -> dict[str, NearestPick]:
    from scipy.spatial import cKDTree

    tree = cKDTree(picks.points)
    result = {}
    for reading in readings:
        measurement = measurements[reading.id]
        vector = _vector(measurement)
        if vector is None:
            continue
        distance: float | None = None
        if len(measurement.points):
            distance_m, point = tree.query(measurement.points[0])
            row, distance = int(picks.owner[point]), float(distance_m)
        else:
            row = int(np.argmax(np.abs(picks.vectors @ vector)))
        pick = picks.features[row]
        angle = _angle_deg(measurement, picks.measured[pick.id])
        result[reading.id] = NearestPick(pick.id, pick.name, angle, distance)
    return result


def _angle_deg(a: Measurement, b: Measurement) -> float:
    if a.plane is not None and b.plane is not None:
        return angle_between_planes(a.plane, b.plane)
    assert a.line is not None
    assert b.line is not None
    return angle_between_lines(a.line, b.line)


def _vector(measurement: Measurement) -> FloatArray | None:
    if measurement.plane is not None:
        return measurement.plane.normal()
    return None if measurement.line is None else measurement.line.vector()


def summary(readings: list[str], picks: Mapping[str, NearestPick]) -> Finding:
    """Return a finding about the agreement between readings and picks."""
    n = len(readings)
    angles = [picks[i].angle_deg for i in readings if i in picks]
    if not angles:
        return Finding("readings.no-picks", count=n)
    return Finding(
        "readings.compared", count=n, compared=len(angles), median_deg=float(np.median(angles))
    )
