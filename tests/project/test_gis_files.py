"""DXF drawings and shapefiles of models and of a project's features, as other programs see them."""

from __future__ import annotations

import contextlib
import shutil
import struct
import subprocess
from dataclasses import replace
from pathlib import Path

import ezdxf
import numpy as np
import pyogrio
import pytest
import shapely
from ezdxf.lldxf.encoding import decode_dxf_unicode
from pyogrio.raw import read

from tests.io.models.test_writers import cloud, textured
from tests.messages import refused
from tests.small_disk import small_disk
from vomstudio.core.errors import Cancelled, TargetError, UsageError
from vomstudio.core.progress import CancelToken, SilentProgress
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.patches import ids_to_runs, moments, outline
from vomstudio.geometry.units import Axes
from vomstudio.io.gis import dxf, shapefile
from vomstudio.io.models.writing import write_model
from vomstudio.project.exports.export import export_records
from vomstudio.project.kinds.dimension import Dimension
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import DEFAULT_TYPES, FeatureType, Model

CRS = "EPSG:32615"
UTM = np.array([576712.345, 5188123.456, 151.5])


def table_of(path: Path) -> tuple[dict, np.ndarray, dict[str, np.ndarray]]:
    about, _, geometry, columns = read(path)
    places = shapely.get_coordinates(shapely.from_wkb(geometry), include_z=True)
    return about, places, dict(zip(about["fields"], columns, strict=True))


# --- clouds ------------------------------------------------------------------------------------


def test_gdal_reads_the_same_cloud_from_a_shapefile(tmp_path: Path) -> None:
    given = cloud()
    said = write_model(given, CRS, tmp_path / "c.shp")
    assert said == []
    assert sorted(p.suffix for p in tmp_path.iterdir()) == [".cpg", ".dbf", ".prj", ".shp", ".shx"]
    about, places, columns = table_of(tmp_path / "c.shp")
    assert about["crs"] == CRS
    assert about["geometry_type"] == "Point Z"
    assert np.array_equal(places, given.points)
    for name, values in given.fields.items():
        assert np.array_equal(columns[name].astype(values.dtype), values)
    assert given.colors is not None
    assert np.array_equal(columns["green"].astype(int), given.colors[:, 1])
    assert given.normals is not None
    assert np.array_equal(columns["normal_z"].astype(np.float32), given.normals[:, 2])
    assert pyogrio.read_info(tmp_path / "c.shp")["total_bounds"] == pytest.approx(
        given.bounds[:, :2].ravel(), abs=1e-9
    )


def test_every_kind_of_number_survives_the_table_of_a_shapefile(tmp_path: Path) -> None:
    fields = {
        "small": np.array([-128, 0, 127], np.int8),
        "big": np.array([-(10**16), 5, 10**17]),
        "huge": np.array([2**64 - 1, 0, 1], np.uint64),
        "tiny": np.array([-2.2250738585072014e-308, 1.7976931348623157e308, np.nan]),
        "tenth": np.array([0.1, -1 / 3, np.inf], np.float32),
        "yes": np.array([True, False, True]),
        "a name too long for it": np.arange(3),
        "a name too long for this": np.arange(3) + 7,
    }
    said = write_model(PointCloud(np.eye(3), fields=fields), None, tmp_path / "c.shp")
    assert len(said) == 2
    _, _, columns = table_of(tmp_path / "c.shp")
    assert columns["small"].tolist() == [-128, 0, 127]
    assert columns["big"].tolist() == [-(10**16), 5, 10**17]
    assert columns["huge"].astype(float)[0] == 2.0**64
    assert columns["tiny"][:2].tolist() == fields["tiny"][:2].tolist()
    assert np.isnan(columns["tiny"][2])
    assert np.array_equal(columns["tenth"].astype(np.float32)[:2], fields["tenth"][:2])
    assert [bool(v) for v in columns["yes"]] == [True, False, True]
    assert columns["a name too"].tolist() == [0, 1, 2]
    assert columns["a name t_2"].tolist() == [7, 8, 9]


