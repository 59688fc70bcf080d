"""Which cut-off is on the hanging wall, and where both end at the fault."""

from __future__ import annotations

import numpy as np
import pytest

from tests.messages import refused
from vomstudio.core.errors import GeometryError
from vomstudio.geology.beds.common_attitude import fit_common_bed
from vomstudio.geology.faults.cutoffs import find_cutoffs
from vomstudio.geology.orientation import Plane

FAULT = Plane(90.0, 60.0)
# East of a fault that dips to the east is its hanging wall.
EAST = np.array([[1.0, 0.0, 0.0], [3.0, 1.0, 0.2], [5.0, 0.0, 0.1]])
WEST = np.array([[-6.0, 0.0, 0.0], [-4.0, 1.0, 0.3], [-2.0, 0.0, 0.0]])


def test_the_hanging_wall_lies_above_the_fault_whichever_trace_comes_first() -> None:
    for one, other, is_swapped in ((EAST, WEST, False), (WEST, EAST, True)):
        found = find_cutoffs(one, other, FAULT, [0.0, 0.0, 0.0])
        assert found.is_swapped is is_swapped
        assert found.hanging_wall.tolist() == EAST[0].tolist()
        assert found.footwall.tolist() == WEST[2].tolist()


def test_rotation_and_translation_keep_cutoffs() -> None:
    a = np.radians(30.0)
    # Clockwise, as dip directions count.
    turn = np.array([[np.cos(a), np.sin(a), 0], [-np.sin(a), np.cos(a), 0], [0, 0, 1.0]])
    shift = np.array([4e5, 5e6, 300.0])
    east, west = (t @ turn.T + shift for t in (EAST, WEST))
    found = find_cutoffs(east, west, Plane(120.0, 60.0), shift)
    assert found.hanging_wall == pytest.approx(east[0])
    assert found.footwall == pytest.approx(west[2])
    assert not found.is_swapped


def test_traces_on_one_side_of_fault_are_refused() -> None:
    with refused("displacement.one-side", GeometryError):
        find_cutoffs(EAST, EAST + [0, 3, 0], FAULT, [0, 0, 0])


def test_common_bed_of_parallel_traces_is_recovered() -> None:
    normal = Plane(200.0, 25.0).normal()
    flat = np.random.default_rng(2).uniform(-3, 3, (2, 12, 2))
    traces = [
        np.column_stack([xy, -(xy @ normal[:2]) / normal[2] + height])
        for xy, height in zip(flat, (0.0, 1.7), strict=True)
    ]
    found = fit_common_bed(traces)
    plane = found.plane
    assert plane.dip_direction_deg == pytest.approx(200.0, abs=1e-6)
    assert plane.dip_deg == pytest.approx(25.0, abs=1e-6)
    assert found.max_confidence95_deg == pytest.approx(0.0, abs=1e-4)
    straight = [np.outer(np.arange(4.0), [1.0, 0, 0]) + [0, y, 0] for y in (0.0, 1.0)]
    with refused("beds.one-direction", GeometryError):
        fit_common_bed(straight)
