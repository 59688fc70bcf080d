"""`vomstudio stats`."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from tests.messages import by_code, messages


def test_published_tensor_and_shape_are_reproduced(run, data_dir: Path) -> None:
    path = data_dir / "planes" / "big_elk_strike_dip.txt"
    ran = run("stats", path, "--azimuth", "strike", "--json")
    assert ran.code == 0
    assert ran.json["n"] == 61
    found = ran.json["sets"]["all"]
    assert (found["n"], found["of"], found["axial"]) == (61, "poles", True)
    assert [round(s, 4) for s in found["tensor"]["eigenvalues"]] == [0.5901, 0.3525, 0.0573]
    assert round(found["woodcock"]["K"], 4) == 0.2837
    assert round(found["woodcock"]["C"], 4) == 2.3312
    assert [round(found["vollmer"][k], 4) for k in "PGR"] == [0.2376, 0.5904, 0.1720]
    assert found["fisher"] is None
    assert "girdle" in found["fisher_reason"]
    assert "right-hand rule" in ran.json["convention"]


def test_fisher_statistics_match_closed_form(run, write) -> None:
    # Four lines at 10 degrees from the vertical: R = 4 cos 10, kappa = 3 / (4 - R).
    ran = run("stats", write("trend,plunge\n0,80\n90,80\n180,80\n270,80\n"), "--json")
    fisher = ran.json["sets"]["all"]["fisher"]
    resultant = 4 * math.cos(math.radians(10))
    assert fisher["R"] == pytest.approx(resultant)
    assert fisher["kappa"] == pytest.approx(3 / (4 - resultant))
    cos_alpha = 1 - (4 - resultant) / resultant * (20 ** (1 / 3) - 1)
    assert fisher["alpha95_deg"] == pytest.approx(math.degrees(math.acos(cos_alpha)))
    assert fisher["plunge_deg"] == pytest.approx(90.0)


def test_axial_lines_near_horizontal_form_one_cluster(run, write) -> None:
    text = "trend,plunge\n10,3\n190,2\n12,1\n188,4\n9,2\n"
    axial = run("stats", write(text), "--json").json["sets"]["all"]
    directed = run("stats", write(text), "--directed", "--json").json["sets"]["all"]
    assert axial["axial"] is True
    assert axial["fisher"]["R"] > 4.9
    assert directed["axial"] is False
    assert directed["fisher"] is None or directed["fisher"]["R"] < 2.0


def test_directed_mean_may_plunge_upwards(run, write) -> None:
    ran = run("stats", write("trend,plunge\n0,-60\n5,-61\n355,-62\n"), "--directed", "--json")
    assert ran.json["sets"]["all"]["fisher"]["plunge_deg"] < -55


def test_sets_are_described_one_by_one(run, write) -> None:
    rng = np.random.default_rng(2)
    rows = ["strike,dip,family"]
    rows += [f"{30 + s:.2f},{80 + d:.2f},J1" for s, d in rng.normal(0, 3, (12, 2))]
    rows += [f"{120 + s:.2f},{80 + d:.2f},J2" for s, d in rng.normal(0, 3, (8, 2))] + ["10,10,"]
    ran = run("stats", write("\n".join(rows)), "--by", "family", "--json")
    sets = ran.json["sets"]
    assert {name: s["n"] for name, s in sets.items()} == {"J1": 12, "J2": 8, "unassigned": 1}
    assert sets["J1"]["fisher"]["trend_deg"] == pytest.approx(300, abs=3)
    assert sets["unassigned"]["fisher"] is None


def test_pooled_kinds_are_reported(run, write) -> None:
    path = write("kind,strike,dip\nbedding,30,40\nbedding,33,42\njoint,200,80\n")
    ran = run("stats", path, "--json")
    assert set(ran.json["sets"]) == {"all"}
    several = by_code(ran.json["warnings"])["stats.several-kinds"]
    assert several["kinds"] == ("bedding", "joint")
    apart = run("stats", path, "--by", "kind", "--json").json
    assert {name: s["n"] for name, s in apart["sets"].items()} == {"bedding": 2, "joint": 1}
    assert not messages(apart)


def test_poles_and_lines_are_never_averaged_together(run, write) -> None:
    text = "element,dipdir,dip,trend,plunge\nplane,10,20,,\nplane,12,20,,\nline,,,100,30\n"
    ran = run("stats", write(text), "--json")
    assert {k: (s["n"], s["of"]) for k, s in ran.json["sets"].items()} == {
        "all (poles)": (2, "poles"),
        "all (lines)": (1, "lines"),
    }
    assert "described separately" in messages(ran.json)[0]


def test_text_output_shows_fisher_statistics(run, write) -> None:
    ran = run("stats", write("trend,plunge\n0,80\n90,80\n180,80\n270,80\n"))
    assert "Fisher mean" in ran.out
    assert "alpha95" in ran.out
    assert "trend/plunge" in ran.err


def test_infinite_kappa_of_identical_planes_is_null(run, write) -> None:
    ran = run("stats", write("strike,dip\n" + "30,40\n" * 4), "--json")
    found = ran.json["sets"]["all"]
    assert found["fisher"]["kappa"] is None
    assert found["tensor"]["eigenvalues"][0] == pytest.approx(1.0)


def test_a_missing_set_column_is_refused(run, write) -> None:
    ran = run("stats", write("strike,dip\n30,40\n"), "--by", "family")
    assert ran.code == 2
    assert "family" in ran.said


def test_planes_are_weighted_by_their_own_errors(run, write) -> None:
    rows = ["dipdir,dip,total95_deg", "40,30,0.5", "41,31,0.5", "60,30,40", "62,31,"]
    path = write("\n".join(rows))
    found = run("stats", path, "--weights", "error", "--json").json["sets"]["all"]
    assert found["weights"]["without_error"] == 1
    assert found["weights"]["column"] == "total95_deg"
    assert run("stats", path, "--json").json["sets"]["all"]["weights"] is None
    assert "natural scatter" in run("stats", path, "--weights", "error").out


def test_weights_without_errors_are_refused(run, write) -> None:
    ran = run("stats", write("dipdir,dip\n40,30\n50,30\n"), "--weights", "error")
    assert ran.code == 2
    assert "total95_deg" in ran.said
