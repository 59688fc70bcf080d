"""`vomstudio fold`."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.messages import shown_codes
from vomstudio.io.text.orientation_reading import FILE_NAME_CONVENTION

# Beds of an upright fold about a horizontal north-south axis.
FOLD = [(90, 20), (90, 40), (90, 60), (270, 30), (270, 50), (88, 30), (272, 45)]


def table(*columns: str, rows: list[tuple[object, ...]]) -> str:
    return "\n".join([",".join(columns), *(",".join(map(str, row)) for row in rows)]) + "\n"


def test_the_published_anticline_gives_its_published_axis(run, data_dir: Path) -> None:
    path = data_dir / "planes" / "big_elk_strike_dip.txt"
    ran = run("fold", path, "--azimuth", "strike", "--json")
    assert ran.code == 0
    found = ran.json
    assert (found["n"], found["used"], found["left_out"]) == (61, 61, [])
    assert round(found["beta"]["trend_deg"], 1) == 125.3
    assert round(found["beta"]["plunge_deg"], 1) == 26.1
    assert round(found["pi_plane"]["strike_rhr_deg"], 1) == 215.3
    assert round(found["pi_plane"]["dip_deg"], 1) == 63.9
    assert found["valid"] in ("yes", "conditional", "no")
    assert found["verdict"] != "cylindrical"
    assert found["reasons"]


def test_file_with_header_needs_no_azimuth_option(run, write, data_dir: Path) -> None:
    text = (data_dir / "planes" / "big_elk_strike_dip.txt").read_text()
    found = run("fold", write("strike\tdip\n" + text, "elk.txt"), "--json").json
    assert round(found["beta"]["trend_deg"], 1) == 125.3
    assert round(found["beta"]["plunge_deg"], 1) == 26.1


def test_file_name_can_state_the_azimuth_convention(run, data_dir: Path) -> None:
    found = run("fold", data_dir / "planes" / "big_elk_strike_dip.txt", "--json").json
    assert round(found["beta"]["trend_deg"], 1) == 125.3
    assert FILE_NAME_CONVENTION in found["convention"]


def test_ambiguous_azimuth_is_refused_with_suggested_option(run, write, data_dir: Path) -> None:
    text = (data_dir / "planes" / "big_elk_strike_dip.txt").read_text()
    ran = run("fold", write(text, "elk.txt"))
    assert ran.code == 2
    assert "--azimuth strike" in ran.said


def test_only_bedding_is_used_from_table_with_kinds(run, write) -> None:
    rows = [("bedding", *bed) for bed in FOLD] + [("joint", 0, 85), ("Joint", 5, 80), ("", 0, 70)]
    path = write(table("kind", "dipdir", "dip", rows=rows))
    found = run("fold", path, "--json").json
    assert (found["n"], found["used"]) == (10, 7)
    assert {(o["what"], o["n"]) for o in found["left_out"]} == {
        ("joint", 1),
        ("Joint", 1),
        ("no kind", 1),
    }
    assert found["beta"]["plunge_deg"] == pytest.approx(0.0, abs=1.0)
    assert "left out" in run("fold", path).out


def test_kind_option_selects_another_kind(run, write) -> None:
    rows = [("bedding", 0, 30)] + [("Foliation", *bed) for bed in FOLD]
    found = run(
        "fold", write(table("kind", "dipdir", "dip", rows=rows)), "--kind", "foliation", "--json"
    ).json
    assert found["used"] == 7
    assert found["left_out"][0]["what"] == "bedding"


def test_table_without_bedding_is_refused_with_its_kinds(run, write) -> None:
    ran = run("fold", write(table("kind", "dipdir", "dip", rows=[("joint", 1, 2), ("vein", 3, 4)])))
    assert ran.code == 2
    assert "joint, vein" in ran.said


def test_kind_option_is_refused_for_table_without_kinds(run, write) -> None:
    ran = run("fold", write(table("dipdir", "dip", rows=FOLD)), "--kind", "bedding")
    assert ran.code == 2
    assert "--kind" in ran.said


def test_lines_are_left_out_and_reported(run, write) -> None:
    rows = [(*bed, "", "") for bed in FOLD] + [("", "", 10, 5)]
    found = run("fold", write(table("dipdir", "dip", "trend", "plunge", rows=rows)), "--json").json
    assert (found["n"], found["used"]) == (8, 7)
    (left_out,) = found["left_out"]
    assert (left_out["what"], left_out["n"]) == ("lines", 1)
    assert left_out["reason"]["code"] == "fold.only-planes"


def test_axis_of_two_sets_is_intersection_of_their_means(run, write) -> None:
    # Beds dip 30 to the east, the fault 60 to the west: both contain the north-south line.
    rows = [("beds", 90, 30)] * 3 + [("fault", 270, 60)] * 2 + [("other", 10, 80)]
    found = run(
        "fold", write(table("set", "dipdir", "dip", rows=rows)), "--sets", "beds,fault", "--json"
    ).json
    assert (found["n"], found["used"]) == (6, 5)
    assert found["left_out"][0]["what"] == "other"
    assert found["beta"]["plunge_deg"] == pytest.approx(0.0, abs=1e-6)
    assert min(found["beta"]["trend_deg"] % 180, 180 - found["beta"]["trend_deg"] % 180) < 1e-6


def test_kinds_serve_as_sets_in_table_without_set_column(run, write) -> None:
    rows = [("bedding", 90, 30), ("bedding", 90, 32), ("fault", 270, 60), ("fault", 270, 61)]
    path = write(table("kind", "dipdir", "dip", rows=rows))
    found = run("fold", path, "--sets", "bedding,fault", "--json").json
    assert found["used"] == 4
    assert found["beta"]["plunge_deg"] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("sets", ["beds", "beds,", "beds,beds", "beds,none"])
def test_invalid_pairs_of_sets_are_refused(run, write, sets: str) -> None:
    path = write(table("set", "dipdir", "dip", rows=[("beds", 90, 30), ("fault", 270, 60)]))
    ran = run("fold", path, "--sets", sets)
    assert ran.code == 2
    assert "--sets" in ran.said


@pytest.mark.parametrize("rows", [[(90, 30)], [(90, 30)] * 5])
def test_planes_that_define_no_axis_are_refused(run, write, rows: list[tuple[int, int]]) -> None:
    path = write(table("dipdir", "dip", rows=rows))
    ran = run("fold", path, "--json")
    assert ran.code == 2
    code = "fold.one-plane" if len(rows) == 1 else "fold.parallel-planes"
    assert (ran.json["error"]["code"], ran.json["error"]["n"]) == (code, len(rows))
    assert ran.json["error"]["file"] == str(path)


def test_table_with_only_lines_is_refused(run, write) -> None:
    assert "lines" in run("fold", write("trend,plunge\n1,2\n3,4\n")).said


SETS = [("hw", 90, 30), ("hw", 92, 31), ("hw", 88, 29), ("hw", 91, 28)]
SETS += [("fw", 150, 50), ("fw", 151, 52), ("fw", 148, 49), ("fw", 152, 51)]
SETS += [("f", 270, 60), ("f", 272, 61), ("f", 268, 59)]


def test_beds_and_non_coplanar_fault_have_two_axes(run, write) -> None:
    path = write(table("set", "dipdir", "dip", rows=SETS))
    found = run("fold", path, "--sets", "hw,fw,f", "--json").json
    assert (found["verdict"], found["valid"]) == ("two axes", "no")
    assert [pair["sets"] for pair in found["pairs"]] == [["hw", "fw"], ["hw", "f"], ["fw", "f"]]
    # Each wall meets the fault in its own line: N-S and horizontal, and about 204/36.
    assert abs(found["pairs"][1]["trend_deg"] % 180) < 2
    assert found["pairs"][1]["plunge_deg"] < 2
    assert "two axes" in run("fold", path, "--sets", "hw,fw,f").out


def test_outliers_of_fold_are_reported_by_id(run, write) -> None:
    beds = [(f"B{k}", 90 if k < 10 else 270, 15 + 5 * (k % 10)) for k in range(20)]
    path = write(table("id", "dipdir", "dip", rows=[*beds, ("J1", 0, 85), ("J2", 181, 88)]))
    found = run("fold", path, "--json").json
    assert [stray["id"] for stray in found["strays"]] == ["J1", "J2"]
    assert (found["verdict"], found["valid"]) == ("cylindrical", "conditional")


def test_domains_have_their_own_axes(run, write) -> None:
    path = write(table("set", "dipdir", "dip", rows=SETS))
    found = run("fold", path, "--by", "set", "--json").json
    assert set(found["domains"]) == {"hw", "fw", "f"}
    assert found["domains"]["hw"]["axis"]["verdict"] == "homoclinal"
    assert found["one_axis"]["serves_all"] is False
    assert found["one_axis"]["apart_deg"] is None
    assert found["one_axis"]["beds_off_deg"] > 5.0
    assert found["valid"] == "no"
    assert found["leave_one_out"]["id"]


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (["--by", "set", "--sets", "hw,fw"], "option.conflict"),
        (["--by", "nothing"], "table.unknown-column"),
        (["--sets", "hw,HW"], "fold.too-few-sets"),
        (["--waviness", "-1"], "option.out-of-range"),
        (["--waviness", "nan"], "option.out-of-range"),
    ],
)
def test_invalid_options_are_refused(run, write, words: list[str], code: str) -> None:
    ran = run("fold", write(table("set", "dipdir", "dip", rows=SETS)), *words, "--json")
    assert (ran.code, ran.json["error"]["code"]) == (2, code)


def test_one_domain_is_refused(run, write) -> None:
    ran = run("fold", write(table("set", "dipdir", "dip", rows=SETS[:4])), "--by", "set")
    assert ran.code == 2
    assert "fold.one-domain" in shown_codes(ran.said)


def test_overturned_beds_reduce_interlimb_angle(run, write) -> None:
    """One limb dips by 30 to the east, the other by 60 and is overturned: 30 degrees of a tight
    fold, where 150 would be told of beds that are all upright."""
    rows = [
        (90, 29, ""),
        (90, 30, ""),
        (90, 31, ""),
        (90, 59, "true"),
        (90, 60, "true"),
        (90, 61, "yes"),
        (92, 30, ""),
        (88, 60, "x"),
    ]
    found = run("fold", write(table("dipdir", "dip", "overturned", rows=rows)), "--json").json
    limbs = found["limbs"]
    assert sorted(limbs["overturned"]) == [False, True]
    assert abs(limbs["interlimb_angle_deg"] - 30.0) <= limbs["interlimb_error95_deg"] < 3.0
    assert limbs["axial_plane"]["dip_deg"] == pytest.approx(45.0, abs=1.0)
