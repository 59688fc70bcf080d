"""Compass readings beside what was picked on the model: how far apart they are, in degrees."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.document.measurements import Measurement, Measurements
from vomstudio.document.records import IDENTITY, Lineation, Model, Patch, Reading, Record, Trace
from vomstudio.geology.orientation import angle_between_lines, angle_between_planes
from vomstudio.geometry import transform

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class NearestPick:
    """The pick of a reading's type to which it is compared.

    angle_deg: between the two planes or lines, axial, 0 to 90. distance_m: from the reading's
    place to the nearest point of the pick; None where the reading has no place: then the pick is
    the one with the smallest angle.
    """

    pick_id: str
    name: str
    angle_deg: float
    distance_m: float | None


@dataclass(frozen=True, eq=False)
class _Picks:
    """Picks of one type and geometry. vectors (n, 3); points (m, 3), owner (m,) rows of vectors."""

    features: list[Trace | Patch | Lineation]
    vectors: Floats
    points: Floats
    owner: npt.NDArray[np.int64]
    measured: Mapping[str, Measurement]


def nearest_picks(
    records: Mapping[str, Record], measurements: Measurements
) -> dict[str, NearestPick]:
    """For each reading that has a counterpart: planes are compared with traces and patches of the
    same type, lines with lineations. Picks on a model whose north is not known are left out: they
    have no geographic direction."""
    readings = [r for r in records.values() if isinstance(r, Reading)]
    result: dict[str, NearestPick] = {}
    groups: dict[tuple[str, str], list[Reading]] = {}
    for reading in readings:
        groups.setdefault((reading.type_id, reading.geometry), []).append(reading)
    for (type_id, geometry), own in groups.items():
        picks = _picks(records, measurements, type_id, geometry)
        if picks is not None:
            measured = measurements.of(records, [r.id for r in own])
            result |= _compare(own, measured, picks)
    return result


def _picks(
    records: Mapping[str, Record], measurements: Measurements, type_id: str, geometry: str
) -> _Picks | None:
    wanted = (Trace, Patch) if geometry == "plane" else (Lineation,)
    features = [
        r
        for r in records.values()
        if isinstance(r, wanted)
        and r.type_id == type_id
        and isinstance(model := records.get(r.model_id), Model)
        and model.frame.has_north
    ]
    measured = measurements.of(records, [f.id for f in features])
    features = [f for f in features if _vector(measured[f.id]) is not None]
    if not features:
        return None
    vectors = np.array([_vector(measured[f.id]) for f in features])
    points = [_points(records, f, measured[f.id]) for f in features]
    owner = np.repeat(np.arange(len(features)), [len(p) for p in points])
    return _Picks(features, vectors, np.concatenate(points), owner, measured)


def _compare(
    readings: list[Reading], measured: Mapping[str, Measurement], picks: _Picks
) -> dict[str, NearestPick]:
    from scipy.spatial import cKDTree

    tree = cKDTree(picks.points)
    result = {}
    for reading in readings:
        vector = _vector(measured[reading.id])
        if vector is None:
            continue
        distance: float | None = None
        if reading.position is not None:
            away, point = tree.query(np.asarray(reading.position, dtype=np.float64))
            row, distance = int(picks.owner[point]), float(away)
        else:
            row = int(np.argmax(np.abs(picks.vectors @ vector)))
        pick = picks.features[row]
        angle = _angle_deg(measured[reading.id], picks.measured[pick.id])
        result[reading.id] = NearestPick(pick.id, pick.name, angle, distance)
    return result


def _angle_deg(a: Measurement, b: Measurement) -> float:
    if a.plane is not None and b.plane is not None:
        return angle_between_planes(a.plane, b.plane)
    assert a.line is not None
    assert b.line is not None
    return angle_between_lines(a.line, b.line)


def _vector(measured: Measurement) -> Floats | None:
    if measured.plane is not None:
        return measured.plane.normal()
    return None if measured.line is None else measured.line.vector()


def _points(
    records: Mapping[str, Record], feature: Trace | Patch | Lineation, measured: Measurement
) -> Floats:
    """Where a pick is, in World: its vertices; of a patch its outline and centre."""
    if not isinstance(feature, Patch) or not feature.outline:
        return measured.points
    model = records.get(feature.model_id)
    rows = model.to_world if isinstance(model, Model) else IDENTITY
    outline = transform.apply(rows, feature.outline)
    return np.concatenate([measured.points, outline])


def summary(readings: list[str], picks: Mapping[str, NearestPick]) -> str:
    """In a sentence: how well readings agree with the picks."""
    n = len(readings)
    angles = [picks[i].angle_deg for i in readings if i in picks]
    words = f"{n} reading{'s' if n != 1 else ''}"
    if not angles:
        return f"{words}; no pick of the same type to compare with yet."
    among = "" if len(angles) == n else f" ({len(angles)} of them have one of their type)"
    what = "median difference" if len(angles) > 1 else "difference"
    return f"{words}, {what} to the nearest pick{among} {np.median(angles):.0f}°."
