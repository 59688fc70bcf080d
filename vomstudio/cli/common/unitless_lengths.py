"""Lengths in the JSON of a model that has no metres: also named without a unit.

Scripts rely on the names that end in `_m`. Where a model was made of photos without scale, whose
lengths are in units of its own, the same figures also stand under names without the unit.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from vomstudio.core.words import tr
from vomstudio.geometry.units import without_metres

# A row of the orientation table keeps its columns, whatever the unit: the table's header names it.
_ROW = {"pole_trend_deg", "n_points", "extent_m"}


def named_by_unit(result: Mapping[str, Any], *, metric: bool) -> dict[str, Any]:
    """The object of a command whose lengths are in metres, or in the unit of a model without any:
    beside each `NAME_m` and `NAME_m2` stands then `NAME`, or `NAME_units` where `NAME` is something
    else."""
    return dict(result) if metric else _bare(result)


def unit_of(metric: bool) -> str:
    """For sentences: the unit of lengths."""
    return "m" if metric else tr("units")


def _bare(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return [_bare(each) for each in value]
    if not isinstance(value, Mapping) or value.keys() >= _ROW:
        return value
    told: dict[str, Any] = {}
    for name, each in value.items():
        bare = without_metres(name, value)
        told[name] = _bare(each)
        if bare != name:
            told[bare] = told[name]
    return told
