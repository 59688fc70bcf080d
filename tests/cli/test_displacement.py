"""`vomstudio displacement`."""

from __future__ import annotations

import math

import pytest

HEAD = "name,hanging_x,hanging_y,hanging_z,footwall_x,footwall_y,footwall_z\n"
# Ten metres down a fault of 090/60, seen at two places.
STEP = (5.0, 0.0, -10 * math.sin(math.radians(60)))
ROWS = "".join(
    f"{name},{x + STEP[0]},{y},{z + STEP[2]},{x},{y},{z}\n"
    for name, x, y, z in (("A", 433000.0, 5200000.0, 800.0), ("B", 433010.0, 5200040.0, 780.0))
)


def test_piercing_points(run, write) -> None:
    ran = run("displacement", write(HEAD + ROWS), "--fault", "90/60", "--sigma", "0.1", "--json")
    assert ran.code == 0, ran.err
    assert (ran.json["what"], ran.json["n"]) == ("net slip", 2)
    assert ran.json["mean_net_m"] == pytest.approx(10)
    one = ran.json["pairs"][0]["displacement"]
    assert one["heave_m"]["value"] == pytest.approx(5)
    # Two points, each 0.1 m: 1.96 sqrt(2) 0.1.
    assert one["net_m"]["error95"] == pytest.approx(0.277, abs=1e-3)
    words = run("displacement", write(HEAD + ROWS), "--fault", "90/60")
    assert "Net slip" in words.out


def test_cutoffs_with_and_without_a_slip_direction(run, write) -> None:
    path = write(HEAD + ROWS)
    words = ["--fault", "90/60", "--bed", "270/10", "--json"]
    slip = run("displacement", path, *words, "--rake", "90").json
    assert slip["pairs"][0]["displacement"]["net_m"]["value"] == pytest.approx(10)
    same = run("displacement", path, *words, "--slip", "90/60").json
    assert same["mean_net_m"] == pytest.approx(slip["mean_net_m"])
    unknown = run("displacement", path, *words).json
    assert unknown["what"] == "separation"
    assert unknown["pairs"][0]["displacement"] is None
    across = 10 * math.sin(math.radians(70))
    found = unknown["pairs"][0]["separations"]["stratigraphic_m"]
    assert found == {"value": pytest.approx(across), "error95": None}
    assert "no slip" in run("displacement", path, *words[:-1]).out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--fault", "steep"], "--fault"),
        (["--fault", "90/100"], "--fault"),
        (["--fault", "90/60", "--rake", "90"], "--bed"),
        (["--fault", "90/60", "--bed", "90/60"], "no cut-off"),
        (["--fault", "90/60", "--sigma", "-1"], "negative"),
        ([], "--fault"),
    ],
)
def test_wrong_wishes_are_refused(run, write, words: list[str], said: str) -> None:
    ran = run("displacement", write(HEAD + ROWS), *words)
    assert ran.code == 2
    assert said in ran.said


def test_rows_without_all_six_are_skipped_and_said(run, write) -> None:
    ran = run("displacement", write(HEAD + ROWS + "C,1,2,,4,5,6\n"), "--fault", "90/60", "--json")
    assert (ran.code, ran.json["n"]) == (0, 2)
    assert ran.json["skipped"][0]["id"] == "C"
    assert run("displacement", write("1 2 3\n"), "--fault", "90/60").code == 2
    assert run("displacement", write(HEAD + "C,,,,,,\n"), "--fault", "90/60").code == 2
