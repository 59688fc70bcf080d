"""`vomstudio slope --facets`: every facet of a model as a slope, in a table and painted on it."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from tests.cli.test_slope import TABLE
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.opening import read_model
from vomstudio.io.models.writing import write_model

FACETS = "id,dip direction,dip,area_m2\n0,100,70,2.5\n1,90,80,\n2,0,0,1\n"


def labelled(path: Path) -> Path:
    """Two triangles, facet 0 upright and facet 1 overhanging (its outside to the west, down)."""
    a, b = np.radians(70.0), np.radians(80.0)
    right = np.array([0.0, 1.0, 0.0])
    one = np.array([[0, 0, 0], [0, 1, 0], [-np.cos(a), 0, np.sin(a)]])
    down = np.array([np.cos(b), 0, -np.sin(b)])
    other = np.array([[5.0, 0, 0], [5.0, 0, 0] + right, [5.0, 0, 0] - down])[[0, 2, 1]]
    mesh = Mesh(
        np.vstack([one, other, [[9, 9, 9]]]),
        np.array([[0, 1, 2], [3, 4, 5]], np.int32),
        fields={"facet": np.array([0, 0, 0, 1, 1, 1, -1], np.int32)},
    )
    write_model(mesh, None, path)
    return path


def test_each_facet_is_analysed_as_slope_of_its_attitude(run, write, tmp_path: Path) -> None:
    planes, facets = write(TABLE, "planes.csv"), write(FACETS, "facets.csv")
    out = tmp_path / "slopes.csv"
    words = ["slope", planes, "--facets", facets, "--friction", 30]
    ran = run(*words, "-o", out, "--json")
    assert ran.code == 0, ran.err
    single = run("slope", planes, "--face", "100/70", "--friction", 30, "--json").json
    first = ran.json["facets"][0]
    assert (first["id"], first["area_m2"]) == ("0", 2.5)
    for mode in ("planar", "wedge", "flexural_toppling", "direct_toppling"):
        for key in ("critical", "of", "share"):
            assert first[mode][key] == single[mode][key]
    assert [each["id"] for each in ran.json["skipped"]] == ["2"]
    rows = [r for r in csv.DictReader(out.read_text("utf-8").splitlines()[2:])]
    assert [r["id"] for r in rows] == ["0", "1"]
    assert float(rows[0]["planar_share"]) == pytest.approx(single["planar"]["share"], abs=1e-6)
    assert rows[1]["area_m2"] == ""
    assert run(*words, "-o", out).code == 2
    assert "planar" in run(*words).out


def test_facets_are_painted_and_overhangs_detected(run, write, tmp_path: Path) -> None:
    planes, facets = write(TABLE, "planes.csv"), write(FACETS, "facets.csv")
    model, painted = labelled(tmp_path / "labels.ply"), tmp_path / "painted.ply"
    words = ["slope", planes, "--facets", facets, "--friction", 30, "--labelled-model", model]
    ran = run(*words, "--paint", painted, "--json")
    assert ran.code == 0, ran.err
    upright, over = ran.json["facets"]
    assert (upright["overhangs"], over["overhangs"]) == (False, True)
    assert over["face"]["dip_deg"] == 90.0
    assert over["face"]["dip_direction_deg"] == 270.0
    data = read_model(painted).data
    values = data.fields["planar_percent"]
    assert values[:3] == pytest.approx(100.0 * upright["planar"]["share"])
    assert values[3:6] == pytest.approx(100.0 * over["planar"]["share"])
    assert np.isnan(values[6])


def test_conflicting_options_are_refused(run, write, tmp_path: Path) -> None:
    planes, facets = write(TABLE, "planes.csv"), write(FACETS, "facets.csv")
    for words in (
        [],
        ["--face", "100/70", "--facets", facets],
        ["--face", "100/70", "--labelled-model", "m.ply"],
        ["--facets", facets, "--plot", "a.svg"],
        ["--facets", facets, "--paint", "a.ply"],
        ["--facets", facets, "--lateral", "-3"],
        ["--facets", tmp_path / "none.csv"],
        ["--facets", write("dipdir,dip\n0,0\n", "flat.csv")],
        ["--face", "100/70", "-o", "a.csv"],
    ):
        ran = run("slope", planes, "--friction", 30, *words)
        assert ran.code == 2, words
        assert "Traceback" not in ran.err