def test_bare_cloud_gets_an_id_column_and_mesh_reports_lost_data(tmp_path: Path) -> None:
    write_model(PointCloud(np.eye(3) + UTM), None, tmp_path / "c.shp")
    about, places, columns = table_of(tmp_path / "c.shp")
    assert about["crs"] is None
    assert np.array_equal(places, np.eye(3) + UTM)
    assert columns["id"].tolist() == [1, 2, 3]
    said = write_model(textured(tmp_path), None, tmp_path / "m.shp")
    assert "faces" in str(said[0])
    assert "rock.png" in str(said[1])


def test_too_many_points_for_a_shapefile_are_rejected_before_writing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shapefile, "MAX_BYTES", 30_000)
    with refused("model.exceeds-format", TargetError):
        write_model(cloud(), None, tmp_path / "c.shp")
    assert list(tmp_path.iterdir()) == []


def test_equivalent_prj_is_kept_and_a_different_one_is_rejected(tmp_path: Path) -> None:
    write_model(cloud(5), CRS, tmp_path / "a.ply")
    before = (tmp_path / "a.prj").read_text()
    write_model(cloud(5), CRS, tmp_path / "a.shp")
    assert (tmp_path / "a.prj").read_text() == before
    assert pyogrio.read_info(tmp_path / "a.shp")["crs"] == CRS
    with refused("output.exists", TargetError):
        write_model(cloud(5), "EPSG:32633", tmp_path / "a.dxf")


def test_ezdxf_and_gdal_read_a_cloud_from_a_dxf(tmp_path: Path) -> None:
    given = cloud()
    said = " ".join(map(str, write_model(given, CRS, tmp_path / "c.dxf")))
    for word in ("intensity", "normals", "255"):
        assert word in said
    drawing = ezdxf.readfile(tmp_path / "c.dxf")
    assert drawing.audit().has_errors is False
    found = list(drawing.modelspace().query("POINT"))
    assert np.array_equal(np.array([tuple(p.dxf.location) for p in found]), given.points)
    _, places, _ = table_of(tmp_path / "c.dxf")
    assert np.array_equal(places, given.points)
    assert given.colors is not None
    shown = np.array([ezdxf.colors.aci2rgb(p.dxf.color) for p in found], float)
    wanted = given.colors.astype(float)
    every = np.array([ezdxf.colors.aci2rgb(i) for i in range(1, 256)], float)
    best = np.linalg.norm(wanted[:, None] - every[None], axis=2).min(axis=1)
    assert (np.linalg.norm(shown - wanted, axis=1) - best).max() < 60
    assert np.linalg.norm(shown - wanted, axis=1).mean() < best.mean() + 6
    assert drawing.header["$EXTMIN"] == pytest.approx(tuple(given.bounds[0]))


def test_mesh_faces_are_on_one_layer_per_material(tmp_path: Path) -> None:
    mesh = textured(tmp_path)
    said = " ".join(map(str, write_model(mesh, None, tmp_path / "m.dxf")))
    assert "rock.png" in said
    faces = list(ezdxf.readfile(tmp_path / "m.dxf").modelspace().query("3DFACE"))
    assert len(faces) == 6
    corners = np.array([[tuple(f.dxf.get(f"vtx{k}")) for k in range(3)] for f in faces])
    assert np.array_equal(corners, mesh.vertices[mesh.faces])
    assert [f.dxf.layer for f in faces[:4]] == ["left_tile"] * 4
    assert faces[4].dxf.layer == "grey"
    bare = Mesh(mesh.vertices, mesh.faces)
    write_model(bare, None, tmp_path / "bare.dxf")
    assert len(ezdxf.readfile(tmp_path / "bare.dxf").modelspace().query("3DFACE")) == 6


