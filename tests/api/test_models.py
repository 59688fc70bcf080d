"""Models of the Python interface: read, saved, handed to PyVista."""

from __future__ import annotations

import warnings
from dataclasses import FrozenInstanceError
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vomstudio as vs
from tests.messages import refused

TRIANGLE = "v 1 2 3\nv 4 2 3\nv 1 6 5\nf 1 2 3\n"


@pytest.fixture
def triangle(tmp_path: Path) -> Path:
    path = tmp_path / "triangle.obj"
    path.write_text(TRIANGLE)
    return path


def test_model_attributes_match_info_command(command: Any, cliff: vs.Mesh) -> None:
    (told,) = command("info", vs.sample("sample.obj"))["files"]
    assert len(cliff.points) == told["points"]
    assert len(cliff.faces) == told["faces"]
    assert list(cliff.materials) == told["materials"]
    assert [str(path) for path in cliff.textures] == told["textures"]
    assert cliff.bounds.tolist() == told["bounds"]
    assert cliff.crs == told["crs"]
    assert cliff.resolution_m == pytest.approx(told["resolution_m"])
    assert cliff.points.dtype == np.float64
    assert cliff.warnings == ()


def test_file_without_frame_is_local_with_warning(triangle: Path) -> None:
    with pytest.warns(vs.errors.VomWarning) as warned:
        model = vs.read(triangle)
    assert model.crs is None
    assert [each.message.code for each in warned] == ["frame.assumed"]
    (finding,) = model.warnings
    assert finding.code == "frame.assumed"
    assumed = {"up": "z", "unit": "m", "crs": None}
    assert assumed.items() <= finding.values.items()
    assert model.points.tolist() == [[1, 2, 3], [4, 2, 3], [1, 6, 5]]


def test_declared_unit_and_up_axis_are_applied(triangle: Path) -> None:
    small = vs.read(triangle, unit="cm", up="z")
    assert small.points[1].tolist() == pytest.approx([0.04, 0.02, 0.03])
    # x East, y Up, z South.
    assert vs.read(triangle, up="y", unit="m").points[1].tolist() == [4, -3, 2]


def test_warning_lists_only_assumed_values(triangle: Path) -> None:
    for declared, assumed in (({"up": "y"}, {"unit": "m"}), ({"unit": "cm"}, {"up": "z"})):
        with pytest.warns(vs.errors.VomWarning):
            (finding,) = vs.read(triangle, **declared).warnings
        values = {name: value for name, value in finding.values.items() if name in ("up", "unit")}
        assert values == assumed
        assert finding.values["crs"] is None
        assert len(finding.values["assumed"]) == 2


def test_a_declared_crs_is_applied(tmp_path: Path) -> None:
    path = tmp_path / "zone.obj"
    path.write_text("v 500001 5000002 3\nv 500004 5000002 3\nv 500001 5000006 5\nf 1 2 3\n")
    assert vs.read(path, crs="32633").crs == "EPSG:32633"


@pytest.fixture
def in_california(tmp_path: Path) -> Path:
    """A triangle in feet of California's zone 1."""
    path = tmp_path / "feet.obj"
    path.write_text("v 6561671 1968502 3\nv 6561674 1968502 3\nv 6561671 1968506 5\nf 1 2 3\n")
    return path


def test_crs_in_feet_is_converted_to_metres(in_california: Path) -> None:
    with pytest.warns(vs.errors.VomWarning) as warned:
        feet = vs.read(in_california, crs="EPSG:2225")
    (finding,) = (each.message for each in warned)
    assert (finding.code, finding.values["unit"]) == ("frame.unit-converted", "US survey feet")
    assert feet.points[1] == pytest.approx(np.array([6561674, 1968502, 3]) * 1200 / 3937)


def test_a_model_in_feet_is_saved_in_feet(in_california: Path, tmp_path: Path) -> None:
    with pytest.warns(vs.errors.VomWarning):
        made = vs.read(in_california, crs="EPSG:2225").save(tmp_path / "feet.ply")
    with pytest.warns(vs.errors.VomWarning) as warned:
        again = vs.read(made)
    assert [each.message.code for each in warned] == ["frame.unit-converted"]
    assert again.crs == "EPSG:2225"
    expected = [[6561671, 1968502, 3], [6561674, 1968502, 3], [6561671, 1968506, 5]]
    assert again.points == pytest.approx(np.array(expected) * 1200 / 3937)


@pytest.mark.parametrize(
    ("more", "code", "values"),
    [
        ({"up": "x"}, "option.not-a-choice", {"value": "x", "field": "up"}),
        ({"unit": "yard"}, "option.not-a-choice", {"value": "yard", "field": "unit"}),
        ({"crs": "EPSG:4326"}, "frame.not-projected", {"crs": "WGS 84"}),
        ({"crs": "somewhere"}, "frame.unknown-crs", {"crs": "somewhere"}),
        (
            {"crs": "EPSG:32633", "unit": "ft"},
            "frame.unit-contradiction",
            {"crs": "WGS 84 / UTM zone 33N", "unit": "ft"},
        ),
    ],
)
def test_invalid_declarations_are_refused(
    triangle: Path, more: Any, code: str, values: dict[str, Any]
) -> None:
    with refused(code, **values):
        vs.read(triangle, **more)


@pytest.mark.parametrize("name", ["nothing.obj", "words.ply", "words.docx"])
def test_unreadable_model_is_refused_with_its_name(tmp_path: Path, name: str) -> None:
    if name.startswith("words"):
        (tmp_path / name).write_text("no model at all")
    with pytest.raises(vs.errors.InputError, match=name):
        vs.read(tmp_path / name)


