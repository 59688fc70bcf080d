"""A model in a CRS that is not metric is refused or converted by every command that takes one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from pyproj import CRS, Transformer

import vomstudio as vs
from tests.messages import codes

ZONE = "EPSG:32633"
EAST_M, NORTH_M = 500_000.0, 5_094_000.0  # 46 degrees north


@pytest.fixture
def bed(tmp_path: Path) -> Path:
    """A bed of 090/30 in Web Mercator, with its .prj beside it."""
    steps = np.arange(0.0, 20.0, 0.5)
    x, y = (each.ravel() for each in np.meshgrid(steps, steps))
    z = 300.0 - np.tan(np.radians(30.0)) * x
    to_mercator = Transformer.from_crs(ZONE, "EPSG:3857", always_xy=True)
    east, north = to_mercator.transform(EAST_M + x, NORTH_M + y)
    path = tmp_path / "bed.xyz"
    np.savetxt(path, np.column_stack([east, north, z]), fmt="%.6f")
    path.with_suffix(".prj").write_text(CRS.from_epsg(3857).to_wkt("WKT1_ESRI"))
    return path


COMMANDS = (
    "facets {model} -o {out}.csv",
    "convert {model} {out}.ply",
    "dem {model} -o {out}.tif",
    "ortho {model} --trend 0 --plunge 90 -o {out}.tif",
    "section {model} --plane 0/90 --through 500010,5094010,295 -o {out}.csv",
    "extend {model} --plane 0/60 --through 500010,5094010,294 --error 1 -o {out}.csv",
    "measurable {model} --plane 90/30",
    "compare {model} {model}",
    "surface {model} -o {out}.csv",
)


@pytest.mark.parametrize("words", COMMANDS, ids=lambda words: words.split()[0])
def test_web_mercator_is_refused_and_converted(run, bed: Path, tmp_path: Path, words: str) -> None:
    command = words.format(model=bed, out=tmp_path / "out").split()
    refused = run(*command, "--json")
    assert refused.code == 2
    error = refused.json["error"]
    assert error["code"] == "frame.not-metric"
    assert error["scale"] == pytest.approx(1.0 / np.cos(np.radians(46.0)), rel=3e-3)
    assert error["suggested_crs"] in ("EPSG:32633", "EPSG:32632")
    converted = run(*command, "--to-crs", ZONE, "--json")
    assert converted.code == 0, converted.err
    assert "frame.reprojected" in codes(converted.json)


def test_a_converted_bed_has_its_true_dip(run, bed: Path, tmp_path: Path) -> None:
    table = tmp_path / "facets.csv"
    run("facets", bed, "-o", table, "--to-crs", ZONE)
    (facet,) = pd.read_csv(table, comment="#").to_dict("records")
    assert facet["dip_deg"] == pytest.approx(30.0, abs=0.05)
    assert facet["dip_direction_deg"] == pytest.approx(90.0, abs=0.1)


def test_a_project_takes_a_converted_copy(run, bed: Path, tmp_path: Path) -> None:
    folder = tmp_path / "study.vom"
    with vs.Project.create(folder):
        pass
    refused = run("project", folder, "add-model", bed, "--json")
    assert refused.json["error"]["code"] == "frame.not-metric"
    added = run("project", folder, "add-model", bed, "--to-crs", ZONE, "--json")
    assert added.code == 0, added.err
    assert "frame.reprojected" in codes(added.json)
    with vs.Project.open(folder) as project:
        (model,) = project.models
        assert model.read().bounds[0, :2] == pytest.approx([EAST_M, NORTH_M], abs=0.1)


def test_python_converts_too(bed: Path) -> None:
    with pytest.raises(vs.errors.InputError) as refused:
        vs.read(bed)
    assert refused.value.code == "frame.not-metric"
    with pytest.warns(vs.errors.VomWarning) as warned:
        cloud = vs.read(bed, to_crs=ZONE)
    assert [each.message.code for each in warned] == ["frame.reprojected"]
    assert [each.code for each in cloud.warnings] == ["frame.reprojected"]
    assert cloud.bounds[0, :2] == pytest.approx([EAST_M, NORTH_M], abs=0.01)
    assert cloud.crs == ZONE


def test_info_describes_what_others_refuse(run, bed: Path) -> None:
    (described,) = run("info", bed, "--json").json["files"]
    assert codes(described) == ["frame.not-metric"]


def test_degrees_are_converted(run, tmp_path: Path) -> None:
    path = tmp_path / "degrees.xyz"
    steps = np.arange(0.0, 20.0, 0.5)
    x, y = (each.ravel() for each in np.meshgrid(steps, steps))
    to_degrees = Transformer.from_crs(ZONE, "EPSG:4326", always_xy=True)
    longitude, latitude = to_degrees.transform(EAST_M + x, NORTH_M + y)
    z = 300.0 - np.tan(np.radians(30.0)) * x
    np.savetxt(path, np.column_stack([longitude, latitude, z]), fmt="%.10f")
    assert "frame.maybe-degrees" in codes(run("info", path, "--json").json["files"][0])
    words = ("--crs", "EPSG:4326", "--to-crs", ZONE, "--json")
    answer = run("dem", path, "-o", tmp_path / "d.tif", *words)
    assert answer.code == 0, answer.err
    assert answer.json["crs"] == ZONE


def test_a_model_with_y_up_is_placed_by_its_option(run, tmp_path: Path) -> None:
    """A bed of 090/20, written with y up as phone scanners do."""
    steps = np.arange(0.0, 6.0, 0.25)
    x, y = (each.ravel() for each in np.meshgrid(steps, steps))
    z = 10.0 - np.tan(np.radians(20.0)) * x
    path = tmp_path / "floor.xyz"
    np.savetxt(path, np.column_stack([x, z, -y]), fmt="%.6f")
    assumed = run("facets", path, "-o", tmp_path / "a.csv", "--json")
    assert "frame.assumed" in codes(assumed.json)
    run("facets", path, "-o", tmp_path / "b.csv", "--up", "y")
    (facet,) = pd.read_csv(tmp_path / "b.csv", comment="#").to_dict("records")
    assert (facet["dip_direction_deg"], facet["dip_deg"]) == pytest.approx((90.0, 20.0), abs=0.1)
