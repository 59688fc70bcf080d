"""Domains of a structure, such as the walls of a fault: which there are, and who is in them."""

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
from vomstudio.project.records import Record, Typed, get

Records = Mapping[str, Record]

_OTHER_SIDE = 0.1
"""Of the points of a feature: more of them on the other side, and it crosses the plane."""
_WINDS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")
_UPRIGHT_DEG = 89.0
"""A fault that dips by more has no wall that hangs."""


def domain_of(record: Record) -> str | None:
    """None of what is in none."""
    return record.domain or None if isinstance(record, Typed) else None


def domain_names(records: RecordMap) -> list[str]:
    return sorted(records.counted(domain_of))


def part_by_plane(
    records: Records, id_: str, measured: Callable[[Sequence[str]], Mapping[str, Measurement]]
) -> tuple[Edit, int]:
    """Put all features that lie on one side of the plane of the feature `id_` into one domain, and
    those on the other into another: hanging wall and footwall. Of its own type and set none is put
    into any. The edit, and how many cross the plane and were left as they are. Raises DocumentError
    where it has no plane, or parts nothing."""
    wall = get(records, id_, Typed)
    own = {} if wall is None else measured([id_])
    if wall is None or id_ not in own or own[id_].plane is None or not len(own[id_].points):
        raise DocumentError(Finding("domain.no-plane"))
    plane = own[id_].plane
    assert plane is not None
    above, below = tr("hanging wall"), tr("footwall")
    if plane.dip_deg > _UPRIGHT_DEG:
        above, below = (
            tr("{wind} side", wind=_WINDS[round((plane.dip_direction_deg + turn) / 45.0) % 8])
            for turn in (0.0, 180.0)
        )
    normal, middle = plane.normal(), own[id_].points.mean(axis=0)
    others = [
        r
        for r in records.values()
        if isinstance(r, Typed) and (r.type_id, r.set_name) != (wall.type_id, wall.set_name)
    ]
    found = measured([r.id for r in others])
    after: dict[str, Record | None] = {}
    crossing = 0
    for feature in others:
        points = found[feature.id].points if feature.id in found else np.empty((0, 3))
        if not len(points):
            continue
        share = float(((points - middle) @ normal > 0).mean())
        if _OTHER_SIDE < share < 1.0 - _OTHER_SIDE:
            crossing += 1
            continue
        name = above if share > 0.5 else below
        if feature.domain != name:
            after[feature.id] = replace(feature, domain=name)
    if not after:
        raise DocumentError(Finding("edit.no-change"))
    return change(records, f"Part {len(after)} features by {wall.name}", after), crossing
