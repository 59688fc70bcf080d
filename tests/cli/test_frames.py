"""A model in a CRS that is not metric is refused or converted by every command that takes one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import vomstudio as vs
from tests.frames import ORIGIN, ZONE, bed_grid, convert, write_cloud, write_prj
from tests.messages import codes
from tests.tiers import first_in_default_tier


@pytest.fixture
def bed(tmp_path: Path) -> Path:
    """A bed of 090/30 in Web Mercator, with its .prj beside it."""
    path = write_cloud(tmp_path / "bed.xyz", convert(bed_grid(), "EPSG:3857"), None)
    write_prj(path, "EPSG:3857", "WKT1_ESRI")
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


@pytest.mark.parametrize(
    "words", first_in_default_tier(COMMANDS, 2), ids=lambda words: words.split()[0]
)
def test_web_mercator_is_refused_and_converted_on_request(
    run, bed: Path, tmp_path: Path, words: str
) -> None:
    command = words.format(model=bed, out=tmp_path / "out").split()
    refused = run(*command, "--json")
    assert refused.code == 2
    error = refused.json["error"]
    assert error["code"] == "frame.not-metric"
    assert error["scale"] == pytest.approx(1.0 / np.cos(np.radians(46.0)), rel=3e-3)
    assert error["suggested_crs"] == ZONE
    assert f"--to-crs {ZONE}" in error["message"]
    converted = run(*command, "--to-crs", ZONE, "--json")
    assert converted.code == 0, converted.err
    assert "frame.reprojected" in codes(converted.json)


def test_a_converted_bed_has_its_true_dip(run, bed: Path, tmp_path: Path) -> None:
    table = tmp_path / "facets.csv"
    run("facets", bed, "-o", table, "--to-crs", ZONE)
    (facet,) = pd.read_csv(table, comment="#").to_dict("records")
    assert facet["dip_deg"] == pytest.approx(30.0, abs=0.05)
    assert facet["dip_direction_deg"] == pytest.approx(90.0, abs=0.1)


def test_project_stores_converted_copy_of_model(run, bed: Path, tmp_path: Path) -> None:
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
        assert model.read().bounds[0, :2] == pytest.approx(ORIGIN[:2], abs=0.01)


def test_python_functions_convert_on_request(bed: Path) -> None:
    with pytest.raises(vs.errors.InputError) as refused:
        vs.read(bed)
    assert refused.value.code == "frame.not-metric"
    with pytest.warns(vs.errors.VomWarning) as warned:
        cloud = vs.read(bed, to_crs=ZONE)
    assert [each.message.code for each in warned] == ["frame.reprojected"]
    assert [each.code for each in cloud.warnings] == ["frame.reprojected"]
    assert cloud.bounds[0, :2] == pytest.approx(ORIGIN[:2], abs=0.01)
    assert cloud.crs == ZONE


def test_info_describes_models_that_other_commands_refuse(run, bed: Path) -> None:
    (described,) = run("info", bed, "--json").json["files"]
    assert codes(described) == ["frame.not-metric"]


def test_degrees_are_converted(run, tmp_path: Path) -> None:
    path = write_cloud(tmp_path / "degrees.xyz", convert(bed_grid(), "EPSG:4326"), None)
    assert "frame.maybe-degrees" in codes(run("info", path, "--json").json["files"][0])
    words = ("--crs", "EPSG:4326", "--to-crs", ZONE, "--json")
    answer = run("dem", path, "-o", tmp_path / "d.tif", *words)
    assert answer.code == 0, answer.err
    assert answer.json["crs"] == ZONE
    (described,) = run("info", tmp_path / "d.tif", "--json").json["files"]
    low, high = np.array(described["bounds"])
    bed = bed_grid()
    assert low == pytest.approx(bed.min(axis=0), abs=1.0)
    assert high == pytest.approx(bed.max(axis=0), abs=1.0)


def test_up_option_applies_to_y_up_model(run, tmp_path: Path) -> None:
    """A bed of 090/20, written with y up as phone scanners do."""
    bed = bed_grid(20.0, side_m=6.0, step_m=0.25, origin=np.array([0.0, 0.0, 10.0]))
    path = write_cloud(tmp_path / "floor.xyz", bed[:, [0, 2, 1]] * [1.0, 1.0, -1.0], None)
    assumed = run("facets", path, "-o", tmp_path / "a.csv", "--json")
    assert "frame.assumed" in codes(assumed.json)
    run("facets", path, "-o", tmp_path / "b.csv", "--up", "y")
    (facet,) = pd.read_csv(tmp_path / "b.csv", comment="#").to_dict("records")
    assert (facet["dip_direction_deg"], facet["dip_deg"]) == pytest.approx((90.0, 20.0), abs=0.1)
