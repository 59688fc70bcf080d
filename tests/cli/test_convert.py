"""`vomstudio convert`."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.messages import messages, shown_codes
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.opening import read_model

OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 2\nf 1 2 3\n"
LYING = "v 0 0 0\nv 1 0 0\nv 0 2 -1\nf 1 2 3\n"


def corners(path: Path) -> list[list[float]]:
    data = read_model(path).data
    points = data.vertices if isinstance(data, Mesh) else data.points
    return points.round(6).tolist()


def test_conversion_result_has_documented_fields(run, write, tmp_path: Path) -> None:
    target = tmp_path / "b.glb"
    found = run("convert", write(OBJ, "a.obj"), target, "--crs", "32615", "--json").json
    assert found.keys() >= {"in", "out", "warnings"}
    assert (found["in"], found["out"]) == (str(tmp_path / "a.obj"), str(target))
    assert read_model(target).crs == "EPSG:32615"
    assert corners(target) == [[0, 0, 0], [1, 0, 0], [0, 1, 2]]


def test_content_unsupported_by_format_gives_warning(run, write, tmp_path: Path) -> None:
    ran = run("convert", write(OBJ, "a.obj"), tmp_path / "b.laz", "--json")
    assert ran.code == 0
    assert "faces" in " ".join(messages(ran.json))
    assert "faces" in ran.err


def test_up_axis_and_unit_apply_to_input(run, write, tmp_path: Path) -> None:
    lying = write(LYING, "a.obj")
    upright = [[0, 0, 0], [0.01, 0, 0], [0, 0.01, 0.02]]
    for ending in ("glb", "ply", "csv"):
        target = tmp_path / f"b.{ending}"
        assert run("convert", lying, target, "--up", "y", "--unit", "cm").code == 0
        assert corners(target) == upright


def test_up_z_keeps_gltf_axes_unrotated(run, write, tmp_path: Path) -> None:
    # Upright already when it was written as if Y were up: it lies on its side.
    run("convert", write(OBJ, "a.obj"), tmp_path / "b.glb", "--up", "y")
    (tmp_path / "b.offset.txt").write_text("offset 0 0 0")
    assert corners(tmp_path / "b.glb") == [[0, 0, 0], [1, 0, 0], [0, -2, 1]]
    run("convert", tmp_path / "b.glb", tmp_path / "c.obj", "--up", "y")
    assert corners(tmp_path / "c.obj") == [[0, 0, 0], [1, 0, 0], [0, -2, 1]]
    run("convert", tmp_path / "b.glb", tmp_path / "d.obj", "--up", "z")
    assert corners(tmp_path / "d.obj") == [[0, 0, 0], [1, 0, 0], [0, 1, 2]]


def test_unit_contradicting_crs_is_refused(run, write, tmp_path: Path) -> None:
    ran = run("convert", write(OBJ), tmp_path / "b.ply", "--crs", "32615", "--unit", "mm")
    assert ran.code == 2
    ran = run("convert", write(OBJ, "a.obj"), tmp_path / "b.ply", "--crs", "32615", "--unit", "mm")
    assert "--unit" in ran.said
    assert not (tmp_path / "b.ply").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["a.obj", "b.docx"], ".docx"),
        (["none.obj", "b.ply"], "none.obj"),
        (["a.obj", "no/b.ply"], "does not exist"),
        (["a.obj", "a.obj", "--force"], "is an input of the command"),
        (["a.obj", "bad.obj"], "--force"),
        (["a.obj", "b.ply", "--crs", "4326"], "projected"),
        (["a.obj", "b.ply", "--up", "x"], "--up"),
        (["bad.obj", "b.ply"], "bad.obj"),
    ],
)
def test_impossible_conversion_is_reported_in_one_sentence(
    run, write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: list[str], said: str
) -> None:
    write(OBJ, "a.obj")
    write(b"", "bad.obj")
    monkeypatch.chdir(tmp_path)
    ran = run("convert", *words)
    assert ran.code == 2
    assert said in ran.said
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.obj", "bad.obj"]


def test_offset_file_of_input_is_not_overwritten(run, write, tmp_path: Path) -> None:
    run("convert", write(OBJ, "a.obj"), tmp_path / "b.glb")
    (tmp_path / "b.glb").rename(tmp_path / "c.glb")
    (tmp_path / "c.offset.txt").write_text("offset 5 0 0")
    shutil.copy(tmp_path / "c.glb", tmp_path / "c.gltf")
    ran = run("convert", tmp_path / "c.gltf", tmp_path / "c.glb", "--force")
    assert "output.is-input" in shown_codes(ran.said)
    assert (tmp_path / "c.offset.txt").read_text() == "offset 5 0 0"


def test_the_survey_model_survives_glb_and_back(run, data_dir: Path, tmp_path: Path) -> None:
    source = data_dir / "brighton_model" / "brighton_utm15n.obj"
    assert run("convert", source, tmp_path / "a.glb", "--crs", "EPSG:32615").code == 0
    assert run("convert", tmp_path / "a.glb", tmp_path / "b.obj").code == 0
    before, after = read_model(source), read_model(tmp_path / "b.obj")
    assert after.crs == "EPSG:32615"
    assert after.warnings == ()
    assert isinstance(before.data, Mesh)
    assert isinstance(after.data, Mesh)
    old, new = before.data, after.data
    assert np.abs(new.vertices[new.faces] - old.vertices[old.faces]).max() < 3e-5
    assert new.uv is not None
    assert old.uv is not None
    assert np.abs(new.uv[new.faces] - old.uv[old.faces]).max() < 1e-6
    assert len(new.materials) == len({m.texture for m in new.materials} - {None}) == 9
    for a, b in zip(old.materials, new.materials, strict=True):
        assert a.name == b.name
        assert a.texture is not None
        assert b.texture is not None
        assert a.texture.read_bytes() == b.texture.read_bytes()


def test_a_cloud_becomes_a_drawing_and_a_shapefile(run, write, tmp_path: Path) -> None:
    import pyogrio

    points = write("x,y,z,depth\n576000.5,5188000.25,150.125,1\n576001,5188001,151,2\n", "a.csv")
    for ending in ("dxf", "shp"):
        target = tmp_path / f"b.{ending}"
        ran = run("convert", points, target, "--crs", "32615", "--json")
        assert ran.code == 0
        assert ran.json["out"] == str(target)
        assert any("depth" in warning for warning in messages(ran.json)) == (ending == "dxf")
        info = pyogrio.read_info(target, force_feature_count=True, force_total_bounds=True)
        assert info["features"] == 2
        assert info["total_bounds"] == (576000.5, 5188000.25, 576001.0, 5188001.0)
    assert info["crs"] == "EPSG:32615"
    again = run("convert", points, tmp_path / "b.shp")
    assert "--force" in again.said


def test_a_height_model_becomes_a_mesh(run, tmp_path: Path) -> None:
    from vomstudio.io.gis.raster import Raster, open_geotiff, write_tile

    grid = Raster(3, 2, "float", (2.0, 0.0, 576000.0, 0.0, -2.0, 5188000.0), "EPSG:32615")
    with open_geotiff(tmp_path / "dem.tif", grid) as dataset:
        write_tile(dataset, 0, 0, np.arange(6, dtype=np.float32).reshape(2, 3) + 100)
    assert run("convert", tmp_path / "dem.tif", tmp_path / "dem.ply").code == 0
    loaded = read_model(tmp_path / "dem.ply")
    assert loaded.crs == "EPSG:32615"
    assert isinstance(loaded.data, Mesh)
    assert loaded.data.bounds.tolist() == [[576001, 5187997, 100], [576005, 5187999, 105]]
    assert len(loaded.data.faces) == 4
