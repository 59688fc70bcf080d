"""`vomstudio stereonet`."""

from __future__ import annotations

from pathlib import Path

import pytest

TABLE = "kind,dipdir,dip\n" + "".join(f"bedding,{80 + i},{30 + i}\n" for i in range(8))
MAGIC = {"svg": b"<?xml", "pdf": b"%PDF", "png": b"\x89PNG"}


@pytest.mark.parametrize("ending", ["svg", "pdf", "png", "PNG"])
@pytest.mark.parametrize("projection", ["area", "angle"])
def test_the_ending_says_what_is_drawn(
    run, write, tmp_path: Path, ending: str, projection: str
) -> None:
    target = tmp_path / f"net.{ending}"
    ran = run("stereonet", write(TABLE), "-o", target, "--projection", projection, "--json")
    assert ran.code == 0
    assert ran.json["image"] == str(target)
    assert ran.json["n"] == 8
    assert ran.json["projection"] == projection
    assert target.read_bytes().startswith(MAGIC[ending.lower()])


def test_contours_are_drawn_by_the_method_named(run, write, tmp_path: Path) -> None:
    ran = run("stereonet", write(TABLE), "-o", tmp_path / "n.svg", "--contour", "kamb", "--json")
    assert ran.code == 0
    assert ran.json["contour"] == "kamb"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["-o", "net.jpg"], ".svg, .pdf or .png"),
        (["-o", "net"], ".svg, .pdf or .png"),
        (["-o", "net.svg", "--contour", "magic"], "kamb"),
        (["-o", "net.svg", "--projection", "mercator"], "--projection"),
        ([], "--output"),
    ],
)
def test_wrong_wishes_are_refused_and_nothing_is_drawn(
    run, write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: list[str], said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    ran = run("stereonet", write(TABLE), *words)
    assert ran.code == 2
    assert said in ran.said
    assert [p.name for p in tmp_path.iterdir()] == ["in.csv"]


def test_an_existing_picture_is_replaced_only_by_force(run, write, tmp_path: Path) -> None:
    target = tmp_path / "net.svg"
    target.write_text("mine")
    assert "--force" in run("stereonet", write(TABLE), "-o", target).said
    assert target.read_text() == "mine"
    assert run("stereonet", write(TABLE), "-o", target, "--force").code == 0
    assert target.read_bytes().startswith(MAGIC["svg"])


def test_planes_and_lines_and_sets_are_told_apart(run, write, tmp_path: Path) -> None:
    text = "set,geometry,dipdir,dip,trend,plunge\na,plane,10,20,,\na,line,,,30,40\nb,plane,5,6,,\n"
    ran = run("stereonet", write(text), "-o", tmp_path / "n.svg", "--json")
    assert ran.json["sets"] == {"a (planes)": 1, "a (lines)": 1, "b": 1}


def test_a_bad_table_leaves_no_picture(run, write, tmp_path: Path) -> None:
    ran = run("stereonet", write("dipdir,dip\n10,95\n"), "-o", tmp_path / "n.svg")
    assert ran.code == 2
    assert "line 2" in ran.said
    assert not (tmp_path / "n.svg").exists()
