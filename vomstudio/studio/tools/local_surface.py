"""Resolution and outcrop normal of the surface around a measurement."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from vomstudio.geometry.matrices import Point
from vomstudio.geometry.surface import Surface
from vomstudio.project.record_map import RecordMap
from vomstudio.project.records import (
    SURROUNDINGS_RULE,
    Feature,
    PaintedFeature,
    PickedFeature,
    Record,
    SurfaceFeature,
)


def measure_surroundings(
    surface: Surface, vertices: Sequence[Point]
) -> tuple[float | None, Point | None]:
    """Return the typical spacing and the outcrop normal (3,) around the vertices.

    Both are in the file frame and unit of the model, or None if unknown.
    """
    points = np.asarray(vertices, dtype=np.float64)
    outcrop_normal = surface.outcrop_normal(points) if len(points) > 1 else None
    normal = (
        None
        if outcrop_normal is None
        else (float(outcrop_normal[0]), float(outcrop_normal[1]), float(outcrop_normal[2]))
    )
    return surface.local_resolution(points), normal


def surroundings_function(
    surface: Surface | None,
) -> Callable[[Sequence[Point]], tuple[float | None, Point | None]] | None:
    """Return `measure_surroundings` bound to a surface, or None if `surface` is None.

    Parameters
    ----------
    surface : Surface or None
    """
    return None if surface is None else partial(measure_surroundings, surface)


def find_outdated_features(records: Mapping[str, Record]) -> list[SurfaceFeature]:
    """Return the features whose surroundings were measured by an earlier rule."""
    features = records.of(Feature) if isinstance(records, RecordMap) else records.values()
    return [r for r in features if isinstance(r, SurfaceFeature) and r.rule < SURROUNDINGS_RULE]


def find_outdated_model(record: Record) -> tuple[str, str] | None:
    """Return the id and hash of a feature's model, or None if no earlier rule was used."""
    if isinstance(record, SurfaceFeature) and record.rule < SURROUNDINGS_RULE:
        return record.model_id, record.model_hash
    return None


def remeasure(surface: Surface, feature: SurfaceFeature) -> dict[str, Any]:
    """Return the fields of a feature that are measured on the surface around it."""
    if isinstance(feature, PaintedFeature):
        ring = feature.outline or (feature.mean,)
        return {"resolution": surface.local_resolution(np.asarray(ring, dtype=np.float64))}
    assert isinstance(feature, PickedFeature)
    resolution, normal = measure_surroundings(surface, feature.vertices)
    return {"resolution": resolution, "outcrop_normal": normal, "axis": "auto"}
