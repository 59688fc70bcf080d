"""Planes for maps of measurable planes: entered, the mean of a set, or a feature."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from vomstudio.core.errors import InputError, VomError
from vomstudio.geology.notation import format_azimuth, parse_plane
from vomstudio.geology.orientation import Plane
from vomstudio.geology.statistics import axial_mean
from vomstudio.project.records import get_feature
from vomstudio.studio.derived_quantities import DerivedQuantities

MEASURABLE, EXPECTED = "measurable", "expected_error"
"""Names of the fields of a map: verdict and expected error."""
PLANE_PREFIX, SET_PREFIX = "plane:", "set:"
"""Prefixes of stored planes; texts without a prefix are ids of features."""


def set_names(records: Mapping[str, Any]) -> list[str]:
    """Return the names of all sets of features."""
    return sorted({name for r in records.values() if (name := getattr(r, "set_name", ""))})


def resolve_plane(
    records: Mapping[str, Any], derived: DerivedQuantities, source: str
) -> Plane | None:
    """Return the plane that is specified by a text.

    Returns None if the text is not valid, the feature is missing or has no plane, or the set has no
    mean.
    """
    if source.startswith(PLANE_PREFIX):
        try:
            return parse_plane(source.removeprefix(PLANE_PREFIX), "dipdir/dip")
        except InputError:
            return None
    if not source.startswith(SET_PREFIX):
        if get_feature(records, source) is None:
            return None
        return derived.measured([source])[source].plane
    name = source.removeprefix(SET_PREFIX)
    ids = [i for i, r in records.items() if getattr(r, "set_name", "") == name]
    planes = [m.plane for m in derived.measured(ids).values() if m.plane is not None]
    if not planes:
        return None
    try:
        return Plane.from_normal(axial_mean([plane.normal() for plane in planes]).vector())
    except VomError:
        return None


def map_names(plane: Plane, length: float, *, is_metric: bool) -> dict[str, str]:
    """Return the names of the two map fields among the fields of a model."""
    unit = "m" if is_metric else "units"
    plane_text = (
        f"{format_azimuth(plane.dip_direction_deg)}/{plane.dip_deg:02.0f}, L {length:g} {unit}"
    )
    return {MEASURABLE: f"measurable, {plane_text}", EXPECTED: f"95 % error, {plane_text} [°]"}
