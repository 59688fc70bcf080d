"""`vomstudio measurable`, and the same in Python."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import rasterio

import vomstudio as vs
from vomstudio.io.models.opening import read_model

PROMISED = {
    "file",
    "plane",
    "length_m",
    "resolution_m",
    "noise_m",
    "registration_error_deg",
    "angle_deg",
    "element",
    "elements",
    "area_m2",
    "shares",
    "trace_shares",
    "exposed_share",
    "patches",
    "median_deg",
    "tenth_deg",
    "best",
    "warnings",
}


@pytest.fixture
def corner(tmp_path: Path) -> Path:
    """Two walls that meet at right angles, as an OBJ of four triangles; 3 m wide, 3 m high, at
    places as large as those of a map."""
    path = tmp_path / "corner.obj"
    x, y = 364500.0, 4721800.0
    rows = [(0, 0, 0), (3, 0, 0), (3, 0, 3), (0, 0, 3), (0, 3, 0), (0, 3, 3)]
    lines = [f"v {x + a:.3f} {y + b:.3f} {c:.3f}" for a, b, c in rows]
    path.write_text("\n".join([*lines, "f 1 2 3", "f 1 3 4", "f 1 6 5", "f 1 4 6"]) + "\n")
    return path


def test_map_is_reported_and_written_as_model_fields(run, corner: Path, tmp_path: Path) -> None:
    out = tmp_path / "map.ply"
    ran = run(
        "measurable",
        corner,
        "--plane",
        "0/0",
        "--length",
        "1",
        "--resolution",
        "0.01",
        "-o",
        out,
        "--json",
    )
    assert ran.code == 0
    assert ran.json.keys() >= PROMISED
    assert sum(ran.json["shares"].values()) == pytest.approx(1.0)
    # Half a metre either side of the corner, of six: beyond it the line is straight.
    assert ran.json["shares"]["none"] == pytest.approx(5 / 6, abs=0.03)
    assert ran.json["shares"]["good"] == pytest.approx(1 / 6, abs=0.03)
    assert ran.json["best"]["x"] == pytest.approx(364500, abs=0.5)
    assert ran.json["best"]["y"] == pytest.approx(4721800, abs=0.5)
    assert ran.json["area_m2"] == pytest.approx(18.0, rel=1e-6)
    fields = read_model(out).data.fields
    assert {"expected_error95_deg", "measurable"} <= set(fields)


def test_map_is_written_as_raster(run, corner: Path, tmp_path: Path) -> None:
    out = tmp_path / "map.tif"
    ran = run(
        "measurable",
        corner,
        "--plane",
        "0/0",
        "--length",
        "1",
        "--resolution",
        "0.01",
        "-o",
        out,
        "--gsd",
        "0.05",
        "--json",
    )
    assert ran.code == 0
    assert ran.json["raster"]["gsd_m"] == 0.05
    with rasterio.open(out) as raster:
        values = raster.read(1)
    assert values.shape == (ran.json["raster"]["height"], ran.json["raster"]["width"])
    seen = np.isfinite(values)
    assert seen.mean() > 0.9
    assert (values[seen] < 5.0).mean() == pytest.approx(1 / 6, abs=0.05)


def test_mean_plane_of_set_is_used(run, corner: Path, tmp_path: Path) -> None:
    table = tmp_path / "planes.csv"
    table.write_text(
        "dip_direction,dip,set\n10,60,A\n20,60,A\n15,55,A\n15,65,A\n200,30,B\n202,31,B\n"
    )
    asked = ("measurable", corner, "--mean", table, "--length", "1", "--resolution", "0.02")
    ran = run(*asked, "--set", "A", "--json")
    assert ran.json["plane"]["dip_direction_deg"] == pytest.approx(15.0, abs=0.2)
    assert ran.json["plane"]["dip_deg"] == pytest.approx(60.0, abs=0.5)
    ran = run(*asked, "--set", "C", "--json")
    assert ran.code == 2
    assert "A, B" in ran.json["error"]["message"]


@pytest.mark.parametrize(
    ("words", "code", "field"),
    [
        ((), "option.none-given", "--plane"),
        (("--plane", "0/0", "--mean", "t.csv"), "option.conflict", "--mean"),
        (("--plane", "400/95"), "notation.azimuth-out-of-range", "--plane"),
        (("--plane", "0/0", "--set", "A"), "option.requires", "--set"),
        (("--plane", "0/0", "--length", "0"), "option.not-a-length", "--length"),
        (("--plane", "0/0", "--length", "nan"), "option.not-a-length", "--length"),
        (("--plane", "0/0", "--noise", "-1"), "option.not-a-length", "--noise"),
        (("--plane", "0/0", "--points", "3"), "option.out-of-range", "--points"),
        (("--plane", "0/0", "--angle", "90"), "option.out-of-range", "--angle"),
        (("--plane", "0/0", "--gsd", "0.1"), "option.requires", "--gsd"),
        (("--plane", "0/0", "--gsd", "-1"), "option.not-a-length", "--gsd"),
    ],
)
def test_invalid_options_are_refused(
    run, corner: Path, words: tuple[str, ...], code: str, field: str
) -> None:
    ran = run("measurable", corner, *words, "--json")
    assert ran.code == 2
    assert (ran.json["error"]["code"], ran.json["error"]["field"]) == (code, field)


def test_python_function_matches_command_output(run, corner: Path) -> None:
    ran = run(
        "measurable", corner, "--plane", "0/0", "--length", "1", "--resolution", "0.01", "--json"
    )
    with pytest.warns(vs.errors.VomWarning) as warned:
        model = vs.read(corner)
    assert [each.message.code for each in warned] == ["frame.assumed"]
    found = vs.measurable(model, "0/0", length_m=1.0, resolution_m=0.01)
    assert found.shares == pytest.approx(ran.json["shares"])
    values = found.as_fields()["expected_error95_deg"]
    assert len(values) == len(model.points)
    with pytest.raises(vs.errors.VomError):
        vs.measurable(model, (0, 100))
