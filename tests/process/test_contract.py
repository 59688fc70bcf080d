"""The promises of the command line, tested from outside: words in, exit code and streams out."""

from __future__ import annotations

import csv
import json
import math
import os
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.messages import codes, messages
from tests.tiers import first_in_default_tier
from vomstudio.cli import main

Points = NDArray[np.float64]
COLUMNS = """
id name kind element set dip_direction_deg dip_deg strike_rhr_deg pole_trend_deg pole_plunge_deg
trend_deg plunge_deg rake_deg slip_rake_deg slip_sense slip_confidence on_plane
on_plane_dip_direction_deg on_plane_dip_deg overturned undefined x y z normal_x normal_y normal_z
n_points extent_m area_m2 rms_m lambda1 lambda2 lambda3 coplanarity collinearity M K
max_angular_error_deg min_angular_error_deg max_confidence95_deg min_confidence95_deg
error_rake_deg dip_error_deg dip_direction_error_deg registration_error_deg total95_deg
normal_cov_ee normal_cov_en normal_cov_eu normal_cov_nn normal_cov_nu normal_cov_uu
resolution_m extent_over_resolution bend_deg attitude_scale quality quality_reason reason_codes
quality_notes profile method model frame notes
""".split()  # noqa: SIM905
INFO_KEYS = {
    "path",
    "kind",
    "points",
    "faces",
    "materials",
    "textures",
    "bounds",
    "crs",
    "resolution_m",
    "fields",
    "warnings",
}


@dataclass(frozen=True)
class Said:
    code: int
    out: str
    err: str

    @property
    def json(self) -> dict[str, Any]:
        def refuse(constant: str) -> None:
            raise AssertionError(f"{constant} is no JSON")

        assert self.out.count("\n") == 1
        assert self.out.endswith("\n")
        found = json.loads(self.out, parse_constant=refuse)
        assert isinstance(found, dict)
        return found

    @property
    def error(self) -> dict[str, Any]:
        assert self.code == 2
        assert "Traceback" not in self.err
        found: dict[str, Any] = self.json["error"]
        assert set(found) >= {"code", "file", "line", "field", "message"}
        assert found["message"]
        return found


@pytest.fixture
def vom(capfd: pytest.CaptureFixture[str]) -> Callable[..., Said]:
    def run(*words: object) -> Said:
        capfd.readouterr()
        code = main([str(word) for word in words])
        out, err = capfd.readouterr()
        return Said(code, out, err)

    return run


@pytest.fixture
def file(tmp_path: Path) -> Callable[..., Path]:
    def write(content: str | bytes, name: str = "in.csv") -> Path:
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


def plane_points(direction: float, dip: float, n: int = 24) -> Points:
    """Points scattered by a centimetre about a plane through the origin."""
    rng = np.random.default_rng(7)
    a, d = math.radians(direction), math.radians(dip)
    normal = np.array([math.sin(a) * math.sin(d), math.cos(a) * math.sin(d), math.cos(d)])
    along = np.array([math.cos(a), -math.sin(a), 0.0])
    spread = rng.uniform(-10, 10, (n, 2))
    found: Points = spread @ np.array([along, np.cross(normal, along)])
    return found + 0.01 * rng.standard_normal((n, 1)) * normal


def lines_of(points: Points, delimiter: str = ",", header: str = "", comma: bool = False) -> str:
    rows = [delimiter.join(f"{value:.9f}" for value in row) for row in points]
    text = "\n".join([header] * bool(header) + rows) + "\n"
    return text.replace(".", ",") if comma else text


# What stdout and stderr carry