@pytest.mark.parametrize("metric", [True, False])
def test_dxf_states_metres_only_if_they_are_the_unit(tmp_path: Path, metric: bool) -> None:
    said = ezdxf.units.M if metric else 0
    write_model(cloud(5), None, tmp_path / "c.dxf", axes=Axes(metric=metric, north=False))
    assert ezdxf.readfile(tmp_path / "c.dxf").units == said
    # Coordinates of a CRS in feet are no metres.
    write_model(cloud(5), "EPSG:2236", tmp_path / "feet.dxf")
    assert ezdxf.readfile(tmp_path / "feet.dxf").units == 0
    records = features()
    if not metric:
        records = {
            key: replace(each, placement=Frame()) if isinstance(each, Model) else each
            for key, each in records.items()
        }
    export_records(records, "dxf", tmp_path / "o.dxf")
    assert ezdxf.readfile(tmp_path / "o.dxf").units == said


def test_layer_names_are_valid_in_dxf() -> None:
    names = dxf.layer_names(["a b", "a_b", "A/B", "é" * 40, "é" * 41, "", "50%"])
    assert len({n.casefold() for n in names.values()}) == len(names)
    assert max(map(len, names.values())) <= 31
    assert not any(set(name) & set('<>/\\":;?*|=,` %') for name in names.values())


# --- features ----------------------------------------------------------------------------------

FRAME = Frame("crs", CRS)


def features() -> dict:
    rng = np.random.default_rng(3)
    model = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, FRAME)
    plane = rng.uniform(-2, 2, (40, 2)) @ np.array([[1.0, 0, 0], [0, 0.8, -0.6]]) + UTM
    m = moments(plane)
    on_model = ("m1", "0" * 64)

    def points(rows: np.ndarray) -> tuple:
        return tuple(map(tuple, rows.tolist()))

    def trace(id_: str, name: str, kind: str, shift: float) -> Trace:
        return Trace(id_, name, kind, *on_model, points(plane[:9] + shift), notes='wet, "é"')

    listed = [
        model,
        *DEFAULT_TYPES,
        FeatureType("shear", "Shear zoné 1", "#112233"),
        trace("t1", "B1", "bedding", 0.0),
        trace("t2", "B2", "bedding", 5.0),
        trace("t3", "S1", "shear", 9.0),
        Patch(
            "p1",
            "J1",
            "joint",
            *on_model,
            "point",
            ids_to_runs(range(m.n)),
            m.n,
            m.mean,
            m.scatter,
            m.n_effective,
            outline(plane, (0.0, 0.0, 1.0)),
        ),
        Lineation("l1", "L1", "lineation", *on_model, points(plane[:3])),
        Dimension("d1", "D1", "distance", *on_model, points(plane[:2])),
        Reading("r1", "R1", "bedding", "plane", 120.0, 40.0, 0.0, tuple(UTM.tolist())),
    ]
    return {record.id: record for record in listed}


def test_gdal_reads_a_shapefile_for_each_layer(tmp_path: Path) -> None:
    records = features()
    table = export_records(records, "shp", tmp_path / "o.shp")
    stems = [path.stem for path in table.files]
    assert stems == ["o", "o_traces", "o_lines", "o_lineations", "o_patches", "o_dimensions"]
    measured = Measurements().of(records, list(records))
    for path in table.files:
        info = pyogrio.read_info(path)
        assert info["crs"] == CRS
        assert max(len(name) for name in info["fields"]) <= 10
    about, _, geometry, columns = read(tmp_path / "o_traces.shp")
    assert about["geometry_type"].endswith("LineString Z")
    for line, id_ in zip(shapely.from_wkb(geometry), ("t1", "t2", "t3"), strict=True):
        kept = shapely.get_coordinates(line, include_z=True)
        assert np.array_equal(kept, measured[id_].points)
    fields = dict(zip(about["fields"], columns, strict=True))
    assert fields["kind"].tolist() == ["bedding", "bedding", "shear zoné 1"]
    assert fields["notes"][0] == 'wet, "é"'
    _, places, fields = table_of(tmp_path / "o.shp")
    assert fields["name"].tolist() == ["B1", "B2", "S1", "J1", "R1"]
    for id_, place, dip, dd in zip(
        ("t1", "t2", "t3"), places, fields["dip"], fields["dip_dir"], strict=False
    ):
        fit = measured[id_].fit
        assert fit is not None
        assert (dip, dd) == (fit.dip_deg, fit.dip_direction_deg)
        assert np.abs(place - fit.centroid).max() < 1e-9
    _, _, geometry, _ = read(tmp_path / "o_patches.shp")
    (ring,) = shapely.from_wkb(geometry)
    assert ring.is_valid
    assert ring.area > 5


