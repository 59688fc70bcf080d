"""`vomstudio log` and `vomstudio threepoint`, and the same in Python."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

import vomstudio as vs

LOG = (
    "name,x,y,z,lithology,notes\na,0,0,0,sandstone,=1+1\nb,10,0,0,limestone,\nc,20,0,0,,\nd,,,,,\n"
)
BENNISON = "393 2374 550\n1891 2738 650\n2191 1037 450\n"
"""Bennison (1990), coal seam in three boreholes: strike 106.45, dip 7.37, as Cardozo solves it in
Computational structural geology, notebook 4."""


def test_a_log_is_told_and_written(run, write, tmp_path: Path) -> None:
    target = tmp_path / "log.csv"
    words = ["--bed", "90/30", "--bed-error", "2", "--sigma", "0.01", "-o", target]
    ran = run("log", write(LOG), *words, "--json")
    assert ran.code == 0
    assert ran.json["n"] == 3
    assert ran.json["dropped_lines"] == [5]
    first, second = ran.json["intervals"]
    assert first["thickness_m"]["value"] == pytest.approx(5.0)
    assert first["strabospot"]["siliciclastic_type"] == "sandstone"
    assert second["strabospot"]["primary_lithology"] == "limestone"
    assert ran.json["total_m"]["value"] == pytest.approx(10.0)
    rows = [r for r in csv.reader(target.read_text("utf-8").splitlines()) if r[0][0] != "#"]
    assert rows[0][:6] == ["number", "base", "top", "base_m", "top_m", "thickness_m"]
    assert rows[1][:6] == ["1", "a", "b", "0.0000", "5.0000", "5.0000"]
    assert rows[1][-1] == "'=1+1"
    text = run("log", write(LOG), *words, "--force")
    assert "sandstone" in text.out
    assert run("log", write(LOG), *words).code == 2
    for wrong in (["--bed", "90"], ["--bed", "90/95"], ["--bed", "9/9", "--sigma", "-1"]):
        assert run("log", write(LOG), *wrong).code == 2
    assert run("log", write("1 2 3\n"), "--bed", "9/9").code == 2


def test_bennisons_seam_has_the_published_attitude(run, write) -> None:
    ran = run("threepoint", write(BENNISON), "--sigma", "5", "--json")
    assert ran.code == 0
    assert ran.json["strike_rhr_deg"] == pytest.approx(106.45, abs=0.005)
    assert ran.json["dip_deg"] == pytest.approx(7.37, abs=0.005)
    assert 0 < ran.json["dip_error_deg"] < 1
    assert ran.json["max_confidence95_deg"] > ran.json["dip_error_deg"]
    assert "196.4/07.4, dip ± " in run("threepoint", write(BENNISON), "--sigma", "5").out
    assert "nothing is known" in run("threepoint", write(BENNISON)).out
    for wrong in ("0 0 0\n1 1 1\n2 2 2\n", "0 0 0\n1 1 1\n", "0 0 0\n1 1 1\n2 2 2\n3 3 3\n"):
        assert run("threepoint", write(wrong)).code == 2
    assert run("threepoint", write(BENNISON), "--sigma", "-1").code == 2


def test_more_than_three_points_tell_their_own_error(run, write) -> None:
    """A fourth borehole two metres above the seam of the others."""
    fourth = "1000 1500 %s\n"
    exact = run("threepoint", write(BENNISON), "--json").json
    assert (exact["n"], exact["rms_m"], exact["max_confidence95_deg"]) == (3, None, None)
    found = run("threepoint", write(BENNISON + fourth % 480.0), "--json").json
    assert found["n"] == 4
    assert found["rms_m"] > 0
    assert found["sigma_m"] == pytest.approx(2.0 * found["rms_m"])
    stated = run("threepoint", write(BENNISON + fourth % 480.0), "--sigma", "5", "--json").json
    assert stated["sigma_m"] == 5.0
    assert stated["dip_deg"] == found["dip_deg"]


def test_scripts_find_the_same(write) -> None:
    points = np.array([[float(w) for w in line.split()] for line in BENNISON.splitlines()])
    seam = vs.threepoint(points, sigma_m=5.0)
    assert seam.dip_deg == pytest.approx(7.37, abs=0.005)
    assert seam.as_dict() == vs.threepoint(write(BENNISON), sigma_m=5.0).as_dict()
    assert "dip_direction_deg" in repr(seam)
    found = vs.log(write(LOG), bed=(90, 30))
    assert [i.lithology for i in found.intervals] == ["sandstone", "limestone"]
    moved = vs.displacement([[5.0, 0.0, -8.660254, 0.0, 0.0, 0.0]], fault=(90, 60), sigma_m=0.1)
    assert moved.what == "net slip"
    assert moved.mean_throw_m == pytest.approx(8.66, abs=0.01)
    cut = vs.displacement(
        [[5.0, 0.0, -8.660254, 0.0, 0.0, 0.0]], fault=(90, 60), bed=(0, 0), slip=(90, 60)
    )
    assert cut.mean_net_m == pytest.approx(10.0, abs=0.01)
    with pytest.raises(vs.errors.UsageError):
        vs.displacement([[0] * 6], fault=(90, 60), bed=(0, 0), rake_deg=90, slip=(90, 60))
    with pytest.raises(vs.errors.UsageError):
        vs.threepoint([[0, 0], [1, 1], [2, 2]])
