"""`vomstudio displacement`."""

from __future__ import annotations

import math

import pytest

from tests.messages import by_code, messages

HEAD = "name,hanging_x,hanging_y,hanging_z,footwall_x,footwall_y,footwall_z\n"
# Ten metres down a fault of 090/60, seen at two places.
STEP = (5.0, 0.0, -10 * math.sin(math.radians(60)))
ROWS = "".join(
    f"{name},{x + STEP[0]},{y},{z + STEP[2]},{x},{y},{z}\n"
    for name, x, y, z in (("A", 433000.0, 5200000.0, 800.0), ("B", 433010.0, 5200040.0, 780.0))
)


def remarks(answer: dict) -> list[str]:
    """Return the messages that are not about the frame of the table."""
    return messages({"warnings": [w for w in answer["warnings"] if w["code"] != "frame.assumed"]})


def test_piercing_points_give_net_slip(run, write) -> None:
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


def test_cutoffs_give_displacement_only_with_slip_direction(run, write) -> None:
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
    assert "net slip is unknown" in run("displacement", path, *words[:-1]).out


def test_oblique_slip_follows_direction_of_lineation(run, write) -> None:
    """On a fault that dips east by 45 degrees, striae of rake 30 plunge to the north-north-east:
    north by cos 30, east and down by sin 30 cos 45."""
    way = [math.sin(math.radians(30)) * math.cos(math.radians(45)), math.cos(math.radians(30))]
    slip = [12 * way[0], 12 * way[1], -12 * way[0]]
    # A level bed: the points of its cut-offs may lie anywhere along it.
    row = f"A,{slip[0] + 40},{slip[1] - 25},{slip[2]},0,0,0\n"
    words = ["displacement", write(HEAD + row), "--fault", "90/45", "--bed", "0/0", "--json"]
    trend, plunge = math.degrees(math.atan2(*way)), math.degrees(math.asin(way[0]))
    for told in (["--rake", "30"], ["--slip", f"{trend}/{plunge}"]):
        found = run(*words, *told).json["pairs"][0]["displacement"]
        assert found["net_m"]["value"] == pytest.approx(12)
        assert (found["trend_deg"], found["plunge_deg"]) == pytest.approx((trend, plunge))
        assert found["throw_m"]["value"] == pytest.approx(12 * way[0])
        assert found["heave_m"]["value"] == pytest.approx(12 * way[0])
        # Toward north along a strike of north, and down: sinistral and normal.
        assert found["strike_slip_m"]["value"] == pytest.approx(12 * way[1])
        assert found["dip_slip_m"]["value"] == pytest.approx(-6)
        assert found["slip_rake_deg"] == pytest.approx(-30)


@pytest.mark.parametrize(
    ("words", "code", "field"),
    [
        (["--fault", "steep"], "notation.unknown-word", "--fault"),
        (["--fault", "90/100"], "notation.dip-out-of-range", "--fault"),
        (["--fault", "90/60", "--rake", "90"], "option.requires", "--rake"),
        (["--fault", "90/60", "--bed", "90/60"], "displacement.bed-along-fault", None),
        (["--fault", "90/60", "--bed", "0/0", "--rake", "-30"], "option.out-of-range", "--rake"),
        (["--fault", "90/60", "--rake", "9", "--slip", "9/9"], "option.conflict", "--slip"),
        (["--fault", "90/60", "--sigma", "-1"], "option.out-of-range", "--sigma"),
        ([], "command.arguments-missing", "--fault"),
    ],
)
def test_invalid_options_are_refused(
    run, write, words: list[str], code: str, field: str | None
) -> None:
    ran = run("displacement", write(HEAD + ROWS), *words, "--json")
    error = ran.json["error"]
    assert (ran.code, error["code"], error["field"]) == (2, code, field)


def test_incomplete_rows_are_skipped_and_reported(run, write) -> None:
    ran = run("displacement", write(HEAD + ROWS + "C,1,2,,4,5,6\n"), "--fault", "90/60", "--json")
    assert (ran.code, ran.json["n"]) == (0, 2)
    assert ran.json["skipped"][0]["id"] == "C"
    assert run("displacement", write("1 2 3\n"), "--fault", "90/60").code == 2
    assert run("displacement", write(HEAD + "C,,,,,,\n"), "--fault", "90/60").code == 2


PAIRS = "hanging_x,hanging_y,hanging_z,footwall_x,footwall_y,footwall_z\n"


def test_motion_off_fault_plane_is_reported(run, write) -> None:
    """Five metres east across a fault that dips 65 to 080: 4.46 m of them leave it."""
    table = write(PAIRS + "1005,2000,100,1000,2000,100\n")
    told = run("displacement", table, "--fault", "80/65", "--json").json
    (off,) = [w for w in told["warnings"] if w["code"] == "displacement.motion-off-fault"]
    assert off["distance_m"] == [pytest.approx(4.46, abs=0.005)]
    along = write(PAIRS + "1000.8,1999,97.4,1000,2000,100\n")
    assert not remarks(run("displacement", along, "--fault", "90/73", "--json").json)
    # What the error of the points explains is no doubt about them.
    again = run("displacement", table, "--fault", "80/65", "--sigma", "3", "--json").json
    assert remarks(again) == []


def test_slip_direction_off_fault_plane_is_reported(run, write) -> None:
    table = write(PAIRS + "1005,2000,100,1000,2000,100\n")
    words = ("displacement", table, "--fault", "80/65", "--bed", "330/25", "--slip")
    told = run(*words, "0/80", "--json").json
    off = by_code(told["warnings"])["displacement.slip-off-fault"]
    assert off["angle_deg"] == pytest.approx(22, abs=1)
    assert remarks(run(*words, "80/66", "--json").json) == []


def test_a_rake_needs_a_strike(run, write) -> None:
    table = write(PAIRS + "1009.848,1998.263,300,1000,2000,300\n")
    words = ("displacement", table, "--bed", "300/20")
    ran = run(*words, "--fault", "100/0", "--rake", "90", "--json")
    assert (ran.code, ran.json["error"]["code"]) == (2, "displacement.rake-without-strike")
    level = run(*words, "--fault", "100/0", "--slip", "100/0", "--json").json
    nearly = run(*words, "--fault", "100/0.01", "--rake", "90", "--json").json
    assert level["mean_net_m"] == pytest.approx(nearly["mean_net_m"], rel=1e-3)
    upright = run(*words, "--fault", "290/90", "--rake", "30", "--json").json
    assert any("vertical" in said and "020" in said for said in messages(upright))
    assert remarks(run(*words, "--fault", "110/90", "--rake", "30", "--json").json) == []


def test_rake_on_horizontal_plane_is_measured_from_typed_strike() -> None:
    from vomstudio.products.net.net_options import parse_slip

    for direction in (0.0, 77.0, 200.0):
        level, nearly = (parse_slip(f"{direction}/{dip}/30")[1].line for dip in (0, 0.01))
        turn = (level.trend_deg - nearly.trend_deg + 90.0) % 180.0 - 90.0
        assert abs(turn) < 0.1