def test_a_drawing_has_a_layer_for_each_type_of_feature(tmp_path: Path) -> None:
    records = features()
    export_records(records, "dxf", tmp_path / "o.dxf")
    drawing = ezdxf.readfile(tmp_path / "o.dxf")
    assert drawing.audit().has_errors is False
    lines = list(drawing.modelspace().query("POLYLINE"))
    assert [line.dxf.layer for line in lines[:3]] == ["bedding", "bedding", "shear_zone_1"]
    measured = Measurements().of(records, list(records))
    for line, id_ in zip(lines, ("t1", "t2", "t3"), strict=False):
        assert line.is_3d_polyline
        kept = np.array([tuple(v.dxf.location) for v in line.vertices])
        assert np.array_equal(kept, measured[id_].points)
    assert [line.is_closed for line in lines].count(True) == 1
    blue = ezdxf.colors.aci2rgb(drawing.layers.get("bedding").dxf.color)
    assert blue[2] > blue[1] > blue[0]
    points = list(drawing.modelspace().query("POINT"))
    texts = dict(t.value.split("=", 1) for t in points[0].get_xdata("VOMSTUDIO")[1:])
    fit = measured["t1"].fit
    assert fit is not None
    assert float(texts["dip_deg"]) == fit.dip_deg
    assert decode_dxf_unicode(texts["notes"]) == 'wet, "é"'
    discs = np.array(
        [
            [tuple(face.dxf.get(f"vtx{k}")) for k in range(4)]
            for face in drawing.modelspace().query("3DFACE[layer=='bedding_planes_discs']")
        ]
    )
    assert len(discs) == 24
    first = discs[:12].reshape(-1, 3) - fit.centroid
    assert np.abs(first @ fit.normal).max() < 1e-6
    assert np.linalg.norm(first, axis=1).max() == pytest.approx(fit.extent / 2, rel=1e-6)


# GDAL says so of every 3DFACE.
@pytest.mark.filterwarnings("ignore:Non closed ring:RuntimeWarning")
def test_gdal_reads_the_dxf_of_a_project(tmp_path: Path) -> None:
    records = features()
    export_records(records, "dxf", tmp_path / "o.dxf")
    about, _, geometry, columns = read(tmp_path / "o.dxf")
    layers = dict(zip(about["fields"], columns, strict=True))["Layer"].tolist()
    assert {"bedding", "bedding_planes", "joint_patches", "distance_dimensions"} <= set(layers)
    shapes = shapely.from_wkb(geometry)
    first = shapes[layers.index("bedding")]
    kept = shapely.get_coordinates(first, include_z=True)
    assert np.array_equal(kept, Measurements().of(records, ["t1"])["t1"].points)
    assert (tmp_path / "o.prj").read_text().startswith("PROJCS")


def test_output_is_replaced_only_with_force_and_leaves_no_partial_files(tmp_path: Path) -> None:
    (tmp_path / "o_traces.dbf").write_text("precious")
    with refused("output.exists", TargetError):
        export_records(features(), "shp", tmp_path / "o.shp")
    assert [p.name for p in tmp_path.iterdir()] == ["o_traces.dbf"]
    export_records(features(), "shp", tmp_path / "o.shp", force=True)
    assert (tmp_path / "o_traces.dbf").read_bytes()[0] == 3
    with refused("export.not-shp", UsageError):
        export_records(features(), "shp", tmp_path / "o")
    for format_ in ("shp", "dxf"):
        with refused("output.no-folder", TargetError):
            export_records(features(), format_, tmp_path / "no" / f"o.{format_}")