@pytest.mark.parametrize(
    "words",
    [
        ["fit", "gone.csv"],
        ["stats", "gone.csv"],
        ["fold", "gone.csv"],
        ["info", "gone.obj"],
        ["stereonet", "gone.csv", "-o", "n.svg"],
        ["export", "gone.vom", "--to", "csv", "-o", "o"],
        ["fit"],
        ["fit", "a", "--method", "magic"],
        ["nonsense"],
        ["stereonet", "a.csv"],
    ],
)
def test_every_failure_exits_with_2_one_line_and_an_error_object(
    vom: Callable[..., Said], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: list[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    said = vom(*words, "--json")
    assert said.error
    assert len(said.err.splitlines()) == 1
    assert not list(tmp_path.iterdir())


# Points


@pytest.mark.parametrize(
    "content",
    [
        lines_of(plane_points(123, 34)),
        lines_of(plane_points(123, 34), ";"),
        lines_of(plane_points(123, 34), "\t"),
        lines_of(plane_points(123, 34), "   "),
        lines_of(plane_points(123, 34), ";", comma=True),
        lines_of(plane_points(123, 34), "\t", "X\tY\tZ", comma=True),
        lines_of(plane_points(123, 34), ",", "x,y,z"),
        lines_of(plane_points(123, 34), ",", "# made by\nEasting,Northing,Elevation"),
        "\ufeff" + lines_of(plane_points(123, 34), ",", "x,y,z"),
        lines_of(plane_points(123, 34), ",", "x,y,z").replace("\n", "\r\n"),
    ],
)
def test_every_common_point_format_gives_the_same_plane(
    vom: Callable[..., Said], file: Callable[..., Path], content: str
) -> None:
    (row,) = vom("fit", file(content), "--json").json["planes"]
    assert (row["id"], row["n_points"]) == ("1", 24)
    assert row["dip_deg"] == pytest.approx(34, abs=0.2)
    assert row["dip_direction_deg"] == pytest.approx(123, abs=0.3)


def test_decimal_commas_between_spaces_are_refused(
    vom: Callable[..., Said], file: Callable[..., Path]
) -> None:
    assert vom("fit", file(lines_of(plane_points(1, 2), " ", comma=True)), "--json").error["line"]


def test_rows_without_numbers_are_dropped_and_reported_by_line(
    vom: Callable[..., Said], file: Callable[..., Path]
) -> None:
    rows = lines_of(plane_points(80, 20)).splitlines()
    rows[2:2] = ["nan,1,2", "# a remark", "1,,2"]
    found = vom("fit", file("\n".join(["x,y,z", *rows])), "--json").json
    assert found["planes"][0]["n_points"] == 24
    assert found["dropped_lines"] == [4, 6]


@pytest.mark.parametrize(("header", "by"), [("x,y,z,bed\n", "bed"), ("x,y,z,bed\n", 4), ("", 4)])
def test_groups_are_selected_by_column_name_or_number(
    vom: Callable[..., Said], file: Callable[..., Path], header: str, by: object
) -> None:
    first, second = plane_points(10, 20, 12), plane_points(200, 70, 9)
    mixed = [(*p, 1) for p in first] + [(*p, 2) for p in second]
    text = header + "".join(f"{x:.6f},{y:.6f},{z:.6f},{g}\n" for x, y, z, g in mixed[::-1])
    rows = vom("fit", file(text), "--by", by, "--json").json["planes"]
    assert {row["id"]: row["n_points"] for row in rows} == {"1": 12, "2": 9}
    alone = vom("fit", file(text), "--json")
    assert len(alone.json["planes"]) == 1
    assert any("--by" in warning for warning in messages(alone.json))


def test_rotating_the_points_changes_only_the_azimuth(
    vom: Callable[..., Said], file: Callable[..., Path]
) -> None:
    points = plane_points(123, 34)
    (before,) = vom("fit", file(lines_of(points)), "--json").json["planes"]
    a = math.radians(-30)  # clockwise
    turn = np.array([[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]])
    (after,) = vom("fit", file(lines_of(points @ turn.T)), "--json").json["planes"]
    turned = (after["dip_direction_deg"] - before["dip_direction_deg"]) % 360
    assert turned == pytest.approx(30, abs=1e-5)
    for name in ("dip_deg", "rms_m", "M", "K", "max_angular_error_deg", "max_confidence95_deg"):
        assert after[name] == pytest.approx(before[name], rel=1e-4), name


@pytest.mark.parametrize("order", [1, -1])
def test_shifting_scaling_and_reversing_points_keeps_the_angles(
    vom: Callable[..., Said], file: Callable[..., Path], order: int
) -> None:
    points = plane_points(123, 34)
    (before,) = vom("fit", file(lines_of(points)), "--json").json["planes"]
    moved = 3.0 * points[::order] + [576_665.0, 5_188_117.0, 156.0]
    (after,) = vom("fit", file(lines_of(moved)), "--json").json["planes"]
    assert after["rms_m"] == pytest.approx(3 * before["rms_m"], rel=1e-4)
    for name in ("dip_direction_deg", "dip_deg", "coplanarity", "max_confidence95_deg"):
        assert after[name] == pytest.approx(before[name], rel=1e-4), name


# Orientation tables

POLE = (300.0, 50.0)
"""Of the plane that dips 40 degrees toward 120."""


@pytest.mark.parametrize(
    "table",
    [
        "strike,dip\n30,40\n",
        "Strike (RHR);Dip\n30;40\n",
        "strike_rhr_deg,dip_deg\n30,40\n",
        "strike\tdip\n390\t40\n",
        "STRIKE DIP\n30 40\n",
        "strike;dip\n30,0;40,0\n",
        "strike,dip,quadrant\n210,40,SE\n",
        "strike,dip,Dip Quadrant\n30,40,SE\n",
        "strike,dip,dip_direction\n210,40,SE\n",
        "strike,dip,direction\n210,40,SE\n",
        "strike,dip\n210,40SE\n",
        "strike,dip\nN30E,40SE\n",
        "dip_dir,dip\n120,40\n",
        "Dip Direction,Dip\n120,40\n",
        "dip,DipDir\n40,480\n",
        "pole_trend_deg,pole_plunge_deg\n300,50\n",
    ],
)
def test_every_common_notation_of_a_plane_has_the_same_pole(
    vom: Callable[..., Said], file: Callable[..., Path], table: str
) -> None:
    found = vom("stats", file(table), "--json").json
    axis = found["sets"]["all"]["tensor"]["axes"][0]
    assert (axis["trend_deg"], axis["plunge_deg"]) == pytest.approx(POLE)
    assert found["convention"]


@pytest.mark.parametrize("header", ["azimuth,dip\n", "Azimuth;Dip\n", ""])
def test_azimuth_of_unknown_meaning_is_rejected_until_specified(
    vom: Callable[..., Said], file: Callable[..., Path], header: str
) -> None:
    table = file(header + ("30;40\n" if ";" in header else "30,40\n"))
    assert "--azimuth" in vom("stats", table, "--json").error["message"]
    for told, trend in (("strike", 300), ("dipdir", 210)):
        found = vom("stats", table, "--azimuth", told, "--json").json
        assert found["sets"]["all"]["tensor"]["axes"][0]["trend_deg"] == pytest.approx(trend)


@pytest.mark.parametrize(
    ("row", "line"), [("30,140", 3), ("30,-4", 3), ("abc,40", 3), ("30", 3), ("30,40,NE", 3)]
)
def test_impossible_plane_is_rejected_with_its_line(
    vom: Callable[..., Said], file: Callable[..., Path], row: str, line: int
) -> None:
    wide = row.count(",") == 2
    text = "strike,dip,quadrant\n30,40,SE\n" if wide else "strike,dip\n30,40\n"
    assert vom("stats", file(text + row + "\n"), "--json").error["line"] == line


# Statistics

ICELAND = [
    (343.2, 66.1),
    (62.0, 68.7),
    (36.9, 70.1),
    (27.0, 82.1),
    (359.0, 79.5),
    (5.7, 73.0),
    (50.4, 69.3),
    (357.6, 58.8),
    (44.0, 51.4),
]


def lines_table(lines: Sequence[tuple[float, float]]) -> str:
    return "trend,plunge\n" + "".join(f"{t},{p}\n" for t, p in lines)


def test_fisher_statistics_follow_the_resultant_and_the_exact_cone(
    vom: Callable[..., Said], file: Callable[..., Path]
) -> None:
    t, p = np.radians(ICELAND).T
    total = np.array([np.sin(t) * np.cos(p), np.cos(t) * np.cos(p), -np.sin(p)]).sum(axis=1)
    n, length = len(ICELAND), float(np.linalg.norm(total))
    found = vom("stats", file(lines_table(ICELAND)), "--directed", "--json").json["sets"]["all"]
    fisher = found["fisher"]
    assert (found["of"], found["axial"]) == ("lines", False)
    assert fisher["R"] == pytest.approx(length)
    assert fisher["kappa"] == pytest.approx((n - 1) / (n - length))
    cosine = 1 - (n - length) / length * (20 ** (1 / (n - 1)) - 1)
    assert fisher["alpha95_deg"] == pytest.approx(math.degrees(math.acos(cosine)))
    assert fisher["plunge_deg"] == pytest.approx(math.degrees(math.asin(-total[2] / length)))


def test_directed_mean_may_point_up_but_axial_mean_never_does(
    vom: Callable[..., Said], file: Callable[..., Path]
) -> None:
    table = file(lines_table([(10, -40), (12, -42), (14, -38)]))
    up = vom("stats", table, "--directed", "--json").json["sets"]["all"]["fisher"]
    down = vom("stats", table, "--json").json["sets"]["all"]["fisher"]
    assert up["plunge_deg"] == pytest.approx(-40, abs=0.5)
    assert down["plunge_deg"] == pytest.approx(-up["plunge_deg"])
    assert down["trend_deg"] == pytest.approx((up["trend_deg"] + 180) % 360)


@pytest.mark.parametrize("planes", ["90,80\n270,80\n", "90,80\n270,80\n80,85\n260,85\n"])
def test_steep_planes_dipping_both_ways_form_one_axial_cluster(
    vom: Callable[..., Said], file: Callable[..., Path], planes: str
) -> None:
    found = vom("stats", file("dip_dir,dip\n" + planes), "--json").json["sets"]["all"]
    assert found["axial"] is True
    assert found["fisher"]["R"] > 0.95 * found["n"]


def test_a_girdle_has_a_shape_but_no_fisher_mean(
    vom: Callable[..., Said], file: Callable[..., Path]
) -> None:
    table = file(lines_table([(a, 0) for a in range(0, 180, 10)]))
    found = vom("stats", table, "--json").json["sets"]["all"]
    assert found["fisher"] is None
    assert found["fisher_reason"]
    assert found["vollmer"]["G"] == pytest.approx(1)
    assert found["woodcock"]["C"] is None


def test_woodcock_k_is_null_if_the_two_smaller_eigenvalues_are_equal(
    vom: Callable[..., Said], file: Callable[..., Path]
) -> None:
    for lines in ([(0, 70), (90, 70), (180, 70), (270, 70)], [(30, 40)] * 3):
        shape = vom("stats", file(lines_table(lines)), "--json").json["sets"]["all"]["woodcock"]
        assert shape["K"] is None


# Folds


def test_beta_of_two_planes_is_their_intersection(
    vom: Callable[..., Said], file: Callable[..., Path]
) -> None:
    # Planes 45 toward east and toward north meet along (-1, -1, 1) or its opposite: 45/35.26.
    found = vom("fold", file("dip_dir,dip\n90,45\n0,45\n"), "--json").json
    plunge = math.degrees(math.atan(1 / math.sqrt(2)))
    assert (found["beta"]["trend_deg"], found["beta"]["plunge_deg"]) == pytest.approx((45, plunge))
    pi = found["pi_plane"]
    assert (pi["dip_direction_deg"], pi["dip_deg"]) == pytest.approx((225, 90 - plunge))
    assert pi["strike_rhr_deg"] == pytest.approx(135)
    assert found["beta"]["max_confidence95_deg"] is None


def test_fold_uses_only_bedding_and_reports_excluded_rows(
    vom: Callable[..., Said], file: Callable[..., Path]
) -> None:
    beds = "".join(f"bedding,{a},30\n" for a in range(40, 140, 10))
    alone = vom("fold", file("kind,dip_dir,dip\n" + beds), "--json").json
    mixed = vom("fold", file("kind,dip_dir,dip\n" + beds + "joint,3,80\njoint,5,82\n"), "--json")
    found = mixed.json
    assert (found["n"], found["used"], len(found["left_out"])) == (12, 10, 1)
    assert found["beta"] == alone["beta"]
    assert "joint" in json.dumps(found["left_out"])
    assert found["valid"] in ("yes", "conditional", "no")
    assert isinstance(found["verdict"], str)
    assert all({"code", "severity", "message"} <= reason.keys() for reason in found["reasons"])


# What is written


def test_written_table_has_the_documented_columns_and_empty_cells(
    vom: Callable[..., Said], file: Callable[..., Path], tmp_path: Path
) -> None:
    out = tmp_path / "out.csv"
    said = vom("fit", file(lines_of(plane_points(123, 34))), "-o", out, "--json")
    (row,) = said.json["planes"]
    assert list(row) == COLUMNS
    text = out.read_text(encoding="utf-8").splitlines()
    notes = "\n".join(line for line in text if line.startswith("#")).lower()
    assert all(word in notes for word in ("crs", "north", "notation", "vom studio"))
    (cells,) = csv.DictReader(line for line in text if not line.startswith("#"))
    assert list(cells) == COLUMNS
    assert [name for name in COLUMNS if not cells[name]] == [
        name for name in COLUMNS if row[name] in (None, "")
    ]


@pytest.mark.parametrize("command", ["fit", "stereonet"])
@pytest.mark.parametrize("way", ["same", "link", "hard link"])
def test_output_never_replaces_the_input_even_with_force(
    vom: Callable[..., Said], file: Callable[..., Path], tmp_path: Path, command: str, way: str
) -> None:
    text = "x,y,z,strike,dip\n0,0,0,30,40\n1,0,0,33,42\n0,1,1,35,47\n"
    source = target = file(text, "in.svg")
    if way != "same":
        target = tmp_path / "target.svg"
        (os.symlink if way == "link" else os.link)(source, target)
    said = vom(command, source, "-o", target, "--force", "--json")
    assert said.error["code"] == "output.is-input"
    assert source.read_text() == text
    assert target.read_text() == text


@pytest.mark.parametrize(
    "name", first_in_default_tier(["$x^{$", "$", "a$b$c", "_hidden", "<&>", "%s", "\\frac"])
)
@pytest.mark.parametrize("ending", first_in_default_tier(["svg", "pdf"]))
def test_net_accepts_any_set_name(
    vom: Callable[..., Said], file: Callable[..., Path], tmp_path: Path, name: str, ending: str
) -> None:
    table = file(f"strike,dip,set\n1,2,{name}\n30,40,other\n")
    picture = tmp_path / f"net.{ending}"
    said = vom("stereonet", table, "-o", picture, "--json")
    assert said.code == 0
    assert set(said.json["sets"]) == {name, "other"}


# Models


CUBE = "".join(f"v {i & 1} {i >> 1 & 1} {i >> 2}\n" for i in range(8))


@pytest.mark.parametrize(
    ("faces", "triangles"),
    [
        ("f 1 2 4 3\n", 2),
        ("f 1 2 4 8 7\n", 3),
        ("f -8 -7 -6\nf -1 -2 -3\n", 2),
        ("f 1 2 \\\n4\n", 1),
        ("vn 0 0 1\nf 1//1 2//1 4//1\n", 1),
        ("s off\nf 1 2 4 # one\n", 1),
        ("f 1 2 99\nf 1 2 4\n", 1),
    ],
)
def test_every_valid_obj_face_is_counted(
    vom: Callable[..., Said], file: Callable[..., Path], faces: str, triangles: int
) -> None:
    (found,) = vom("info", file(CUBE + faces, "m.obj"), "--json").json["files"]
    assert set(found) >= INFO_KEYS
    assert (found["kind"], found["faces"]) == ("mesh", triangles)
    assert found["bounds"] == [[0, 0, 0], [1, 1, 1]]
    assert ("model.faces-without-vertices" in codes(found)) == ("99" in faces)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("keep", [1.0, 0.9, 0.75])
def test_ply_of_either_byte_order_is_read_up_to_the_damage(
    vom: Callable[..., Said], file: Callable[..., Path], order: str, keep: float
) -> None:
    word = "little" if order == "<" else "big"
    head = (
        f"ply\nformat binary_{word}_endian 1.0\nelement vertex 20\nproperty double x\n"
        "property double y\nproperty double z\nproperty uchar red\nproperty uchar green\n"
        "property uchar blue\nend_header\n"
    ).encode()
    rows = [struct.pack(order + "3d3B", 5e5 + i, 5e6 + i * i, i, i, i, i) for i in range(20)]
    body = b"".join(rows)
    said = vom("info", file(head + body[: int(keep * len(body))], "c.ply"), "--json")
    (found,) = said.json["files"]
    assert said.code == 0
    assert (found["kind"], found["points"]) == ("cloud", int(20 * keep))
    assert found["bounds"][0] == [5e5, 5e6, 0]
    assert ("model.incomplete" in codes(found)) == (keep < 1)


@pytest.mark.parametrize("name", ["m.obj", "m.ply", "m.las", "m.laz", "m.csv", "m.xyz", "m"])
@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\0",
        b"\xff\xfe\xfd" * 50,
        b"LASF" + b"\xff" * 400,
        b"x,y,z\n",
        b"ply\nformat binary_little_endian 1.0\nelement vertex 99999999999999\nproperty double x\n"
        b"property double y\nproperty double z\nend_header\n",
    ],
)
def test_invalid_model_is_rejected_under_any_name(
    vom: Callable[..., Said], file: Callable[..., Path], name: str, content: bytes
) -> None:
    said = vom("info", file(content, name), "--json")
    assert said.error["file"]
    assert len(said.json["files"]) == 1
