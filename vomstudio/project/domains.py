"""Domains of a structure, such as the walls of a fault, and their features."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.edit import Edit, change
from vomstudio.project.measurement import Measurement
from vomstudio.project.record_map import RecordMap
from vomstudio.project.records import Record, TypedFeature, get

Records = Mapping[str, Record]

MAX_SHARE_ON_OTHER_SIDE = 0.1
"""Share of points on the other side above which a feature crosses the plane."""
_DIRECTIONS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")
MIN_VERTICAL_DIP_DEG = 89.0
"""Dip above which a fault is considered vertical and has no hanging wall."""


def get_domain(record: Record) -> str | None:
    """Return the domain of a record, or None if it has no domain."""
    return record.domain or None if isinstance(record, TypedFeature) else None


def domain_names(records: RecordMap) -> list[str]:
    """Return the sorted names of the domains that are in use."""
    return sorted(records.count_by(get_domain))


def split_by_plane(
    records: Records,
    id_: str,
    measure: Callable[[Sequence[str]], Mapping[str, Measurement]],
) -> tuple[Edit, int]:
    """Assign the features on the two sides of a feature's plane to two domains.

    The domains are the hanging wall and the footwall or, if the plane is vertical, its two sides by
    compass direction. Features of the same type and set as the plane are not assigned.

    Returns
    -------
    tuple of Edit and int
        Edit, and number of features that cross the plane and remain unchanged.

    Raises
    ------
    DocumentError
        If the feature has no plane or nothing would change.
    """
    fault = get(records, id_, TypedFeature)
    fault_measurement = {} if fault is None else measure([id_])
    if (
        fault is None
        or id_ not in fault_measurement
        or fault_measurement[id_].plane is None
        or not len(fault_measurement[id_].points)
    ):
        raise DocumentError(Finding("domain.no-plane"))
    plane = fault_measurement[id_].plane
    assert plane is not None
    upper_name, lower_name = tr("hanging wall"), tr("footwall")
    if plane.dip_deg > MIN_VERTICAL_DIP_DEG:
        upper_name, lower_name = (
            tr(
                "{wind} side",
                wind=_DIRECTIONS[round((plane.dip_direction_deg + offset_deg) / 45.0) % 8],
            )
            for offset_deg in (0.0, 180.0)
        )
    normal, centre = plane.normal(), fault_measurement[id_].points.mean(axis=0)
    other_features = [
        record
        for record in records.values()
        if isinstance(record, TypedFeature)
        and (record.type_id, record.set_name) != (fault.type_id, fault.set_name)
    ]
    measurements = measure([other_feature.id for other_feature in other_features])
    new_records: dict[str, Record | None] = {}
    crossing = 0
    for feature in other_features:
        points = measurements[feature.id].points if feature.id in measurements else np.empty((0, 3))
        if not len(points):
            continue
        share = float(((points - centre) @ normal > 0).mean())
        if MAX_SHARE_ON_OTHER_SIDE < share < 1.0 - MAX_SHARE_ON_OTHER_SIDE:
            crossing += 1
            continue
        name = upper_name if share > 0.5 else lower_name
        if feature.domain != name:
            new_records[feature.id] = replace(feature, domain=name)
    if not new_records:
        raise DocumentError(Finding("edit.no-change"))
    return change(
        records, f"Part {len(new_records)} features by {fault.name}", new_records
    ), crossing
