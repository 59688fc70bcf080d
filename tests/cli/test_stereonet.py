"""`vomstudio stereonet`."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from tests.messages import by_code, codes, error_of, messages
from tests.tiers import first_in_default_tier

TABLE = "kind,dipdir,dip\n" + "".join(f"bedding,{80 + i},{30 + i}\n" for i in range(8))
PICTURES = [".svg", ".pdf", ".png"]
MAGIC = {"svg": b"<?xml", "pdf": b"%PDF", "png": b"\x89PNG"}


@pytest.mark.parametrize("ending", first_in_default_tier(["svg", "pdf", "png", "PNG"], 3))
@pytest.mark.parametrize("projection", first_in_default_tier(["area", "angle"], 3))
def test_file_extension_selects_image_format(
    run, write, tmp_path: Path, ending: str, projection: str
) -> None:
    target = tmp_path / f"net.{ending}"
    ran = run("stereonet", write(TABLE), "-o", target, "--projection", projection, "--json")
    assert ran.code == 0
    assert ran.json["image"] == str(target)
    assert ran.json["n"] == 8
    assert ran.json["projection"] == projection
    assert target.read_bytes().startswith(MAGIC[ending.lower()])


def test_contour_method_is_used_and_reported(run, write, tmp_path: Path) -> None:
    ran = run("stereonet", write(TABLE), "-o", tmp_path / "n.svg", "--contour", "kamb", "--json")
    assert ran.code == 0
    assert ran.json["contour"] == "kamb"


def test_contour_options_are_applied_and_densities_reported(run, write, tmp_path: Path) -> None:
    table = TABLE + "".join(f"joint,{200 + i},{70 + i}\n" for i in range(12))
    words = ["--contour", "linear_kamb", "--levels", "9,3,3", "--each-set", "--filled"]
    ran = run(
        "stereonet", write(table), "-o", tmp_path / "n.svg", *words, "--kamb-sigma", "2", "--json"
    )
    assert ran.code == 0
    found = ran.json["density"]
    assert (found["method"], found["unit"]) == ("linear_kamb", "standard deviations")
    assert (found["sigma"], found["filled"]) == (2.0, True)
    assert found["levels"] == [3.0, 9.0][: len(found["levels"])]
    bedding, joint = found["parts"]
    assert (bedding["set"], bedding["n"], joint["n"]) == ("bedding", 8, 12)
    # Rows along a line: their middle is densest, the pole of 83.5/33.5.
    assert bedding["trend_deg"] == pytest.approx(263.5, abs=1)
    assert bedding["plunge_deg"] == pytest.approx(56.5, abs=1)
    assert messages(ran.json) == []
    text = run("stereonet", write(table), "-o", tmp_path / "m.svg", *words)
    assert "maximum density: bedding 26" in text.out
    plain = run("stereonet", write(table), "-o", tmp_path / "o.svg", "--json")
    assert plain.json["density"] is None


def test_single_set_is_contoured_and_named_in_legend(run, write, tmp_path: Path) -> None:
    table = TABLE + "".join(f"joint,{200 + i},{70 + i}\n" for i in range(12))
    words = ["stereonet", write(table), "-o", tmp_path / "n.svg", "--contour", "kamb", "--force"]

    def legend() -> str:
        return " ".join(ElementTree.parse(tmp_path / "n.svg").getroot().itertext())

    ran = run(*words, "--contour-set", "joint", "--json")
    (part,) = ran.json["density"]["parts"]
    assert (part["set"], part["n"]) == ("joint", 12)
    assert "of joint, n = 12" in legend()
    (part,) = run(*words, "--json").json["density"]["parts"]
    assert (part["set"], part["n"]) == (None, 20)
    assert "of all sets together, n = 20" in legend()
    ran = run(*words, "--contour-set", "fault", "--json")
    error_of(ran.json, "option.not-a-choice", field="--contour-set")


def test_few_data_and_empty_contours_give_warnings(run, write, tmp_path: Path) -> None:
    words = ["--contour", "kamb", "--levels", "900"]
    ran = run("stereonet", write(TABLE), "-o", tmp_path / "n.svg", *words, "--json")
    assert ran.code == 0
    assert codes(ran.json) == ["net.few-for-contours", "contours.none"]
    assert by_code(ran.json["warnings"])["net.few-for-contours"]["count"] == 8


@pytest.mark.parametrize(
    ("words", "code", "values"),
    [
        (["-o", "net.svg", "--levels", "2,4"], "option.requires", {"field": "--levels"}),
        (
            ["-o", "net.svg", "--contour-set", "bedding"],
            "option.requires",
            {"field": "--contour-set"},
        ),
        (
            ["-o", "net.svg", "--contour", "kamb", "--levels", "2;4"],
            "net.not-levels",
            {"text": "2;4", "field": "--levels"},
        ),
        (
            ["-o", "net.svg", "--contour", "kamb", "--levels", "-1"],
            "net.not-levels",
            {"text": "-1", "field": "--levels"},
        ),
        (
            ["-o", "net.svg", "--contour", "kamb", "--kamb-sigma", "0"],
            "option.out-of-range",
            {"value": 0, "field": "--kamb-sigma"},
        ),
        (["-o", "net.jpg"], "output.unknown-format", {"formats": PICTURES, "suffix": ".jpg"}),
        (["-o", "net"], "output.unknown-format", {"formats": PICTURES}),
        (["-o", "net.svg", "--contour", "magic"], "option.not-a-choice", {"value": "magic"}),
        (
            ["-o", "net.svg", "--projection", "mercator"],
            "option.not-a-choice",
            {"value": "mercator", "field": "--projection"},
        ),
        ([], "command.arguments-missing", {"names": ["--output"], "field": "--output"}),
    ],
)
def test_invalid_options_are_refused_and_nothing_is_drawn(
    run,
    write,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    words: list[str],
    code: str,
    values: dict[str, object],
) -> None:
    monkeypatch.chdir(tmp_path)
    ran = run("stereonet", write(TABLE), *words, "--json")
    assert ran.code == 2
    error_of(ran.json, code, **values)
    assert [p.name for p in tmp_path.iterdir()] == ["in.csv"]


def test_an_existing_picture_is_replaced_only_by_force(run, write, tmp_path: Path) -> None:
    target = tmp_path / "net.svg"
    target.write_text("mine")
    assert "--force" in run("stereonet", write(TABLE), "-o", target).said
    assert target.read_text() == "mine"
    assert run("stereonet", write(TABLE), "-o", target, "--force").code == 0
    assert target.read_bytes().startswith(MAGIC["svg"])


def test_planes_lines_and_sets_are_counted_separately(run, write, tmp_path: Path) -> None:
    text = "set,element,dipdir,dip,trend,plunge\na,plane,10,20,,\na,line,,,30,40\nb,plane,5,6,,\n"
    ran = run("stereonet", write(text), "-o", tmp_path / "n.svg", "--json")
    assert ran.json["sets"] == {"a (planes)": 1, "a (lines)": 1, "b": 1}


def test_invalid_table_leaves_no_image(run, write, tmp_path: Path) -> None:
    ran = run("stereonet", write("dipdir,dip\n10,95\n"), "-o", tmp_path / "n.svg")
    assert ran.code == 2
    assert "line 2" in ran.said
    assert not (tmp_path / "n.svg").exists()


def test_untilting_brings_the_beds_to_the_horizontal(run, write, tmp_path) -> None:
    path = write("dipdir,dip\n132,41\n133,40\n131,42\n")
    words = ("stereonet", path, "-o", tmp_path / "net.svg", "--contour", "schmidt", "--json")
    found = run(*words, "--untilt", "132/41").json
    assert found["untilted_by"] == "132/41"
    assert found["density"]["parts"][0]["plunge_deg"] > 85
    assert "Untilted by 132/41" in (tmp_path / "net.svg").read_text()
    turned = run(*words, "--rotate", "0/90/30", "--force").json
    assert abs(turned["density"]["parts"][0]["trend_deg"] - 342) < 5


def test_circles_and_intersections_are_drawn_and_reported(run, write, tmp_path) -> None:
    path = write("dipdir,dip\n90,30\n200,60\n330,45\n")
    ran = run(
        "stereonet",
        path,
        "-o",
        tmp_path / "net.svg",
        "--plane",
        "100/50",
        "--cone",
        "125/26/60",
        "--cone",
        "0/0/20",
        "--intersections",
        "--json",
    )
    assert ran.json["circles"] == ["Plane 100/50", "Cone 125/26/60", "Cone 0/0/20"]
    assert ran.json["sets"]["Intersections"] == 3
    drawn = (tmp_path / "net.svg").read_text()
    assert "Cone 125/26/60" in drawn


@pytest.mark.parametrize(
    ("words", "code", "values"),
    [
        (("--untilt", "132"), "notation.one-angle", {"text": "132"}),
        (("--rotate", "1/2"), "net.not-three-numbers", {"text": "1/2"}),
        (("--rotate", "a/b/c"), "net.not-three-numbers", {"text": "a/b/c"}),
        (("--cone", "10/95/30"), "angle.out-of-range", {"angle": "plunge", "value": 95}),
        (("--cone", "10/20/0"), "angle.out-of-range", {"angle": "half-angle", "value": 0}),
        (("--cone", "10/20/nan"), "net.not-three-numbers", {"text": "10/20/nan"}),
    ],
)
def test_invalid_options_are_refused(run, write, tmp_path, words, code, values) -> None:
    table, net = write("dipdir,dip\n90,30\n"), tmp_path / "net.svg"
    ran = run("stereonet", table, "-o", net, *words, "--json")
    assert ran.code == 2
    error_of(ran.json, code, field=words[0], **values)


def test_intersections_need_between_two_and_maximum_number_of_planes(run, write, tmp_path) -> None:
    net = tmp_path / "net.svg"
    few = run("stereonet", write("dipdir,dip\n90,30\n"), "-o", net, "--intersections")
    assert few.code == 2
    rows = "\n".join(f"{i % 360},30" for i in range(400))
    many = run("stereonet", write("dipdir,dip\n" + rows), "-o", net, "--intersections")
    assert many.code == 2
    assert "400" in many.said


def test_sets_get_requested_colours(run, write, tmp_path) -> None:
    table = write("dipdir,dip,kind\n" + "100,40,Bed A\n102,41,Bed A\n98,42,Bed A\n200,70,joint\n")
    for command in ("stereonet", "rose"):
        out = tmp_path / f"{command}.svg"
        words = [command, table, "-o", out, "--by", "kind"]
        ran = run(*words, "--color", "Bed A=#abcdef", "--font-size", 7)
        assert ran.code == 0, ran.err
        assert "#abcdef" in out.read_text("utf-8") or command == "rose"
        for wrong in ("Bed A=blue", "Bed B=#abcdef", "#abcdef"):
            assert run(*words, "--force", "--color", wrong).code == 2
    assert run("rose", table, "-o", tmp_path / "r.svg", "--width", 5).code == 2
