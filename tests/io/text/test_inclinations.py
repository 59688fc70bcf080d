"""Tables with an azimuth and an inclination, of planes or of lines."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.messages import refused
from vomstudio.core.errors import UsageError
from vomstudio.io.gate.orientation_files import read_orientations

GEMS = """Type,Azimuth,Inclination,OrientationConfidenceDegrees,OrientationPoints_ID
bedding,30,40,2,B01
lineation,75,12,2,L01
"""


def test_ambiguous_azimuth_and_inclination_require_a_notation(tmp_path: Path) -> None:
    table = tmp_path / "planes.csv"
    table.write_text("site,structure,azi,inc\nA,S1,113,47\nA,L1,200,10\n")
    with refused("orientation.ambiguous-azimuth", UsageError):
        read_orientations(table)
    rows = read_orientations(table, "dipdir")
    assert rows.is_plane.tolist() == [True, False]
    assert (rows.dip_direction_deg[0], rows.dip_deg[0]) == (113, 47)
    assert (rows.trend_deg[1], rows.plunge_deg[1]) == (200, 10)
    assert read_orientations(table, "strike").dip_direction_deg[0] == pytest.approx(203)


def test_lines_alone_are_read_as_trends(tmp_path: Path) -> None:
    table = tmp_path / "lines.csv"
    table.write_text("structure,azi,inc\nL2,200,10\n")
    assert read_orientations(table).trend_deg.tolist() == [200]


def test_bearing_is_read_as_trend(tmp_path: Path) -> None:
    table = tmp_path / "lines.csv"
    table.write_text("bearing,plunge\n113,47\n")
    rows = read_orientations(table)
    assert (rows.trend_deg.tolist(), rows.plunge_deg.tolist()) == ([113], [47])


def test_gems_states_strikes_by_the_right_hand_rule(tmp_path: Path) -> None:
    table = tmp_path / "gems.csv"
    table.write_text(GEMS)
    rows = read_orientations(table)
    assert rows.is_plane.tolist() == [True, False]
    assert np.allclose([rows.dip_direction_deg[0], rows.dip_deg[0]], [120, 40])
    assert np.allclose([rows.trend_deg[1], rows.plunge_deg[1]], [75, 12])
