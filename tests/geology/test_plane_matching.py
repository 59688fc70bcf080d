"""Proposed planes held against picked ones, both ways."""

from __future__ import annotations

import numpy as np
import pytest

from tests.extraction.planes_by_construction import normal_of
from vomstudio.geology.model_agreement import OrientedPlane
from vomstudio.geology.plane_matching import compare_proposals


def plane(attitude, place=(0.0, 0.0, 0.0), extent=2.0, error=1.0) -> OrientedPlane:
    where = None if place is None else np.array(place, float)
    return OrientedPlane("", "joint", normal_of(*attitude), where, extent, error)


def test_picked_and_proposed_planes_are_counted_separately() -> None:
    picked = [
        plane((100.0, 80.0)),
        plane((100.0, 80.0), (10.0, 0.0, 0.0)),  # another plane was proposed there
        plane((10.0, 50.0), (50.0, 0.0, 0.0)),  # nothing was proposed there
    ]
    proposed = [
        plane((104.0, 82.0), (0.5, 0.0, 0.0)),
        plane((100.0, 30.0), (0.0, 0.5, 0.0)),
        plane((200.0, 45.0), (10.0, 0.2, 0.0)),
        plane((100.0, 80.0), (90.0, 0.0, 0.0)),
        plane((100.0, 80.0), (90.0, 9.0, 0.0)),
    ]
    found = compare_proposals(picked, proposed)
    assert (found.picked, found.picks_near, found.picks_found) == (3, 2, 1)
    assert (found.proposed, found.proposed_near, found.proposed_borne_out) == (5, 3, 1)
    angle = np.degrees(np.arccos(normal_of(100.0, 80.0) @ normal_of(104.0, 82.0)))
    assert found.median_angle_deg == pytest.approx(angle)


def test_large_stated_errors_allow_angles_above_ten_degrees() -> None:
    first, second = plane((90.0, 40.0), error=12.0), plane((90.0, 55.0), error=12.0)
    assert compare_proposals([first], [second]).picks_found == 1
    first, second = plane((90.0, 40.0), error=1.0), plane((90.0, 55.0), error=1.0)
    assert compare_proposals([first], [second]).picks_found == 0
    # Which way a normal points says nothing.
    turned = OrientedPlane("", "", -normal_of(90.0, 41.0), np.zeros(3), 2.0, 1.0)
    assert compare_proposals([first], [turned]).picks_found == 1


def test_planes_without_position_are_never_near() -> None:
    found = compare_proposals([plane((0.0, 10.0), None)], [plane((0.0, 10.0))])
    assert (found.picked, found.proposed, found.picks_near) == (0, 1, 0)
    assert found.median_angle_deg is None
