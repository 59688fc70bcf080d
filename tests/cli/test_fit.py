"""`vomstudio fit`."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from tests.messages import by_code, messages, shown_values
from vomstudio.core.findings import Finding
from vomstudio.core.paths import resource
from vomstudio.geology.profiles import PROFILES_BY_NAME
from vomstudio.io.gate.orientation_files import read_orientations
from vomstudio.project.tables.orientation_table import COLUMNS

PLANE = "x,y,z\n0,0,0\n10,0,1\n0,10,0\n10,10,1.01\n5,3,0.5\n2,8,0.21\n"


def plane_points(dip_direction: float, dip: float, n: int = 30, seed: int = 0) -> np.ndarray:
    """Points of a plane through the origin, a millimetre rough, over 10 m."""
    rng = np.random.default_rng(seed)
    dd, d = math.radians(dip_direction), math.radians(dip)
    strike = np.array([math.cos(dd), -math.sin(dd), 0.0])
    down = np.array([math.sin(dd) * math.cos(d), math.cos(dd) * math.cos(d), -math.sin(d)])
    normal = np.cross(strike, down)
    u, v, w = rng.uniform(-5, 5, n), rng.uniform(-5, 5, n), rng.normal(0, 1e-3, n)
    return np.outer(u, strike) + np.outer(v, down) + np.outer(w, normal)


@pytest.mark.parametrize(
    ("name", "strike", "dip", "largest", "smallest"),
    [
        ("well_defined.txt", 11.266, 3.492, 0.4753, 0.1473),
        ("poorly_defined.txt", 174.212, 13.223, 16.4899, 0.2920),
    ],
)
def test_the_published_traces_give_the_published_planes_and_errors(
    run, data_dir: Path, name: str, strike: float, dip: float, largest: float, smallest: float
) -> None:
    ran = run("fit", data_dir / "planes" / name, "--json")
    assert ran.code == 0
    (row,) = ran.json["planes"]
    assert tuple(row) == COLUMNS
    assert row["id"] == "1"
    assert round(row["strike_rhr_deg"], 3) == strike
    assert round(row["dip_deg"], 3) == dip
    assert round(row["max_angular_error_deg"], 4) == largest
    assert round(row["min_angular_error_deg"], 4) == smallest
    assert ran.json["skipped"] == []


@pytest.mark.parametrize("name", ["planes.xlsx", "planes.gpkg", "planes.JSON"])
def test_table_with_extension_of_another_format_is_refused(
    run, write, tmp_path: Path, name: str
) -> None:
    points = write("x,y,z\n0,0,0\n1,0,0\n0,1,0\n1,1,1\n")
    out = tmp_path / name
    error = run("fit", points, "-o", out, "--json").json["error"]
    assert (error["code"], error["field"]) == ("output.unknown-format", "--output")
    assert not out.exists()


def test_text_output_shows_strike_dip_errors_and_verdict(run, data_dir: Path) -> None:
    ran = run("fit", data_dir / "planes" / "well_defined.txt")
    assert ran.code == 0
    for words in ("101.3/03.5 ± ", "011.3", "0.4753/0.1473", "deg RHR", "quality"):
        assert words in ran.out


def test_groups_are_fitted_separately_in_file_order(run, write) -> None:
    rows = ["x;y;z;trace"]
    for name, (dd, dip) in {"b": (120.0, 30.0), "a": (200.0, 60.0)}.items():
        rows += [";".join([*map(repr, p), name]) for p in plane_points(dd, dip).tolist()]
    ran = run("fit", write("\n".join(rows)), "--by", "trace", "--json")
    b, a = ran.json["planes"]
    assert (b["id"], a["id"]) == ("b", "a")
    assert b["dip_direction_deg"] == pytest.approx(120.0, abs=0.05)
    assert a["dip_deg"] == pytest.approx(60.0, abs=0.05)
    assert b["n_points"] == a["n_points"] == 30


def test_unused_group_column_gives_warning_and_one_plane(run, write) -> None:
    text = "x,y,z,trace\n0,0,0,a\n9,0,0,a\n0,9,1,a\n0,0,3,b\n9,0,3,b\n0,9,4,b\n"
    ran = run("fit", write(text), "--json")
    (row,) = ran.json["planes"]
    assert (row["id"], row["n_points"]) == ("1", 6)
    assert "--by trace" in messages(ran.json)[0]
    assert "--by trace" in ran.err


def test_groups_without_plane_are_skipped_and_others_fitted(run, write) -> None:
    text = "x,y,z,t\n0,0,0,good\n9,0,0,good\n0,9,1,good\n0,0,0,two\n1,1,1,two\n"
    text += "".join(f"{i},{i},{i},straight\n" for i in range(5)) + "4,4,4,same\n" * 4
    ran = run("fit", write(text), "--by", "t", "--json")
    assert ran.code == 0
    assert [row["id"] for row in ran.json["planes"]] == ["good"]
    assert [item["id"] for item in ran.json["skipped"]] == ["two", "straight", "same"]
    assert [Finding.from_dict(item["reason"]) for item in ran.json["skipped"]] == [
        Finding("feature.too-few-points", count=1, minimum=3),
        Finding("points.collinear", n=5),
        Finding("points.coincident", n=4),
    ]


@pytest.mark.parametrize("method", ["pca", "regression"])
def test_both_methods_agree_on_exact_plane(run, write, method: str) -> None:
    points = "\n".join(" ".join(map(repr, p)) for p in plane_points(75.0, 35.0).tolist())
    (row,) = run("fit", write(points), "--method", method, "--json").json["planes"]
    assert row["method"] == method
    assert row["dip_direction_deg"] == pytest.approx(75.0, abs=0.05)
    assert row["dip_deg"] == pytest.approx(35.0, abs=0.05)


def test_three_points_give_a_plane_without_errors(run, write) -> None:
    (row,) = run("fit", write("0 0 0\n1 0 0\n0 1 1\n"), "--json").json["planes"]
    assert row["max_confidence95_deg"] is None
    assert row["max_angular_error_deg"] is None
    assert row["quality"] != "good"
    assert row["dip_deg"] == pytest.approx(45.0)


def test_a_horizontal_plane_is_flagged_as_undefined(run, write) -> None:
    (row,) = run("fit", write("0 0 5\n1 0 5\n0 1 5\n1 1 5\n"), "--json").json["planes"]
    assert row["undefined"] is True
    assert row["dip_deg"] == 0.0
    assert row["z"] == 5.0


def test_written_table_contains_same_planes(run, write, tmp_path: Path) -> None:
    target = tmp_path / "planes.csv"
    ran = run("fit", write(PLANE), "-o", target, "--json")
    assert ran.json["table"] == str(target)
    found = read_orientations(target)
    assert found.dip_deg[0] == pytest.approx(ran.json["planes"][0]["dip_deg"], rel=1e-11)
    again = run("fit", write(PLANE), "-o", target)
    assert "--force" in again.said
    assert run("fit", write(PLANE), "-o", target, "--force").code == 0


@pytest.mark.parametrize(
    "text",
    [
        "0 0 0\n1 1 1\n",
        "".join(f"{i} {2 * i} {3 * i}\n" for i in range(9)),
        "7 7 7\n" * 5,
        "1 2 3\n1e308 0 0\n-1e308 1e308 0\n0 0 1e308\n",
        "1e11 1 2\n1e11 1 2\n1e11 1 2\n",
        "nan nan nan\n",
    ],
)
def test_points_that_define_no_plane_are_refused_in_one_sentence(
    run, write, tmp_path: Path, text: str
) -> None:
    path = write(text)
    target = tmp_path / "out.csv"
    ran = run("fit", path, "-o", target)
    assert ran.code == 2
    assert str(path) in ran.said
    assert ran.out == ""
    assert not target.exists()
    failed = run("fit", path, "--json")
    assert failed.code == 2
    assert list(failed.json) == ["error"]
    assert failed.json["error"]["file"] == str(path)


def test_when_no_group_succeeds_the_command_fails(run, write) -> None:
    ran = run("fit", write("x,y,z,t\n0,0,0,a\n1,1,1,a\n0,0,0,b\n"), "--by", "t", "--json")
    assert ran.code == 2
    error = ran.json["error"]
    assert (error["code"], error["count"], error["field"]) == ("plane.none-fitted", 2, "t a")


def test_written_table_is_accepted_by_other_commands(run, write, tmp_path: Path) -> None:
    rows = ["x,y,z,bed"]
    for name, plane in {"a": (90.0, 20.0), "b": (270.0, 40.0), "c": (92.0, 60.0)}.items():
        rows += [",".join([*map(repr, p), name]) for p in plane_points(*plane).tolist()]
    target = tmp_path / "planes.csv"
    assert run("fit", write("\n".join(rows)), "--by", "bed", "-o", target).code == 0
    fold = run("fold", target, "--json").json
    assert (fold["n"], fold["used"], fold["left_out"]) == (3, 3, [])
    assert run("stats", target, "--json").json["sets"]["all"]["n"] == 3
    net = run("stereonet", target, "-o", tmp_path / "net.svg", "--json")
    assert net.json["n"] == 3
    (info,) = run("info", target, "--json").json["files"]
    assert (info["kind"], info["points"]) == ("table", 3)


@pytest.mark.parametrize("profile", PROFILES_BY_NAME)
def test_verdicts_are_shown_with_their_thresholds(run, write, tmp_path: Path, profile: str) -> None:
    out = tmp_path / "planes.csv"
    ran = run("fit", write(PLANE), "--profile", profile, "-o", out)
    assert ran.out.splitlines()[-1] == PROFILES_BY_NAME[profile].description
    assert f"# profile: {PROFILES_BY_NAME[profile].description}" in out.read_text().splitlines()


def test_planes_keep_kind_and_set_of_their_points(run, write) -> None:
    """Or a fold of the table would pool joints with beds: beta of the sample was 28 degrees off."""
    rows = [
        f"{name},{kind},{set_},{x},{y},{z}"
        for name, kind, set_ in (("B1", "bedding", "west"), ("J1", "joint", ""), ("M1", "", "a"))
        for x, y, z in ((0, 0, 0), (10, 0, 1), (0, 10, 0), (10, 10, 1.01), (5, 3, 0.5))
    ]
    rows[-1] = rows[-1].replace("M1,,a", "M1,fault,a")
    ran = run("fit", write("\n".join(["pick,kind,set,x,y,z", *rows])), "--by", "pick", "--json")
    said = {row["id"]: (row["kind"], row["set"]) for row in ran.json["planes"]}
    assert said == {"B1": ("bedding", "west"), "J1": ("joint", None), "M1": (None, "a")}
    several = by_code(ran.json["warnings"])["table.several-words"]
    assert (several["names"], several["column"]) == (("M1",), "kind")
    by_set = run("fit", write("\n".join(["pick,kind,set,x,y,z", *rows[:5]])), "--by", "set")
    assert by_set.code == 0


def test_tutorial_steps_find_fold_axis_of_sample(run, tmp_path: Path) -> None:
    planes = tmp_path / "planes.csv"
    picks = resource("sample", "picks.csv")
    assert run("fit", picks, "--by", "pick", "-o", planes).code == 0
    found = run("fold", planes, "--json").json
    beta = found["beta"]
    assert {each["what"] for each in found["left_out"]} == {"fault", "joint"}
    off = np.hypot(
        (beta["trend_deg"] - 31.0) * math.cos(math.radians(11.0)), beta["plunge_deg"] - 11.0
    )
    assert off < beta["max_confidence95_deg"] < 5.0


def test_straight_traces_report_what_they_determine(run, tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    t = np.linspace(0.0, 5.0, 60)
    rows = ["id,x,y,z"]
    for name, way in (("A", (0.0, 1.0, 0.0)), ("B", (np.cos(0.7), 0.0, -np.sin(0.7)))):
        points = np.outer(t, way) + rng.normal(0.0, 0.01, (60, 3))
        rows += [f"{name},{x:.4f},{y:.4f},{z:.4f}" for x, y, z in points]
    traces, sets = tmp_path / "traces.csv", tmp_path / "sets.csv"
    traces.write_text("\n".join(rows) + "\n")
    planes = ["dip_direction,dip,set"]
    for dip_direction, dip, name in ((90.0, 40.0, "bed"), (180.0, 60.0, "joint")):
        for a, d in rng.normal(0.0, 5.0, (20, 2)):
            planes.append(f"{dip_direction + a:.1f},{dip + d:.1f},{name}")
    sets.write_text("\n".join(planes) + "\n")
    ran = run("fit", traces, "--by", "id", "--sets-table", sets, "--crossing", "A,B", "--json")
    assert ran.code == 0
    first = ran.json["bands"][0]
    assert first["id"] == "A"
    assert first["plunge_deg"] == pytest.approx(0.0, abs=0.5)
    assert first["lowest_dip_deg"] == pytest.approx(0.0, abs=0.5)
    assert first["highest_dip_deg"] == pytest.approx(90.0, abs=0.5)
    assert [each["compatible"] for each in first["sets"]] == [True, False]
    assert first["sets"][0]["name"] == "bed"
    total = first["none_probability"] + sum(each["probability"] for each in first["sets"])
    assert total == pytest.approx(1.0)
    (crossing,) = ran.json["crossings"]
    assert crossing["dip_direction_deg"] == pytest.approx(90.0, abs=1.0)
    assert crossing["dip_deg"] == pytest.approx(np.degrees(0.7), abs=1.0)
    said = run("fit", traces, "--by", "id").out
    assert shown_values(said, "trace.straight")["width_deg"]
    assert run("fit", traces, "--by", "id", "--crossing", "A,C").code == 2
    assert run("fit", traces, "--crossing", "1,1").code == 2
    assert run("fit", traces, "--sets-table", traces).code == 2