@pytest.mark.filterwarnings("ignore:Measured:UserWarning")
def test_features_without_a_plane_are_still_exported_as_lines(tmp_path: Path) -> None:
    records = features()
    straight = Trace("t9", "X", "bedding", "m1", "0" * 64, ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)))
    kept = {k: r for k, r in records.items() if k in ("m1", "bedding")} | {"t9": straight}
    for format_ in ("shp", "dxf", "gpkg"):
        table = export_records(kept, format_, tmp_path / f"o.{format_}")
        assert len(table.skipped) == 1
    assert pyogrio.read_info(tmp_path / "o.shp")["features"] == 0
    assert pyogrio.read_info(tmp_path / "o_traces.shp")["features"] == 1
    assert len(ezdxf.readfile(tmp_path / "o.dxf").modelspace().query("POLYLINE")) == 1


# --- mishaps -----------------------------------------------------------------------------------


@pytest.mark.parametrize("ending", [".dxf", ".shp", ".laz", ".ply", ".glb", ".csv"])
def test_disk_that_fills_up_is_reported_and_left_clean(tmp_path: Path, ending: str) -> None:
    rng = np.random.default_rng(1)
    fields = {"roughness": rng.random(300_000)}
    given = PointCloud(rng.random((300_000, 3)) * 100 + UTM, fields=fields)
    with small_disk(tmp_path / "disk") as disk:
        (disk / "filler").write_bytes(bytes(6_000_000))
        with refused("disk.full", TargetError):
            write_model(given, CRS, disk / f"c{ending}")
        assert [p.name for p in disk.iterdir()] == ["filler"]


@pytest.mark.parametrize("format_", ["shp", "dxf", "gpkg", "csv"])
def test_export_to_a_full_disk_is_reported_and_left_clean(tmp_path: Path, format_: str) -> None:
    with small_disk(tmp_path / "disk", 64) as disk:
        with contextlib.suppress(OSError), (disk / "filler").open("wb", buffering=0) as filler:
            while True:
                filler.write(bytes(4096))
        with pytest.raises(TargetError):
            export_records(features(), format_, disk / f"o.{format_}")
        assert [p.name for p in disk.iterdir()] == ["filler"]


@pytest.mark.parametrize("ending", [".dxf", ".shp"])
def test_cancelled_export_of_mesh_or_cloud_leaves_no_files(tmp_path: Path, ending: str) -> None:
    token = CancelToken()
    token.cancel()
    (tmp_path / "out").mkdir()
    for model in (cloud(), textured(tmp_path)):
        with pytest.raises(Cancelled):
            write_model(model, CRS, tmp_path / "out" / f"m{ending}", progress=SilentProgress(token))
    assert list((tmp_path / "out").iterdir()) == []


@pytest.mark.skipif(shutil.which("CloudCompare") is None, reason="CloudCompare is not installed")
@pytest.mark.skipif(shutil.which("xvfb-run") is None, reason="xvfb-run is not installed")
@pytest.mark.slow
def test_cloudcompare_opens_dxf_files(tmp_path: Path) -> None:
    write_model(cloud(), None, tmp_path / "c.dxf")
    export_records(features(), "dxf", tmp_path / "o.dxf")
    words = ["xvfb-run", "-a", "CloudCompare", "-SILENT", "-AUTO_SAVE", "OFF"]
    for name in ("c.dxf", "o.dxf"):
        words += ["-O", str(tmp_path / name)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, check=False)
    assert done.stdout.count("loaded successfully") == 2
    assert done.stdout.count("500 points") == 1


def test_shapefile_headers_state_the_correct_file_length(tmp_path: Path) -> None:
    export_records(features(), "shp", tmp_path / "o.shp")
    write_model(cloud(), None, tmp_path / "c.shp")
    heads = [*tmp_path.glob("*.shp"), *tmp_path.glob("*.shx")]
    assert len(heads) == 14
    for path in heads:
        (words,) = struct.unpack_from(">i", path.read_bytes(), 24)
        assert 2 * words == path.stat().st_size
