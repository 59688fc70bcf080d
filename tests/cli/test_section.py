"""`vomstudio section`."""

from __future__ import annotations

import re
from pathlib import Path

import ezdxf
import numpy as np
import pandas as pd
import pytest

from tests.messages import by_code
from vomstudio.core.findings import Finding

WEDGE = "v 0 0 0\nv 20 0 0\nv 20 10 0\nv 0 10 0\nv 0 0 5\nv 0 10 5\nf 5 2 3\nf 5 3 6\n"


@pytest.fixture
def model(tmp_path: Path) -> Path:
    """A slope from 5 m down to 0 m over 20 m toward East, 10 m along North."""
    path = tmp_path / "slope.obj"
    path.write_text(WEDGE)
    return path


def test_intersection_is_written_as_table(run, model: Path, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    out = tmp_path / "s.csv"
    ran = run("section", model, "--plane", "180/90", "--through", "0,4,0", "-o", out, "--json")
    assert ran.code == 0, ran.err
    found = ran.json
    assert list(found)[:3] == ["file", "length_m", "polylines"]
    assert found["length_m"] == pytest.approx(np.hypot(20, 5))
    assert found["polylines"] == 1
    assert (found["left_deg"], found["right_deg"]) == (270, 90)
    table = pd.read_csv(out, comment="#")
    assert list(table) == ["polyline", "distance_m", "height_m", "x", "y", "z"]
    assert (table["y"] == 4).all()
    assert table["z"].to_numpy() == pytest.approx(5 - table["x"] / 4)
    assert table["distance_m"].to_numpy() == pytest.approx(table["x"])
    assert run("section", model, "--plane", "180/90", "--through", "0,4,0", "-o", out).code == 2


def test_section_is_written_as_dxf_and_svg(run, model: Path, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    line = tmp_path / "line.csv"
    line.write_text("x,y\n2,1\n10,7\n18,1\n")
    planes = tmp_path / "planes.csv"
    planes.write_text("id,dip_direction,dip,x,y,z\nB1,90,45,4,2,6\n")
    out = [tmp_path / "s.dxf", tmp_path / "s.svg"]
    for path in out:
        ran = run(
            "section", model, "--section-line", line, "-o", path, "--features", planes, "--json"
        )
        assert ran.code == 0, ran.err
        assert ran.json["features"] == 1
    lines = [e for e in ezdxf.readfile(out[0]).modelspace() if e.dxftype() == "POLYLINE"]
    points = np.array([v.dxf.location for v in lines[0].vertices])
    assert {e.dxf.layer for e in lines} == {"section"}
    assert points[:, 0].max() == pytest.approx(20)
    assert points[0, 1] == pytest.approx(4.5)
    text = out[1].read_text("utf-8")
    assert "1 : 100" in text
    scale = float(re.search(r'id="plane" transform="matrix\((\S+) 0 0', text)[1])
    assert scale == pytest.approx(10)
    # Millimetres of paper for each metre: the frame is as long as the section and its margins.
    assert re.search(r'width="220\.000" height=', text)
    assert ">SW (233)<" in text
    assert ">SE (127)<" in text


def test_features_are_projected_onto_section_table(run, model: Path, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    planes = tmp_path / "planes.csv"
    planes.write_text(
        "id,dip_direction,dip,x,y,z\nB1,60,45,4,2,6\nB2,300,20,4,40,6\n=1,0,30,3,5,1\n"
    )
    out = tmp_path / "s.csv"
    ran = run(
        "section",
        model,
        "--plane",
        "180/90",
        "--through",
        "0,4,0",
        "-o",
        out,
        "--within",
        10,
        "--features",
        planes,
        "--json",
    )
    found = ran.json
    assert (found["features"], found["left_out"]) == (2, 1)
    table = pd.read_csv(found["features_file"], comment="#")
    assert list(table["id"]) == ["B1", "'=1"]
    expected = np.degrees(np.arctan(np.sin(np.radians(60))))
    assert table["apparent_dip_deg"][0] == pytest.approx(expected, abs=1e-4)
    assert table["away_m"][0] == pytest.approx(2)


@pytest.mark.parametrize(
    ("words", "code", "field"),
    [
        (["--plane", "180/90"], "option.requires", "--plane"),
        (["--through", "0,0,0"], "option.none-given", "--plane"),
        ([], "option.none-given", "--plane"),
        (["--plane", "180/90", "--section-line", "l.csv"], "option.conflict", "--section-line"),
        (["--plane", "180/90", "--through", "0,0"], "section.not-a-point", "--through"),
        (["--plane", "180/90", "--through", "0,400,0"], "section.misses-model", None),
        (
            ["--plane", "180/90", "--through", "0,4,0", "--slab", "1"],
            "option.clouds-only",
            "--slab",
        ),
        (
            ["--plane", "180/90", "--through", "0,4,0", "--slab", "0"],
            "option.not-a-length",
            "--slab",
        ),
        (
            ["--plane", "180/90", "--through", "0,4,0", "--along", "0/0"],
            "option.requires",
            "--along",
        ),
        (["--plane", "x", "--through", "0,4,0"], "notation.unknown-word", "--plane"),
    ],
)
def test_impossible_requests_are_refused_with_code_and_field(
    run, model, tmp_path, words, code, field
) -> None:  # type: ignore[no-untyped-def]
    ran = run("section", model, "-o", tmp_path / "s.csv", *words, "--json")
    assert ran.code == 2
    assert (ran.json["error"]["code"], ran.json["error"]["field"]) == (code, field)
    assert not (tmp_path / "s.csv").exists()
    assert run("section", model, "--plane", "1/90", "--through", "0,4,0", "-o", "s.txt").code == 2


def hooked(path: Path) -> set[tuple[float, float]]:
    """Places of the planes of a drawing whose symbol has a half circle beside its bar and tick."""
    drawn = list(ezdxf.readfile(path).modelspace())
    places = np.array([e.dxf.location for e in drawn if e.dxftype() == "POINT"])
    pieces = np.array(
        [
            np.mean([e.dxf.start, e.dxf.end], axis=0)
            for e in drawn
            if e.dxftype() == "LINE" and e.dxf.layer == "planes_symbols"
        ]
    )
    nearest = np.linalg.norm(pieces[:, None] - places[None], axis=2).argmin(axis=1)
    return {tuple(places[k][:2]) for k in range(len(places)) if (nearest == k).sum() > 4}


@pytest.mark.parametrize(
    ("column", "yes", "no"),
    [
        ("overturned", "true", "false"),
        ("Overturned", "1", "0"),
        ("inverted", "Yes", ""),
        ("overturned_bed", "x", "no"),
        ("overturned", "ja", "nein"),
    ],
)
def test_overturned_column_is_recognised(run, model, tmp_path, column, yes, no) -> None:  # type: ignore[no-untyped-def]
    planes = tmp_path / "planes.csv"
    planes.write_text(
        f"id;name;dip_direction;dip;x;y;z;{column}\n"
        f"1;Upright;90;45;4;2;4;{no}\n2;Turned;90;60;14;8;1.5;{yes}\n",
        "utf-8",
    )
    level = ("--plane", "0/0", "--through", "0,0,2", "--features", planes, "--json")
    assert run("section", model, *level, "-o", tmp_path / "map.dxf").code == 0
    assert hooked(tmp_path / "map.dxf") == {(14.0, 8.0)}
    ran = run("section", model, *level, "-o", tmp_path / "map.csv")
    table = pd.read_csv(ran.json["features_file"], comment="#")
    assert list(table["name"]) == ["Upright", "Turned"]
    assert list(table["overturned"]) == [False, True]
    assert "('dip_direction', 'dip')" in ran.json["convention"]


def test_table_rows_missing_from_section_are_reported(run, model, tmp_path) -> None:  # type: ignore[no-untyped-def]
    planes = tmp_path / "planes.csv"
    planes.write_text(
        "dip_direction,dip,trend,plunge,x,y,z,overturned\n"
        "90,45,,,4,2,4,maybe\n90,60,,,,,,\n,,120,30,5,5,3,\n,,,,5,5,3,\n"
    )
    ran = run(
        "section",
        model,
        "--plane",
        "180/90",
        "--through",
        "0,4,0",
        "-o",
        tmp_path / "s.csv",
        "--features",
        planes,
        "--json",
    )
    assert ran.code == 0, ran.err
    findings = by_code(ran.json["warnings"])
    assert {"table.rows-left-out", "orientation.unclear-overturned"} <= findings.keys()
    assert findings["section.lines-left-out"]["count"] == 1
    assert findings["section.planes-without-place"]["lines"] == (3,)


def test_azimuth_option_applies_to_feature_table(run, model, tmp_path) -> None:  # type: ignore[no-untyped-def]
    planes = tmp_path / "planes.csv"
    planes.write_text("azimuth,dip,x,y,z\n0,45,4,4,4\n")
    cut = ("section", model, "--plane", "180/90", "--through", "0,4,0", "--features", planes)
    refused = run(*cut, "-o", tmp_path / "s.csv")
    assert refused.code == 2
    assert "--azimuth" in refused.err
    ran = run(*cut, "-o", tmp_path / "s.csv", "--azimuth", "strike", "--json")
    table = pd.read_csv(ran.json["features_file"], comment="#")
    # Strike 000, dip 45 dips to the east: down to the right where the viewer looks north.
    assert table["apparent_dip_deg"][0] == pytest.approx(45)


def test_dip_over_90_is_refused_with_correct_notation(run, model, tmp_path) -> None:  # type: ignore[no-untyped-def]
    planes = tmp_path / "planes.csv"
    planes.write_text("dip_direction,dip,x,y,z\n90,110,4,4,4\n")
    ran = run(
        "section",
        model,
        "--plane",
        "180/90",
        "--through",
        "0,4,0",
        "--features",
        planes,
        "-o",
        tmp_path / "s.csv",
    )
    assert ran.code == 2
    assert "line 2, dip" in ran.err
    finding = Finding("orientation.overturned-dip", value=110, dip=70)
    assert str(finding) in ran.err
