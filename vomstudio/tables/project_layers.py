"""A project's features as layers of points, lines and rings with attributes, in World: what a GIS
or CAD file holds of them, whatever its format."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from vomstudio.document.measurements import Measurements
from vomstudio.document.records import (
    FEATURES,
    IDENTITY,
    Dimension,
    FeatureType,
    Lineation,
    Model,
    Patch,
    Record,
    Trace,
)
from vomstudio.geometry import transform
from vomstudio.tables.orientation_table import COLUMNS
from vomstudio.tables.project_table import ProjectTable

_WORDS = {"id", "name", "kind", "geometry", "set", "quality", "quality_reason", "method", "model",
         "frame", "notes"}  # fmt: skip
_FLAGS = {"overturned", "undefined"}


@dataclass(frozen=True, eq=False)
class Layer:
    """shapes : one (n, 3) float64 array per feature; of a point n = 1, of a ring the first point is
    not repeated at the end. columns : one value per feature, by name."""

    name: str
    kind: Literal["point", "line", "ring"]
    shapes: list[npt.NDArray[np.float64]]
    columns: dict[str, npt.NDArray[Any]]


def project_layers(
    records: Mapping[str, Record], table: ProjectTable, measurements: Measurements
) -> list[Layer]:
    """Layers that would be empty are left out, but for `planes` and `traces`. A compass reading
    without a place is in the table only."""
    placed = [row for row in table.rows if row["x"] is not None]
    rows = {row["id"]: row for row in table.rows}
    features = [r for r in records.values() if isinstance(r, FEATURES)]
    measured = measurements.of(records, [f.id for f in features])

    def points(name: str, geometry: str) -> Layer:
        chosen = [row for row in placed if row["geometry"] == geometry]
        places = [np.array([[row[c] for c in "xyz"]], np.float64) for row in chosen]
        return Layer(name, "point", places, _columns(chosen))

    def drawn(cls: type[Any]) -> list[Any]:
        return [f for f in features if isinstance(f, cls) and len(measured[f.id].points) > 1]

    def lines(name: str, chosen: list[Any]) -> Layer:
        return Layer(name, "line", [measured[f.id].points for f in chosen], figures(chosen))

    def figures(chosen: list[Any]) -> dict[str, npt.NDArray[Any]]:
        return _feature_columns(records, chosen, [rows.get(f.id) for f in chosen])

    patches = [f for f in features if isinstance(f, Patch) and len(f.outline) > 2]
    rings = [_outline(patch, records) for patch in patches]
    dimensions = drawn(Dimension)
    layers = [
        points("planes", "plane"),
        lines("traces", drawn(Trace)),
        points("lines", "line"),
        lines("lineations", drawn(Lineation)),
        Layer("patches", "ring", rings, figures(patches)),
        Layer(
            "dimensions",
            "line",
            [measured[f.id].points for f in dimensions],
            _dimension_columns(dimensions, [measured[f.id].dimension or {} for f in dimensions]),
        ),
    ]
    return [layer for layer in layers if layer.shapes or layer.name in ("planes", "traces")]


def _outline(patch: Patch, records: Mapping[str, Record]) -> npt.NDArray[np.float64]:
    model = records.get(patch.model_id)
    rows = model.to_world if isinstance(model, Model) else IDENTITY
    return transform.apply(rows, patch.outline)


def _columns(rows: Sequence[Mapping[str, Any]]) -> dict[str, npt.NDArray[Any]]:
    """The orientation table's columns; the layer's own key is `fid`, so `id` stays the record's."""
    columns: dict[str, npt.NDArray[Any]] = {}
    for name in COLUMNS:
        values = [row[name] for row in rows]
        if name in _WORDS:
            columns[name] = np.array(values, dtype=object)
        elif name in _FLAGS:
            columns[name] = np.array([bool(v) for v in values], dtype=bool)
        else:
            columns[name] = np.array([np.nan if v is None else v for v in values], dtype=np.float64)
    return columns


def _feature_columns(
    records: Mapping[str, Record],
    features: Sequence[Trace | Lineation | Patch],
    rows: Sequence[Mapping[str, Any] | None],
) -> dict[str, npt.NDArray[Any]]:
    def figure(name: str) -> npt.NDArray[np.float64]:
        return np.array([np.nan if r is None or r[name] is None else r[name] for r in rows], float)

    kinds = [records.get(feature.type_id) for feature in features]
    counts = [f.n if isinstance(f, Patch) else len(f.vertices) for f in features]
    line = bool(features) and isinstance(features[0], Lineation)
    angles = ("trend_deg", "plunge_deg", "rake_deg") if line else ("dip_direction_deg", "dip_deg")
    return {
        "id": _text([feature.id for feature in features]),
        "name": _text([feature.name for feature in features]),
        "kind": _text([k.name.casefold() if isinstance(k, FeatureType) else "" for k in kinds]),
        "set": _text([feature.set_name for feature in features]),
        "n_points": np.array(counts, dtype=np.int32),
        **{name: figure(name) for name in (*angles, "max_confidence95_deg")},
        "quality": _text([row["quality"] if row else "" for row in rows]),
        "notes": _text([feature.notes for feature in features]),
    }


def _dimension_columns(
    dimensions: Sequence[Dimension], figures: Sequence[Mapping[str, float]]
) -> dict[str, npt.NDArray[Any]]:
    names = sorted({name for each in figures for name in each})
    return {
        "id": _text([d.id for d in dimensions]),
        "name": _text([d.name for d in dimensions]),
        "kind": _text([d.kind for d in dimensions]),
        **{name: np.array([f.get(name, np.nan) for f in figures], float) for name in names},
        "notes": _text([d.notes for d in dimensions]),
    }


def _text(values: list[str]) -> npt.NDArray[Any]:
    return np.array(values, dtype=object)
