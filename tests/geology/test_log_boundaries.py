"""Boundaries of a log where traces cross its line: closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from vomstudio.geology.beds.bed_log import bed_log
from vomstudio.geology.beds.log_boundaries import crossings
from vomstudio.geology.orientation import Plane

BASE = np.array([433_000.0, 5_200_000.0, 812.0])


def test_parallel_beds_on_a_cliff_have_their_known_thickness() -> None:
    """Beds of 30 degrees, 2 and 3 m apart across the bedding, on a vertical face: the log is in the
    order along the line, and its thicknesses are these whichever way the line runs."""
    bed = Plane(90.0, 30.0)
    normal = bed.normal()
    traces = {}
    for name, height in (("a", 0.0), ("b", 2.0), ("c", 5.0)):
        x = np.linspace(-20.0, 20.0, 9)
        z = (height - x * normal[0]) / normal[2]
        traces[name] = np.column_stack([x, np.zeros(9), z]) + BASE
    far = {"far": traces["a"] + [0.0, 30.0, 0.0], "dot": BASE[None]}
    line = np.array([[3.0, 0.05, -5.0], [1.0, -0.05, 12.0]]) + BASE
    for way in (line, line[::-1]):
        found = crossings(way, traces | far, 0.2)
        expected = ["a", "b", "c"] if way is line else ["c", "b", "a"]
        assert [each.name for each in found] == expected
        assert all(each.distance_m <= 0.06 for each in found)
        log = bed_log([each.position for each in found], bed, names=[e.name for e in found])
        assert [i.thickness_m.value for i in log.intervals] == pytest.approx([2.0, 3.0])
        assert [i.base for i in log.intervals] == ["a", "b"]
    assert crossings(line, far, 0.2) == []
