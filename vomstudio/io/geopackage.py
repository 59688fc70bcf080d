"""The project's GIS layers: planes as points with their figures, traces as lines in 3-D."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.document.measurements import Measurements
from vomstudio.document.records import FeatureType, Record, Trace
from vomstudio.errors import TargetError
from vomstudio.io.atomic import atomic_write
from vomstudio.io.orientation_table import COLUMNS
from vomstudio.io.project_table import ProjectTable

_TEXT = {"id", "name", "kind", "geometry", "set", "quality", "quality_reason", "method", "model",
         "frame", "notes"}  # fmt: skip
_FLAGS = {"overturned", "undefined"}


def write_layers(
    out: Path,
    records: Mapping[str, Record],
    table: ProjectTable,
    measurements: Measurements,
    *,
    force: bool = False,
) -> None:
    """Layers `planes` and `traces` in World coordinates. Raises TargetError."""
    import shapely

    centres = shapely.points(
        np.array([[row["x"], row["y"], row["z"]] for row in table.rows]).reshape(-1, 3)
    )
    traces = [r for r in records.values() if isinstance(r, Trace)]
    measured = measurements.of(records, [trace.id for trace in traces])
    drawn = [trace for trace in traces if len(trace.vertices) > 1]
    lines = [shapely.linestrings(measured[trace.id].points) for trace in drawn]
    rows = {row["id"]: row for row in table.rows}
    with atomic_write(out, force=force) as part:
        part.unlink(missing_ok=True)
        _write(part, "planes", "Point Z", centres, _columns(table.rows), table.crs, append=False)
        _write(
            part,
            "traces",
            "LineString Z",
            np.array(lines, dtype=object),
            _trace_columns(records, drawn, [rows.get(trace.id) for trace in drawn]),
            table.crs,
            append=True,
        )


def _write(
    part: Path,
    layer: str,
    geometry_type: str,
    geometry: npt.NDArray[Any],
    columns: dict[str, npt.NDArray[Any]],
    crs: str | None,
    *,
    append: bool,
) -> None:
    import shapely
    from pyogrio.errors import DataSourceError, FieldError, GeometryError
    from pyogrio.raw import write

    try:
        write(
            str(part),
            shapely.to_wkb(geometry),
            list(columns.values()),
            np.array(list(columns), dtype=object),
            layer=layer,
            driver="GPKG",
            geometry_type=geometry_type,
            crs=crs,
            append=append,
        )
    except (DataSourceError, FieldError, GeometryError, RuntimeError) as error:
        raise TargetError(f"the layer {layer} cannot be written ({error})", file=part) from error


def _columns(rows: Sequence[Mapping[str, Any]]) -> dict[str, npt.NDArray[Any]]:
    """The orientation table's columns; the layer's own key is `fid`, so `id` stays the record's."""
    columns: dict[str, npt.NDArray[Any]] = {}
    for name in COLUMNS:
        values = [row[name] for row in rows]
        if name in _TEXT:
            columns[name] = np.array(values, dtype=object)
        elif name in _FLAGS:
            columns[name] = np.array([bool(v) for v in values], dtype=bool)
        else:
            columns[name] = np.array([np.nan if v is None else v for v in values], dtype=np.float64)
    return columns


def _trace_columns(
    records: Mapping[str, Record],
    traces: Sequence[Trace],
    rows: Sequence[Mapping[str, Any] | None],
) -> dict[str, npt.NDArray[Any]]:
    def text(values: list[str]) -> npt.NDArray[Any]:
        return np.array(values, dtype=object)

    def figure(name: str) -> npt.NDArray[np.float64]:
        return np.array([np.nan if r is None or r[name] is None else r[name] for r in rows], float)

    kinds = [records.get(trace.type_id) for trace in traces]
    return {
        "id": text([trace.id for trace in traces]),
        "name": text([trace.name for trace in traces]),
        "kind": text([k.name.lower() if isinstance(k, FeatureType) else "" for k in kinds]),
        "set": text([trace.set_name for trace in traces]),
        "n_points": np.array([len(trace.vertices) for trace in traces], dtype=np.int32),
        "dip_direction_deg": figure("dip_direction_deg"),
        "dip_deg": figure("dip_deg"),
        "max_confidence95_deg": figure("max_confidence95_deg"),
        "quality": text([row["quality"] if row else "" for row in rows]),
        "notes": text([trace.notes for trace in traces]),
    }
