"""How far planes that were proposed agree with those that a geologist has measured, both ways."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.geology.model_agreement import OrientedPlane

TOLERANCE_DEG = 10.0
"""Ours: the waviness of a surface turns two good readings of it by as much."""


@dataclass(frozen=True)
class BothWays:
    """picked, proposed : planes that have a place; picks_near : of the picked, those that have a
    proposed one within half of the longer one's extent; picks_found : of these, those that agree
    with one; proposed_near, proposed_borne_out : the same of the proposed"""

    picked: int
    picks_near: int
    picks_found: int
    proposed: int
    proposed_near: int
    proposed_borne_out: int
    median_angle_deg: float | None


def agreement_both_ways(
    picked: Sequence[OrientedPlane], proposed: Sequence[OrientedPlane]
) -> BothWays:
    """Two planes agree where the angle between them is at most 10 degrees or what their 95 % errors
    allow together (root of the sum of squares), whichever is more. A proposed plane that nobody
    picked near is not wrong, and counts on neither side. median_angle_deg : of the picked ones that
    were found, to the proposed plane that fits best; None without any."""
    own = [plane for plane in picked if plane.place is not None]
    others = [plane for plane in proposed if plane.place is not None]
    if not (own and others):
        return BothWays(len(own), 0, 0, len(others), 0, 0, None)
    near, agree, angle = _held_together(own, others)
    best = np.where(near & agree, angle, np.inf).min(axis=1)
    found = best[np.isfinite(best)]
    return BothWays(
        len(own),
        int(near.any(axis=1).sum()),
        len(found),
        len(others),
        int(near.any(axis=0).sum()),
        int((near & agree).any(axis=0).sum()),
        float(np.median(found)) if len(found) else None,
    )


def _held_together(
    one: Sequence[OrientedPlane], other: Sequence[OrientedPlane]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(k, m) whether they are near each other, whether they agree, and the angle between them."""

    def columns(planes: Sequence[OrientedPlane]) -> tuple[np.ndarray, ...]:
        return (
            np.array([plane.normal for plane in planes], np.float64),
            np.array([plane.place for plane in planes], np.float64),
            np.array([plane.extent_m or 0.0 for plane in planes]),
            np.array([plane.error95_deg or 0.0 for plane in planes]),
        )

    normal, place, extent, error = columns(one)
    its_normal, its_place, its_extent, its_error = columns(other)
    angle = np.degrees(np.arccos(np.minimum(np.abs(normal @ its_normal.T), 1.0)))
    apart = np.linalg.norm(place[:, None] - its_place[None], axis=2)
    reach = np.maximum(extent[:, None], its_extent[None]) / 2.0
    allowed = np.maximum(np.hypot(error[:, None], its_error[None]), TOLERANCE_DEG)
    return apart <= reach, angle <= allowed, angle
