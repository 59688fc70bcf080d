"""The symbols of a map in a drawing for CAD, read back by ezdxf."""

from __future__ import annotations

import shutil
from pathlib import Path

import ezdxf
import numpy as np
import pytest

from vomstudio.project.exports.export import export_project

SPECIMEN = Path(__file__).parents[2] / "specimens" / "schema1.vom"


def test_a_drawing_shows_strike_and_dip_with_text(tmp_path: Path) -> None:
    shutil.copytree(SPECIMEN, tmp_path / "a.vom")
    table = export_project(tmp_path / "a.vom", "dxf", tmp_path / "a.dxf")
    space = ezdxf.readfile(tmp_path / "a.dxf").modelspace()
    placed = [row for row in table.rows if row["x"] is not None]
    expected = [
        str(round(row["dip_deg"] if row["element"] == "plane" else row["plunge_deg"]))
        for row in placed
    ]
    texts = list(space.query("TEXT"))
    assert sorted(t.dxf.text for t in texts) == sorted(expected)
    assert {t.dxf.layer for t in texts} >= {"bedding_symbols", "fault_symbols"}
    # The tick of a plane begins at it and points along its dip direction; the text stands beyond.
    row = next(r for r in placed if r["element"] == "plane" and 10 < r["dip_deg"] < 80)
    place = np.array([row[axis] for axis in "xyz"])
    lines = [np.array([line.dxf.start.xyz, line.dxf.end.xyz]) for line in space.query("LINE")]
    ticks = [line for line in lines if np.abs(line[0] - place).max() < 1e-9]
    turned = np.radians(row["dip_direction_deg"])
    ahead = np.array([np.sin(turned), np.cos(turned), 0.0])
    assert any(
        (tick[1] - tick[0]) @ ahead == pytest.approx(float(np.linalg.norm(tick[1] - tick[0])))
        for tick in ticks
    )
    away = [np.array(t.dxf.align_point.xyz) - place for t in texts]
    nearest = min(away, key=lambda step: float(np.linalg.norm(step - (step @ ahead) * ahead)))
    assert nearest @ ahead > 0
