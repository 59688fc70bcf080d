"""A project's features as rows of the orientation table, for every way out and for the window."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from vomstudio.document.measurements import Measurement, Measurements
from vomstudio.document.records import FeatureType, Model, Record, Trace
from vomstudio.io.orientation_table import Row, plane_row

NO_MODEL = "local frame: its model is missing"


@dataclass(frozen=True)
class ProjectTable:
    """Rows in the order of the records, and the features that have no plane."""

    rows: list[Row]
    skipped: list[dict[str, str]]
    """id, name and reason of each."""
    crs: str | None
    """The one CRS of all rows, None where there is none, or more than one."""
    north: str


def project_table(
    records: Mapping[str, Record], measurements: Measurements | None = None
) -> ProjectTable:
    """All features of a document as rows, in World."""
    traces = [record for record in records.values() if isinstance(record, Trace)]
    measured = (measurements or Measurements()).of(records, [trace.id for trace in traces])
    rows: list[Row] = []
    skipped: list[dict[str, str]] = []
    for trace in traces:
        measurement = measured[trace.id]
        row = trace_row(trace, measurement, records)
        if row is None:
            reason = measurement.problem or "no plane"
            skipped.append({"id": trace.id, "name": trace.name, "reason": reason})
        else:
            rows.append(row)
    crs, north = _frame(records, traces)
    return ProjectTable(rows, skipped, crs, north)


def trace_row(trace: Trace, measurement: Measurement, records: Mapping[str, Record]) -> Row | None:
    """The row of one trace, None where it has no plane."""
    if measurement.fit is None or measurement.verdict is None:
        return None
    kind, model = records.get(trace.type_id), records.get(trace.model_id)
    found = model if isinstance(model, Model) else None
    return plane_row(
        measurement.fit,
        measurement.verdict,
        resolution_m=measurement.resolution_m,
        id=trace.id,
        name=trace.name,
        kind=kind.name.casefold() if isinstance(kind, FeatureType) else trace.type_id,
        set=trace.set_name or None,
        overturned=trace.overturned,
        model=found.name if found else None,
        frame=found.frame.name() if found else NO_MODEL,
        notes=trace.notes or None,
    )


def _frame(records: Mapping[str, Record], traces: list[Trace]) -> tuple[str | None, str]:
    """CRS and north of all rows together."""
    models = [records.get(trace.model_id) for trace in traces]
    frames = {m.frame if isinstance(m, Model) else None for m in models}
    if len(frames) != 1:
        return None, "see the column frame"
    frame = frames.pop()
    if frame is None or not frame.has_north:
        return None, "unknown: the model is not registered, azimuths are in its local frame"
    if frame.crs:
        return frame.crs, f"grid north of {frame.crs}"
    return None, "local frame whose y axis the user declared as north"
