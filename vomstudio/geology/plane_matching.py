"""Agreement between proposed planes and those picked by a geologist, in both directions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.geology.model_agreement import OrientedPlane

MIN_TOLERANCE_DEG = 10.0
"""Minimum tolerance (own choice): waviness causes such differences between good measurements."""


@dataclass(frozen=True)
class MutualAgreement:
    """Agreement between picked and proposed planes.

    Attributes
    ----------
    picked, proposed : int
        Number of planes with a known position.
    picks_near : int
        Number of picked planes that have a proposed plane within half the extent of the longer one.
    picks_found : int
        Number of these picked planes that agree with a proposed plane nearby.
    proposed_near, proposed_borne_out : int
        The same numbers for proposed planes.
    median_angle_deg : float or None
        Median angle between the picks found and the most similar proposed plane nearby, degrees;
        None if no pick was found.
    """

    picked: int
    picks_near: int
    picks_found: int
    proposed: int
    proposed_near: int
    proposed_borne_out: int
    median_angle_deg: float | None


def compare_proposals(
    picked_planes: Sequence[OrientedPlane], proposed_planes: Sequence[OrientedPlane]
) -> MutualAgreement:
    """Compare proposed planes with picked ones.

    Two planes agree if the angle between them is within 10 degrees or within their combined 95 %
    errors (square root of the sum of squares), whichever is larger. Proposed planes that have no
    pick nearby are not wrong and are not counted.

    Parameters
    ----------
    picked_planes : sequence of OrientedPlane
    proposed_planes : sequence of OrientedPlane

    Returns
    -------
    MutualAgreement
    """
    located_picks = [plane for plane in picked_planes if plane.position is not None]
    located_proposals = [plane for plane in proposed_planes if plane.position is not None]
    if not (located_picks and located_proposals):
        return MutualAgreement(len(located_picks), 0, 0, len(located_proposals), 0, 0, None)
    is_near, agrees, angle = _compare_planes(located_picks, located_proposals)
    smallest_angles = np.where(is_near & agrees, angle, np.inf).min(axis=1)
    angles = smallest_angles[np.isfinite(smallest_angles)]
    return MutualAgreement(
        len(located_picks),
        int(is_near.any(axis=1).sum()),
        len(angles),
        len(located_proposals),
        int(is_near.any(axis=0).sum()),
        int((is_near & agrees).any(axis=0).sum()),
        float(np.median(angles)) if len(angles) else None,
    )


def _compare_planes(
    first_planes: Sequence[OrientedPlane], second_planes: Sequence[OrientedPlane]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return which planes (k, m) are near each other, which ones agree, and their angles."""

    def plane_arrays(planes: Sequence[OrientedPlane]) -> tuple[np.ndarray, ...]:
        return (
            np.array([plane.normal for plane in planes], np.float64),
            np.array([plane.position for plane in planes], np.float64),
            np.array([plane.extent_m or 0.0 for plane in planes]),
            np.array([plane.error95_deg or 0.0 for plane in planes]),
        )

    first_normals, first_positions, first_extents, first_errors = plane_arrays(first_planes)
    second_normals, second_positions, second_extents, second_errors = plane_arrays(second_planes)
    angle = np.degrees(np.arccos(np.minimum(np.abs(first_normals @ second_normals.T), 1.0)))
    distance = np.linalg.norm(first_positions[:, None] - second_positions[None], axis=2)
    max_distance = np.maximum(first_extents[:, None], second_extents[None]) / 2.0
    max_angles = np.maximum(np.hypot(first_errors[:, None], second_errors[None]), MIN_TOLERANCE_DEG)
    return distance <= max_distance, angle <= max_angles, angle
