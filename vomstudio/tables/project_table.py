"""A project's features as rows of the orientation table, for every way out and for the window."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vomstudio.document.comparison import NearestPick, nearest_picks
from vomstudio.document.measurements import Measurement, Measurements
from vomstudio.document.records import (
    ON_A_MODEL,
    TYPED,
    FeatureType,
    Model,
    Patch,
    Reading,
    Record,
    Typed,
)
from vomstudio.tables.orientation_table import Row, line_row, orientation_row, plane_row

NO_MODEL = "local frame: its model is missing"
IN_WORLD = "grid north, as entered"


@dataclass(frozen=True)
class ProjectTable:
    """Rows in the order of the records, and the features that have no orientation."""

    rows: list[Row]
    skipped: list[dict[str, str]]
    """id, name and reason of each."""
    crs: str | None
    """The one CRS of all rows, None where there is none, or more than one."""
    north: str
    files: tuple[Path, ...] = ()
    """What an export has written."""


def project_table(
    records: Mapping[str, Record], measurements: Measurements | None = None
) -> ProjectTable:
    """All planes and lines of a document as rows, in World."""
    features = [record for record in records.values() if isinstance(record, TYPED)]
    measurements = measurements or Measurements()
    measured = measurements.of(records, [feature.id for feature in features])
    picks = nearest_picks(records, measurements)
    rows: list[Row] = []
    skipped: list[dict[str, str]] = []
    for feature in features:
        measurement = measured[feature.id]
        row = feature_row(feature, measurement, records, picks.get(feature.id))
        if row is None:
            reason = measurement.problem or "no plane"
            skipped.append({"id": feature.id, "name": feature.name, "reason": reason})
        else:
            rows.append(row)
    crs, north = _frame(records, features)
    return ProjectTable(rows, skipped, crs, north)


def feature_row(
    feature: Typed,
    measurement: Measurement,
    records: Mapping[str, Record],
    nearest: NearestPick | None = None,
) -> Row | None:
    """The row of one feature, None where it has no orientation. What was added to the azimuth of a
    compass reading, and how far it is from the nearest pick, stand in its notes."""
    kind = records.get(feature.type_id)
    values: dict[str, Any] = {
        "id": feature.id,
        "name": feature.name,
        "kind": kind.name.casefold() if isinstance(kind, FeatureType) else feature.type_id,
        "set": feature.set_name or None,
        "notes": feature.notes or None,
    }
    model = records.get(feature.model_id) if isinstance(feature, ON_A_MODEL) else None
    if isinstance(model, Model):
        values |= {"model": model.name, "frame": model.frame.name()}
    else:
        values["frame"] = NO_MODEL if isinstance(feature, ON_A_MODEL) else IN_WORLD
    if hasattr(feature, "overturned"):
        values["overturned"] = feature.overturned
    if measurement.fit is not None and measurement.verdict is not None:
        if isinstance(feature, Patch):
            values["area_m2"] = measurement.area_m2
        return plane_row(
            measurement.fit, measurement.verdict, resolution_m=measurement.resolution_m, **values
        )
    if len(measurement.points):
        values |= dict(zip("xyz", measurement.points.mean(axis=0).tolist(), strict=True))
    if isinstance(feature, Reading):
        values["method"] = "compass"
        said = [feature.notes]
        if feature.turned_deg:
            said.append(f"azimuth as read {feature.turned_deg:+.2f} deg")
        if nearest is not None:
            place = "" if nearest.distance_m is None else f", {nearest.distance_m:.2f} m away"
            said.append(f"{nearest.angle_deg:.1f} deg from {nearest.name}{place}")
        values["notes"] = "; ".join(filter(None, said)) or None
    if measurement.plane is not None:
        return orientation_row(measurement.plane, **values)
    if measurement.line is None:
        return None
    verdict, fit = measurement.verdict, measurement.line_fit
    slip = measurement.slip_rake_deg
    return line_row(
        measurement.line,
        **values,
        rake_deg=measurement.rake_deg if slip is None else slip,
        max_confidence95_deg=measurement.max_confidence95_deg,
        min_confidence95_deg=measurement.min_confidence95_deg,
        quality=verdict.quality if verdict else None,
        quality_reason="; ".join(verdict.reasons) if verdict else None,
        **(
            {"n_points": fit.n, "extent_m": fit.length, "rms_m": fit.rms, "method": "line"}
            if fit
            else {}
        ),
    )


def _frame(records: Mapping[str, Record], features: list[Typed]) -> tuple[str | None, str]:
    """CRS and north of all rows together; compass readings and intersections go by the others."""
    models = [records.get(f.model_id) for f in features if isinstance(f, ON_A_MODEL)]
    frames = {m.frame if isinstance(m, Model) else None for m in models}
    if not models and features:
        return None, IN_WORLD
    if len(frames) != 1:
        return None, "see the column frame"
    frame = frames.pop()
    if frame is None or not frame.has_north:
        return None, "unknown: the model is not registered, azimuths are in its local frame"
    if frame.crs:
        return frame.crs, f"grid north of {frame.crs}"
    return None, "local frame whose y axis the user declared as north"