def test_saved_model_keeps_type_crs_and_bounds(cliff: vs.Mesh, tmp_path: Path) -> None:
    made = cliff.save(tmp_path / "cliff.glb")
    again = vs.read(made)
    assert isinstance(again, vs.Mesh)
    assert again.crs == cliff.crs
    assert len(again.textures) == len(cliff.textures)
    assert np.abs(again.bounds - cliff.bounds).max() < 1e-4
    with pytest.raises(vs.errors.TargetError):
        cliff.save(made)
    cliff.save(made, force=True)
    with refused("output.unknown-format", vs.errors.UsageError):
        cliff.save(tmp_path / "cliff.docx")
    with pytest.raises(vs.errors.TargetError):
        cliff.save(cliff.path, force=True)


def test_point_cloud_is_read_with_colours(data_dir: Path) -> None:
    cloud = vs.read(data_dir / "brighton_beach" / "model.laz")
    assert isinstance(cloud, vs.PointCloud)
    assert len(cloud.points) == 940_393
    assert cloud.crs == "EPSG:32615"
    assert cloud.colours is not None
    assert cloud.colours.shape == (940_393, 3)
    data = cloud.to_pyvista()
    back = np.asarray(data.points, np.float64) + data.field_data["origin"]
    assert back[::1000] == pytest.approx(cloud.points[::1000], abs=1e-3)


def test_pyvista_has_one_textured_block_for_each_material(cliff: vs.Mesh) -> None:
    blocks = cliff.to_pyvista()
    assert blocks.keys() == list(cliff.materials)
    assert sum(block.n_cells for block in blocks) == len(cliff.faces)
    for block in blocks:
        assert Path(block.field_data["texture"][0]) in cliff.textures
        assert block.active_texture_coordinates.shape == (block.n_points, 2)
        assert block.field_data["origin"].tolist() == np.round(cliff.bounds.mean(axis=0)).tolist()
    area = sum(block.area for block in blocks)
    a, b, c = (cliff.points[cliff.faces[:, i]] for i in range(3))
    assert area == pytest.approx(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def test_model_with_one_material_becomes_single_pyvista_data_set(triangle: Path) -> None:
    data = vs.read(triangle, unit="m", up="z").to_pyvista()
    assert data.n_cells == 1
    assert data.points + data.field_data["origin"] == pytest.approx(
        np.array([[1, 2, 3], [4, 2, 3], [1, 6, 5]])
    )


def test_model_is_immutable_and_has_repr(cliff: vs.Mesh) -> None:
    with pytest.raises(FrozenInstanceError):
        cliff._data = None  # type: ignore[misc]
    assert "99451" in repr(cliff)
    assert "EPSG:32633" in cliff._repr_html_()


def test_mesh_from_arrays_is_accepted_by_dem() -> None:
    points = np.array([[0, 0, 0], [4, 0, 0], [4, 3, 3], [0, 3, 3]])
    face = vs.Mesh.from_arrays(points, [[0, 1, 2], [0, 2, 3]], crs="EPSG:32633")
    assert face.crs == "EPSG:32633"
    assert vs.dem(face, gsd_m=0.5).heights.max() == pytest.approx(2.75)
    with refused("array.no-such-point", count=1, first_row=1):
        vs.Mesh.from_arrays(points, [[0, 1, 2], [0, 2, 4]])
    with refused("array.shape"):
        vs.Mesh.from_arrays(points, [0, 1, 2])


def test_mesh_survives_pyvista_round_trip(cliff: vs.Mesh) -> None:
    again = vs.Mesh.from_pyvista(cliff.to_pyvista())
    assert len(again.faces) == len(cliff.faces)
    assert np.allclose(again.points[again.faces[-1]], cliff.points[cliff.faces[-1]])


def test_point_arrays_are_treated_as_clouds() -> None:
    x, y = np.meshgrid(np.arange(5.0), np.arange(4.0))
    points = np.column_stack([x.ravel(), y.ravel(), 2 * x.ravel()])
    of_array = vs.dem(points, gsd_m=0.5).heights
    import pyvista

    assert np.array_equal(vs.dem(pyvista.PolyData(points), gsd_m=0.5).heights, of_array, True)
    assert np.nanmax(of_array) == pytest.approx(7.5)


def test_functions_that_take_points_take_models_and_files(tmp_path: Path) -> None:
    points = np.array([[0, 0, 0], [4, 0, -4.01], [4, 3, -4], [0, 3, 0.01], [2, 1, -2], [1, 2, -1]])
    file = tmp_path / "trace.csv"
    file.write_text("x,y,z\n" + "".join(f"{x},{y},{z}\n" for x, y, z in points.tolist()))
    import pyvista

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        cloud = vs.read(file)
        for given in (file, str(file), cloud, pyvista.PolyData(points)):
            for call in (vs.fit_plane, vs.threepoint):
                assert call(given).dip_deg == pytest.approx(call(points).dip_deg, abs=1e-6)
            assert len(vs.fit_planes({"a": given, "b": points})) == 2
            assert vs.log(given, bed=(90, 30)).n == 6


def test_section_to_dict_matches_its_attributes() -> None:
    points = np.array([[0, 0, 0], [4, 0, 0], [4, 3, 3], [0, 3, 3.0]])
    face = vs.Mesh.from_arrays(points, [[0, 1, 2], [0, 2, 3]])
    cut = vs.section(face, plane="90/90", through=[2, 1, 0])
    assert cut.warnings == ()
    assert cut.to_dict()["length_m"] == pytest.approx(cut.length_m)
    assert cut.to_dict()["warnings"] == []
