"""Unitless names in the JSON output for lengths of a model that is not in metres.

Scripts rely on names that end in `_m`, so these are always present. Lengths of a model from
photos without scale are in model units; they are repeated under names without the unit.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from vomstudio.core.words import tr
from vomstudio.geometry.units import strip_metric_suffix

# A row of the orientation table keeps its columns in any unit, which the table header states.
ROW_KEYS = {"pole_trend_deg", "n_points", "extent_m"}


def add_unitless_names(result: Mapping[str, Any], *, is_metric: bool) -> dict[str, Any]:
    """Return a result in which lengths that are not in metres also have unitless names.

    `NAME` is added for each `NAME_m` and `NAME_m2`, or `NAME_units` if `NAME` has another meaning.
    Rows of the orientation table stay unchanged.
    """
    return dict(result) if is_metric else _add_plain_names(result)


def length_unit(is_metric: bool) -> str:
    """Return the unit of lengths for use in sentences."""
    return "m" if is_metric else tr("units")


def _add_plain_names(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return [_add_plain_names(item) for item in value]
    if not isinstance(value, Mapping) or value.keys() >= ROW_KEYS:
        return value
    values: dict[str, Any] = {}
    for name, item in value.items():
        plain_name = strip_metric_suffix(name, value)
        values[name] = _add_plain_names(item)
        if plain_name != name:
            values[plain_name] = values[name]
    return values
