"""Which plane a map of measurable planes is of: typed, the mean of a set, or that of a feature."""

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
"""Two fields of one map: the verdict, and the expected error."""
TYPED, OF_SET = "plane:", "set:"
"""How what is written down begins; else it is the id of a feature."""


def set_names(records: Mapping[str, Any]) -> list[str]:
    """Of the sets that features are in."""
    return sorted({name for r in records.values() if (name := getattr(r, "set_name", ""))})


def plane_meant(records: Mapping[str, Any], derived: DerivedQuantities, of: str) -> Plane | None:
    """None where there is none: it is not readable, gone, or a set has no mean."""
    if of.startswith(TYPED):
        try:
            return parse_plane(of.removeprefix(TYPED), "dipdir/dip")
        except InputError:
            return None
    if not of.startswith(OF_SET):
        if get_feature(records, of) is None:
            return None
        return derived.measured([of])[of].plane
    name = of.removeprefix(OF_SET)
    ids = [i for i, r in records.items() if getattr(r, "set_name", "") == name]
    planes = [m.plane for m in derived.measured(ids).values() if m.plane is not None]
    if not planes:
        return None
    try:
        return Plane.from_normal(axial_mean([plane.normal() for plane in planes]).vector())
    except VomError:
        return None


def map_names(plane: Plane, length: float, *, metric: bool) -> dict[str, str]:
    """Of the two fields among those of a model."""
    unit = "m" if metric else "units"
    told = f"{format_azimuth(plane.dip_direction_deg)}/{plane.dip_deg:02.0f}, L {length:g} {unit}"
    return {MEASURABLE: f"measurable, {told}", EXPECTED: f"95 % error, {told} [°]"}
