"""`vs.agreement`: tables and files in, the names of the command out."""

from __future__ import annotations

import pytest

import vomstudio as vs
from tests.messages import refused


def test_planes_agree_with_themselves_but_not_with_rotated_copies(tmp_path) -> None:
    import pandas as pd

    picks = pd.read_csv(vs.sample("picks.csv"), comment="#")
    planes = vs.fit_planes(picks, by="pick")
    planes["name"] = planes["id"]
    path = tmp_path / "planes.csv"
    planes.to_csv(path, index=False)
    same = vs.agreement(planes, path)
    assert same.n == len(planes)
    assert same.rms_angle_deg == pytest.approx(0.0, abs=1e-5)
    assert same.agree_share == 1.0
    turned = planes.copy()
    turned["dip_direction_deg"] = (turned["dip_direction_deg"] + 30.0) % 360.0
    turned = turned.drop(columns=[c for c in turned if c.startswith(("strike", "pole", "normal"))])
    found = vs.agreement(planes, turned)
    assert found.n == len(planes)
    assert found.median_angle_deg > 5.0
    assert found.agree_share < 0.5


def test_a_table_without_planes_is_refused(tmp_path) -> None:
    path = tmp_path / "lines.csv"
    path.write_text("trend,plunge\n10,20\n")
    with refused("orientation.no-planes", file=path):
        vs.agreement(path, path)
