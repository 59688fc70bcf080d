"""Resolution and outcrop normal of the surface around a measurement."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vomstudio.geometry.matrices import Point
from vomstudio.geometry.surface import Surface
from vomstudio.project.record_map import RecordMap
from vomstudio.project.records import (
    SURROUNDINGS_RULE,
    Feature,
    Painted,
    Picked,
    Record,
    Surrounded,
)


def around(surface: Surface, vertices: Sequence[Point]) -> tuple[float | None, Point | None]:
    """Typical spacing of the surface around the vertices, and (3,) the outcrop's normal there; each
    None where it is not known. All in the model's file frame and unit."""
    points = np.asarray(vertices, dtype=np.float64)
    found = surface.outcrop_normal(points) if len(points) > 1 else None
    normal = None if found is None else (float(found[0]), float(found[1]), float(found[2]))
    return surface.resolution_near(points), normal


def of_earlier_rules(records: Mapping[str, Record]) -> list[Surrounded]:
    """Features whose surroundings were measured by a rule before today's."""
    every = records.of(Feature) if isinstance(records, RecordMap) else records.values()
    return [r for r in every if isinstance(r, Surrounded) and r.rule < SURROUNDINGS_RULE]


def model_of_earlier_rule(record: Record) -> tuple[str, str] | None:
    """Id and hash of the model on which a feature was measured by a rule before today's; None for
    any other record."""
    if isinstance(record, Surrounded) and record.rule < SURROUNDINGS_RULE:
        return record.model_id, record.model_hash
    return None


def measured_anew(surface: Surface, feature: Surrounded) -> dict[str, Any]:
    """The fields of a feature that are measured on the surface around it."""
    if isinstance(feature, Painted):
        ring = feature.outline or (feature.mean,)
        return {"resolution": surface.resolution_near(np.asarray(ring, dtype=np.float64))}
    assert isinstance(feature, Picked)
    resolution, normal = around(surface, feature.vertices)
    return {"resolution": resolution, "outcrop_normal": normal, "axis": "auto"}
