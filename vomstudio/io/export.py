"""A document as files for other programs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from vomstudio.document.measurements import Measurement, measure
from vomstudio.document.records import FeatureType, Frame, Model, Record, Trace
from vomstudio.errors import InputError, UsageError
from vomstudio.geology.quality import Thresholds
from vomstudio.io.atomic import check_target
from vomstudio.io.orientation_table import Row, plane_row, write_orientation_csv

FORMATS = ("csv", "gpkg")


def export_project(folder: Path, format_: str, out: Path, *, force: bool = False) -> list[Path]:
    """Export the project in `folder`, which may be open in a window; returns the files written.

    Raises InputError where the project cannot be read or holds no features, UsageError for a format
    that is not known, TargetError where `out` cannot be written.
    """
    from vomstudio.io.journal import read_records

    _check_format(format_)
    check_target(out, force=force)
    records = read_records(folder)
    if not any(isinstance(r, Trace) for r in records.values()):
        raise InputError("has no features yet, so there is nothing to export", file=folder)
    return export_records(records, format_, out, force=force)


def export_records(
    records: Mapping[str, Record],
    format_: str,
    out: Path,
    *,
    force: bool = False,
    thresholds: Thresholds | None = None,
) -> list[Path]:
    """Export the features of a document; returns the files written. Raises as `export_project`."""
    _check_format(format_)
    traces = [r for r in records.values() if isinstance(r, Trace)]
    models = [_model(records, trace) for trace in traces]
    measured = measure(list(zip(traces, models, strict=True)), thresholds)
    crs, north = common_frame(models)
    if format_ == "csv":
        rows = [
            row
            for trace, model, m in zip(traces, models, measured, strict=True)
            if (row := trace_row(records, trace, model, m)) is not None
        ]
        write_orientation_csv(out, rows, crs=crs, north=north, force=force)
    else:
        from vomstudio.io.geopackage import write_layers

        write_layers(out, records, traces, models, measured, crs=crs, force=force)
    return [Path(out)]


def trace_row(
    records: Mapping[str, Record], trace: Trace, model: Model | None, measured: Measurement
) -> Row | None:
    """The row of a trace in the orientation table; None where no plane can be fitted."""
    if measured.fit is None or measured.verdict is None:
        return None
    kind = records.get(trace.type_id)
    return plane_row(
        measured.fit,
        measured.verdict,
        resolution_m=measured.resolution_m,
        id=trace.id,
        name=trace.name,
        kind=kind.name.lower() if isinstance(kind, FeatureType) else trace.type_id,
        set=trace.set_name or None,
        overturned=trace.overturned,
        model=model.name if model else None,
        frame=(model.frame if model else Frame()).name(),
        notes=trace.notes or None,
    )


def common_frame(models: list[Model | None]) -> tuple[str | None, str]:
    """(CRS, north) of features measured on these models; a CRS only where all agree."""
    frames = {model.frame if model else Frame() for model in models}
    codes = {frame.crs for frame in frames}
    crs = next(iter(codes)) if len(codes) == 1 else None
    names = sorted({frame.name() for frame in frames})
    if crs:
        return crs, f"grid north of {crs}"
    if all(frame.has_north for frame in frames):
        return None, "grid north, " + "; ".join(names)
    return None, "NOT geographic for some or all rows (column frame): " + "; ".join(names)


def _check_format(format_: str) -> None:
    if format_ not in FORMATS:
        raise UsageError(
            f"“{format_}” cannot be written by this version; choose one of {', '.join(FORMATS)}",
            field="--to",
        )


def _model(records: Mapping[str, Record], trace: Trace) -> Model | None:
    model = records.get(trace.model_id)
    return model if isinstance(model, Model) else None
