"""Every feature of a project stands in its layer, in its place, with its figures and colour, and
files of others are left alone."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import pyogrio
import pytest
import shapely
from pyogrio.raw import read

from tests.messages import refused
from tests.project.test_gis_files import CRS, UTM, features
from vomstudio.core.errors import InputError, TargetError, UsageError
from vomstudio.geology.profiles import Thresholds
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.units import WORLD_AXES
from vomstudio.io.gis import dxf
from vomstudio.io.gis.layers import Layer
from vomstudio.project.exports.export import export_project, export_records, get_thresholds
from vomstudio.project.exports.gis_files import DISC_CORNERS, write_dxf, write_shapefiles
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement_cache import Measurements

pytestmark = [
    pytest.mark.filterwarnings("ignore:Measured:UserWarning"),
    pytest.mark.filterwarnings("ignore:'crs' was not provided:UserWarning"),
]

SIDES = (".shp", ".shx", ".dbf", ".cpg", ".prj")


@pytest.fixture(scope="module")
def records() -> dict[str, Any]:
    found = features()
    upright = Reading("r2", "R2", "shear", "line", 33.0, 12.0, 0.0, tuple((UTM + 1.0).tolist()))
    return found | {"r2": upright}


def readable_layers(path: Path) -> dict[str, tuple[str, list[Any], dict[str, Any]]]:
    """By name: kind of geometry, shapes and columns."""
    found = {}
    for name, kind in pyogrio.list_layers(path):
        if kind is None:  # the table of styles
            continue
        about, _, geometry, columns = read(path, layer=name)
        shapes = list(shapely.from_wkb(geometry))
        found[name] = (about["geometry_type"], shapes, dict(zip(about["fields"], columns)))  # noqa: B905
    return found


# --- all formats ---------------------------------------------------------------------------------
def test_geopackage_and_shapefiles_have_the_same_contents(
    tmp_path: Path, records: dict[str, Any]
) -> None:
    export_records(records, "gpkg", tmp_path / "o.gpkg")
    table = export_records(records, "shp", tmp_path / "o.shp")
    whole = readable_layers(tmp_path / "o.gpkg")
    assert list(whole) == ["planes", "traces", "lines", "lineations", "patches", "dimensions"]
    assert [kind for kind, _, _ in whole.values()] == [
        "Point Z",
        "LineString Z",
        "Point Z",
        "LineString Z",
        "Polygon Z",
        "LineString Z",
    ]
    for path, (_, shapes, columns) in zip(table.files, whole.values(), strict=True):
        ((_, others, shortened),) = readable_layers(path).values()
        assert len(shapes) == len(others)
        assert len(columns) == len(shortened)
        for one, other in zip(shapes, others, strict=True):
            a, b = (shapely.get_coordinates(s, include_z=True) for s in (one, other))
            # A ring may begin elsewhere and run the other way round.
            assert set(map(tuple, a)) == set(map(tuple, b))
        for ours, theirs in zip(columns.values(), shortened.values(), strict=True):
            if ours.dtype.kind == theirs.dtype.kind == "f":
                np.testing.assert_array_equal(ours, theirs)
        assert list(columns["name"]) == list(shortened["name"])
    for name in whole:
        assert pyogrio.read_info(tmp_path / "o.gpkg", layer=name)["crs"] == CRS


def test_files_are_named_after_their_layers_and_have_all_sidecars(
    tmp_path: Path, records: dict[str, Any]
) -> None:
    table = export_records(records, "shp", tmp_path / "o.shp")
    assert table.files[0] == tmp_path / "o.shp"
    names = {path.with_suffix(side).name for path in table.files for side in SIDES}
    assert {path.name for path in tmp_path.iterdir()} == names
    for path in table.files:
        assert path.with_suffix(".cpg").read_text() == "UTF-8"
        assert path.with_suffix(".prj").read_text().startswith('PROJCS["WGS_1984_UTM_Zone_15N"')


def test_exports_without_a_crs_state_none(tmp_path: Path, records: dict[str, Any]) -> None:
    local = {
        id_: replace(r, placement=Frame("local")) if id_ == "m1" else r
        for id_, r in records.items()
    }
    for format_ in ("shp", "dxf", "gpkg"):
        table = export_records(local, format_, tmp_path / f"o.{format_}")
        assert table.crs is None
    assert not list(tmp_path.glob("*.prj"))
    assert pyogrio.read_info(tmp_path / "o.shp")["crs"] is None
    (comment,) = re.findall("VOM Studio, .*", (tmp_path / "o.dxf").read_text("ascii"))
    assert comment.endswith(f", {WORLD_AXES.unit}")
    assert "EPSG" not in comment


def test_equivalent_prj_is_kept_and_another_is_not_replaced_without_force(
    tmp_path: Path, records: dict[str, Any]
) -> None:
    export_records(records, "shp", tmp_path / "a.shp")
    same = (tmp_path / "a.prj").read_text() + "\n"
    for format_ in ("shp", "dxf"):
        home = tmp_path / format_
        home.mkdir()
        (home / "o.prj").write_text(same)
        table = export_records(records, format_, home / f"o.{format_}")
        assert (home / "o.prj").read_text() == same
        assert table.files[0] == home / f"o.{format_}"
        other = tmp_path / f"{format_} of another place"
        other.mkdir()
        (other / "o.prj").write_text("LOCAL_CS[]")
        with pytest.raises(TargetError, match=r"o\.prj"):
            export_records(records, format_, other / f"o.{format_}")
        assert [p.name for p in other.iterdir()] == ["o.prj"]
        export_records(records, format_, other / f"o.{format_}", force=True)
        assert "PROJCS" in (other / "o.prj").read_text()
    assert (tmp_path / "shp" / "o_traces.prj").is_file()


@pytest.mark.parametrize("format_", ["csv", "gpkg", "shp", "dxf"])
def test_every_format_lists_its_files_and_keeps_existing_ones(
    tmp_path: Path, records: dict[str, Any], format_: str
) -> None:
    out = tmp_path / f"o.{format_}"
    table = export_records(records, format_, out)
    assert out in table.files
    assert all(path.is_file() for path in table.files)
    assert len(table.files) == {"shp": 6, "gpkg": 2}.get(format_, 1)
    whole = out.read_bytes()
    with pytest.raises(TargetError, match="exists"):
        export_records(records, format_, out)
    assert out.read_bytes() == whole
    out.write_bytes(b"of another day")
    export_records(records, format_, out, force=True)
    assert len(out.read_bytes()) == len(whole)


def test_export_never_replaces_the_journal(tmp_path: Path, records: dict[str, Any]) -> None:
    """Not even by force: it is all the work there is."""
    from vomstudio.project.edit import change

    project = ProjectFolder.create(
        tmp_path / "a.vom", settings=lambda: {"thresholds": {"good_M": 3.5}}
    )
    mine = {id_: r for id_, r in records.items() if id_ not in project.session.records}
    project.session.apply(change(project.session.records, "Add", mine))
    with pytest.raises(TargetError):
        export_project(project.folder, "csv", project.folder / "journal.sqlite", force=True)
    export_project(project.folder, "csv", tmp_path / "o.csv")
    with pytest.raises(TargetError, match="exists"):
        export_project(project.folder, "csv", tmp_path / "o.csv")
    export_project(project.folder, "csv", tmp_path / "o.csv", force=True)
    with refused("option.not-a-choice", UsageError) as caught:
        export_project(project.folder, "docx", tmp_path / "o.docx")
    assert caught.value.values["choices"][:5] == ("csv", "gpkg", "shp", "geojson", "dxf")
    project.close()
    with pytest.raises(InputError):
        export_project(tmp_path, "csv", tmp_path / "p.csv")


def test_thresholds_are_read_from_settings_and_damaged_ones_ignored() -> None:
    assert get_thresholds({"thresholds": {"good_M": 3.5}}) == Thresholds(good_M=3.5)
    for damaged in ({}, {"thresholds": None}, {"thresholds": {"no such": 1.0}}):
        assert get_thresholds(damaged) is None


# --- drawings ------------------------------------------------------------------------------------
def drawn(tmp_path: Path, records: dict[str, Any]) -> Any:
    export_records(records, "dxf", tmp_path / "o.dxf")
    return ezdxf.readfile(tmp_path / "o.dxf")


def test_each_type_has_its_layers_in_its_own_colour(
    tmp_path: Path, records: dict[str, Any]
) -> None:
    drawing = drawn(tmp_path, records)
    colors = {layer.dxf.name: layer.dxf.color for layer in drawing.layers}
    kinds = {"bedding": "bedding", "joint": "joint", "shear": "shear_zone_1"}
    for id_, name in kinds.items():
        expected = dxf.color_number(records[id_].color)
        mine = [n for n in colors if n == name or n.startswith(f"{name}_")]
        assert {colors[n] for n in mine} == {expected}
        assert expected != dxf.WHITE_COLOR_NUMBER
    assert colors["distance_dimensions"] == dxf.WHITE_COLOR_NUMBER
    used = {entity.dxf.layer for entity in drawing.modelspace()}
    assert used == {
        "bedding",
        "bedding_planes",
        "bedding_planes_discs",
        "shear_zone_1",
        "shear_zone_1_planes",
        "shear_zone_1_planes_discs",
        "shear_zone_1_lines",
        "joint_planes",
        "joint_planes_discs",
        "joint_patches",
        "lineation_lines",
        "lineation_lineations",
        "distance_dimensions",
        "bedding_symbols",
        "joint_symbols",
        "lineation_symbols",
        "shear_zone_1_symbols",
    }
    assert used <= set(colors)


def test_dxf_bounds_contain_all_features(tmp_path: Path, records: dict[str, Any]) -> None:
    drawing = drawn(tmp_path, records)
    places = [np.array(tuple(p.dxf.location)) for p in drawing.modelspace().query("POINT")]
    for line in drawing.modelspace().query("POLYLINE"):
        places += [np.array(tuple(v.dxf.location)) for v in line.vertices]
    assert drawing.header["$EXTMIN"] == pytest.approx(tuple(np.min(places, axis=0)))
    assert drawing.header["$EXTMAX"] == pytest.approx(tuple(np.max(places, axis=0)))
    assert f"coordinates of {CRS}, metres" in (tmp_path / "o.dxf").read_text("ascii")


def test_only_rings_are_closed_and_points_are_at_their_measured_positions(
    tmp_path: Path, records: dict[str, Any]
) -> None:
    space = drawn(tmp_path, records).modelspace()
    closed = {line.dxf.layer: line.is_closed for line in space.query("POLYLINE")}
    assert closed == {
        "bedding": False,
        "shear_zone_1": False,
        "lineation_lineations": False,
        "joint_patches": True,
        "distance_dimensions": False,
    }
    measured = Measurements().of(records, list(records))
    where = {}
    for point in space.query("POINT"):
        texts = dict(t.value.split("=", 1) for t in point.get_xdata("VOMSTUDIO")[1:])
        where[texts["name"]] = np.array(tuple(point.dxf.location))
    assert set(where) == {"B1", "B2", "S1", "J1", "L1", "R1", "R2"}
    for id_ in ("t1", "t2", "t3", "p1"):
        assert np.abs(where[records[id_].name] - measured[id_].fit.centroid).max() < 1e-9
    assert np.array_equal(where["R1"], UTM)
    assert np.array_equal(where["R2"], UTM + 1.0)


def test_disc_is_in_its_plane_without_a_hole_and_as_wide_as_the_feature(
    tmp_path: Path, records: dict[str, Any]
) -> None:
    space = drawn(tmp_path, records).modelspace()
    faces = [
        np.array([tuple(face.dxf.get(f"vtx{k}")) for k in range(4)])
        for face in space.query("3DFACE[layer=='joint_planes_discs']")
    ]
    assert len(faces) == DISC_CORNERS // 2
    fit = Measurements().of(records, ["p1"])["p1"].fit
    assert fit is not None
    area = 0.0
    for face in faces:
        off = face - fit.centroid
        assert np.abs(off @ fit.normal).max() < 1e-6
        assert np.linalg.norm(off[0]) < 1e-9
        assert np.linalg.norm(off[1:], axis=1) == pytest.approx([fit.extent / 2] * 3, rel=1e-6)
        for a, b in ((1, 2), (2, 3)):
            area += 0.5 * float(np.linalg.norm(np.cross(off[a], off[b])))
    radius, angle = fit.extent / 2, 2 * np.pi / DISC_CORNERS
    assert area == pytest.approx(DISC_CORNERS * 0.5 * radius**2 * np.sin(angle), rel=1e-9)


def test_readings_have_no_disc_because_their_width_is_unknown(
    tmp_path: Path, records: dict[str, Any]
) -> None:
    only = {id_: r for id_, r in records.items() if id_ in ("bedding", "r1")}
    space = drawn(tmp_path, only).modelspace()
    # Strike and dip as on a map, and no faces.
    assert [entity.dxftype() for entity in space] == ["POINT", "LINE", "LINE", "TEXT"]


# --- layers by hand ------------------------------------------------------------------------------
def layer(name: str, kind: Any, shapes: list[Any], columns: Any, main: bool = False) -> Layer:
    rows = {key: np.array(values) for key, values in columns.items()}
    return Layer(name, kind, [np.array(s, float) for s in shapes], rows, main)


def test_layers_without_kinds_use_their_own_name(tmp_path: Path) -> None:
    line = [[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]]
    layers = [
        layer("traces", "line", [line, line], {"kind": ["", "Fault"]}, main=True),
        layer("notes", "line", [line], {"text": ["x"]}),
        layer("sights", "point", [line[1:]], {"kind": ["Fault"]}),
    ]
    assert write_dxf(tmp_path / "o.dxf", layers, {}, None) == [tmp_path / "o.dxf"]
    space = ezdxf.readfile(tmp_path / "o.dxf").modelspace()
    assert [entity.dxf.layer for entity in space] == ["traces", "Fault", "notes", "Fault_sights"]


@pytest.mark.parametrize(
    ("extent", "faces"), [(2.0, 12), (0.0, 0), (-1.0, 0), (float("nan"), 0), (float("inf"), 0)]
)
def test_a_plane_of_unknown_extent_or_direction_has_no_disc(
    tmp_path: Path, extent: float, faces: int
) -> None:
    columns: dict[str, list[Any]] = {
        "kind": ["joint", "joint"],
        "normal_x": [0.0, np.nan],
        "normal_y": [0.0, 0.0],
        "normal_z": [1.0, 1.0],
        "extent_m": [extent, 2.0],
    }
    planes = layer("planes", "point", [[[5.0, 6.0, 7.0]], [[0.0, 0.0, 0.0]]], columns)
    write_dxf(tmp_path / "o.dxf", [planes], {}, None)
    space = ezdxf.readfile(tmp_path / "o.dxf").modelspace()
    found = space.query("3DFACE")
    assert len(found) == faces
    assert len(space.query("POINT")) == 2
    for face in found:
        corners = np.array([tuple(face.dxf.get(f"vtx{k}")) for k in range(4)])
        reach = np.linalg.norm(corners - [5.0, 6.0, 7.0], axis=1)
        assert reach == pytest.approx([0.0, 1.0, 1.0, 1.0])


def test_empty_export_is_a_valid_dxf(tmp_path: Path) -> None:
    write_dxf(tmp_path / "o.dxf", [layer("planes", "point", [], {"kind": []})], {}, None)
    drawing = ezdxf.readfile(tmp_path / "o.dxf")
    assert len(drawing.modelspace()) == 0
    assert drawing.header["$EXTMIN"] == (0.0, 0.0, 0.0)


def test_uppercase_suffix_makes_a_shapefile_and_listed_files_exist(tmp_path: Path) -> None:
    points = layer("planes", "point", [[[1.0, 2.0, 3.0]]], {"name": ["é"]})
    lines = layer("traces", "line", [[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]], {"name": ["x"]})
    made = write_shapefiles(tmp_path / "O.SHP", [points, lines], None)
    assert [path.name for path in made] == ["O.shp", "O_traces.shp"]
    assert all(path.is_file() for path in made)
    with refused("export.not-shp", UsageError) as caught:
        write_shapefiles(tmp_path / "o.txt", [points], None)
    assert "o.txt" in str(caught.value)
    (about, shapes, columns) = next(iter(readable_layers(tmp_path / "O.shp").values()))
    assert about == "Point Z"
    assert shapely.get_coordinates(shapes, include_z=True).tolist() == [[1.0, 2.0, 3.0]]
    assert list(columns["name"]) == ["é"]


def test_exported_traces_keep_their_vertex_order(tmp_path: Path, records: dict[str, Any]) -> None:
    export_records(records, "gpkg", tmp_path / "o.gpkg")
    _, shapes, columns = readable_layers(tmp_path / "o.gpkg")["traces"]
    for id_, shape in zip(columns["id"], shapes, strict=True):
        trace = records[id_]
        assert isinstance(trace, Trace)
        kept = shapely.get_coordinates(shape, include_z=True)
        assert np.array_equal(kept, np.array(trace.vertices))
