"""Writing models: nothing lost silently, nothing half written, read by other programs."""

from __future__ import annotations

import importlib.metadata
import io
import json
import resource
import shutil
import signal
import struct
import subprocess
from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path

import laspy
import numpy as np
import pyogrio
import pytest
import trimesh
from PIL import Image

from tests.messages import by_code, refused
from vomstudio.core.errors import Cancelled, GeometryError, TargetError, UsageError
from vomstudio.core.findings import uncoded_finding
from vomstudio.core.progress import CancelToken, SilentProgress
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.io.models import writers, writing
from vomstudio.io.models.opening import read_model
from vomstudio.io.models.writers.las import SAMPLE_POINTS, quantise_axis
from vomstudio.io.models.writing import find_writers, write_model

UTM = np.array([576712.345, 5188123.456, 151.5])
CLOUDS = [".ply", ".las", ".laz", ".xyz", ".csv", ".glb", ".obj"]


def image(folder: Path, name: str, color: tuple[int, int, int]) -> Path:
    folder.mkdir(exist_ok=True)
    Image.new("RGB", (4, 4), color).save(folder / name)
    return folder / name


def textured(folder: Path) -> Mesh:
    """Two tiles of a floor with a texture each, a third without, millimetre coordinates."""
    x, y = np.meshgrid(np.arange(4.0), np.arange(2.0))
    corners = np.stack([x, y, 0.001 * x * y], -1).reshape(-1, 3) + UTM
    vertices = corners.round(3)
    faces = [[k, k + 1, k + 5, k, k + 5, k + 4] for k in range(3)]
    uv = np.stack([x / 3, y * 0.7], -1).reshape(-1, 2).astype(np.float32)
    materials = (
        Material("left tile", image(folder / "a", "rock.png", (200, 0, 0))),
        Material("left tile", image(folder / "b", "rock.png", (0, 200, 0)), (1.0, 0.5, 0.25)),
        Material("grey", None, (0.5, 0.5, 0.5)),
    )
    return Mesh(
        vertices,
        np.array(faces, np.int32).reshape(-1, 3),
        materials,
        np.array([0, 2, 4, 6]),
        uv,
        np.arange(24, dtype=np.uint8).reshape(8, 3) * 10,
        {"rough ness": np.arange(8, dtype=np.float32), "facet": np.arange(8, dtype=np.int32) - 3},
    )


def cloud(n: int = 500) -> PointCloud:
    rng = np.random.default_rng(2)
    normals = rng.normal(size=(n, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return PointCloud(
        (rng.random((n, 3)) * [100, 50, 20] + UTM).round(3),
        rng.integers(0, 256, (n, 3)).astype(np.uint8),
        normals.astype(np.float32),
        {
            "intensity": rng.integers(0, 65536, n).astype(np.uint16),
            "curvature": rng.random(n).astype(np.float32),
            "facet": rng.integers(-1, 9, n).astype(np.int32),
            "gps_time": rng.random(n) * 1e9,
        },
    )


def triangles(mesh: Mesh) -> np.ndarray:
    return mesh.vertices[mesh.faces]


def in_order(corners: np.ndarray) -> np.ndarray:
    """Triangles in an order that does not depend on who wrote them."""
    return corners[np.lexsort(corners.reshape(-1, 9).round(2).T)]


def back(path: Path) -> Mesh | PointCloud:
    loaded = read_model(path)
    assert loaded.crs in (None, "EPSG:32615")
    return loaded.data


@pytest.mark.parametrize("ending", [".obj", ".ply", ".glb"])
def test_textured_meshes_round_trip(tmp_path: Path, ending: str) -> None:
    mesh = textured(tmp_path)
    (tmp_path / "out").mkdir()
    path = tmp_path / "out" / f"floor{ending}"
    findings = by_code(write_model(mesh, "EPSG:32615", path))
    shutil.rmtree(tmp_path / "a")
    shutil.rmtree(tmp_path / "b")
    loaded = read_model(path)
    found = loaded.data
    assert isinstance(found, Mesh)
    assert loaded.crs == "EPSG:32615"
    assert loaded.warnings == ()
    tolerance = 3e-5 if ending == ".glb" else 0
    assert np.abs(triangles(found) - triangles(mesh)).max() <= tolerance
    assert found.material_offsets.tolist() == [0, 2, 4, 6]
    colors = []
    for material in found.materials[:2]:
        assert material.texture is not None
        with Image.open(material.texture) as picture:
            colors.append(picture.convert("RGB").getpixel((0, 0)))
    assert colors == [(200, 0, 0), (0, 200, 0)]
    assert found.uv is not None
    assert mesh.uv is not None
    assert np.allclose(found.uv[found.faces[:4]], mesh.uv[mesh.faces[:4]], atol=1e-7)
    assert found.colors is not None
    assert mesh.colors is not None
    assert np.array_equal(found.colors[found.faces], mesh.colors[mesh.faces])
    if ending == ".obj":
        assert "rough ness" in findings["model.fields-not-written"]["fields"]
    else:
        assert np.array_equal(found.fields["facet"][found.faces], mesh.fields["facet"][mesh.faces])
    if ending == ".ply":
        assert findings["model.materials-not-written"]["materials"]
    else:
        assert found.materials[1].diffuse == pytest.approx((1.0, 0.5, 0.25), abs=1e-6)


@pytest.mark.parametrize("ending", CLOUDS)
def test_clouds_round_trip_or_losses_are_reported(tmp_path: Path, ending: str) -> None:
    given = cloud()
    path = tmp_path / f"points{ending}"
    findings = write_model(given, "EPSG:32615", path)
    loaded = read_model(path)
    found = loaded.data
    assert isinstance(found, PointCloud)
    assert loaded.crs == "EPSG:32615"
    tolerance = {".glb": 3e-5, ".las": 1e-9, ".laz": 1e-9}.get(ending, 0.0)
    assert np.abs(found.points - given.points).max() <= tolerance
    assert found.colors is not None
    assert given.colors is not None
    assert np.array_equal(found.colors, given.colors)
    if found.normals is not None:
        assert given.normals is not None
        assert np.allclose(found.normals, given.normals, atol=1e-7)
    else:
        assert {each.code for each in findings} & {
            "model.normals-not-written",
            "model.normals-as-fields",
        }
    for name, values in given.fields.items():
        if name not in found.fields:
            lost = by_code(findings)["model.fields-not-written"]["fields"]
            assert name in lost
        elif not np.array_equal(found.fields[name].astype(values.dtype), values):
            assert any(
                each.values.get("field") == name and each.code == "model.field-rounded"
                for each in findings
            )
    if ending in (".ply", ".las", ".laz", ".xyz", ".csv"):
        assert set(given.fields) <= set(found.fields)


def test_trimesh_reads_a_written_glb_correctly(tmp_path: Path) -> None:
    mesh = textured(tmp_path)
    path = tmp_path / "floor.glb"
    write_model(mesh, "EPSG:32615", path)
    scene = trimesh.load(path)
    assert len(scene.geometry) == 3
    origin = np.array(
        json.loads(path.read_bytes()[20:].split(b"\0")[0].split(b"BIN")[0][:-4])["asset"]["extras"][
            "origin"
        ]
    )
    assert (origin == np.rint(origin)).all()
    joined = scene.to_geometry().triangles
    upright = np.stack([joined[..., 0], -joined[..., 2], joined[..., 1]], -1) + origin
    assert np.abs(in_order(upright) - in_order(triangles(mesh))).max() < 3e-5
    first = next(iter(scene.geometry.values())).visual.material
    assert first.baseColorTexture.convert("RGB").getpixel((0, 0)) == (200, 0, 0)
    beside = (tmp_path / "floor.offset.txt").read_text()
    assert beside.startswith("EPSG:32615; ")
    assert beside.endswith("offset {:.0f} {:.0f} {:.0f}\n".format(*origin))


def test_a_glb_follows_the_rules_of_its_container(tmp_path: Path) -> None:
    path = tmp_path / "floor.glb"
    write_model(textured(tmp_path), None, path)
    content = path.read_bytes()
    magic, version, length, size, kind = struct.unpack_from("<4sIII4s", content)
    assert (magic, version, length, kind) == (b"glTF", 2, len(content), b"JSON")
    scene = json.loads(content[20 : 20 + size])
    body_size, body_kind = struct.unpack_from("<I4s", content, 20 + size)
    assert (body_size, body_kind) == (len(content) - 28 - size, b"BIN\0")
    assert scene["buffers"][0]["byteLength"] == body_size
    for view in scene["bufferViews"]:
        assert view["byteOffset"] % 4 == 0
        assert view["byteOffset"] + view["byteLength"] <= body_size
    for mesh in scene["meshes"]:
        for primitive in mesh["primitives"]:
            assert "min" in scene["accessors"][primitive["attributes"]["POSITION"]]
            used = [scene["accessors"][a] for a in primitive["attributes"].values()]
            assert 5125 not in [accessor["componentType"] for accessor in used]


def test_laspy_reads_a_laz_with_its_reference_system_and_fields(tmp_path: Path) -> None:
    given = cloud()
    path = tmp_path / "points.laz"
    write_model(given, "EPSG:32615", path)
    las = laspy.read(path)
    assert las.header.parse_crs().to_epsg() == 32615
    assert np.abs(las.xyz - given.points).max() < 1e-9
    assert las.header.scales.tolist() == [0.001] * 3
    assert given.colors is not None
    assert np.array_equal(np.asarray(las.red), given.colors[:, 0].astype(int) * 257)
    assert np.array_equal(las["curvature"], given.fields["curvature"])
    assert np.array_equal(las.gps_time, given.fields["gps_time"])
    assert np.array_equal(las.intensity, given.fields["intensity"])


def test_rewritten_laz_keeps_its_scale(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    fine = rng.integers(0, 10**9, (100, 3)) * 1e-8 + [624000.123456789, 5_000_000.0, 0.0]
    findings = write_model(PointCloud(fine), None, tmp_path / "fine.laz")
    assert np.abs(back(tmp_path / "fine.laz").points - fine).max() < 2e-8  # type: ignore[union-attr]
    assert findings == []
    wild = rng.random((100, 3)) * 100 + [624000.0, 5_000_000.0, 0.0]
    (finding,) = write_model(PointCloud(wild), None, tmp_path / "wild.laz")
    assert np.abs(back(tmp_path / "wild.laz").points - wild).max() <= 0.501e-5  # type: ignore[union-attr]
    assert finding.code == "model.positions-rounded"
    assert finding.values["rounding_mm"] == pytest.approx(0.01)
    wide = wild * [1e4, 1, 1]
    write_model(PointCloud(wide), None, tmp_path / "wide.laz")
    assert np.abs(back(tmp_path / "wide.laz").points - wide).max() < 0.06  # type: ignore[union-attr]


def test_gdal_reads_a_csv(tmp_path: Path) -> None:
    given = cloud(20)
    path = tmp_path / "points.csv"
    write_model(given, None, path)
    about, _, _, columns = pyogrio.raw.read(path, read_geometry=False)
    table = dict(zip(about["fields"], columns, strict=True))
    points = np.stack([table[name].astype(float) for name in "xyz"], axis=1)
    assert np.array_equal(points, given.points)
    assert np.array_equal(table["facet"].astype(int), given.fields["facet"])


@pytest.mark.skipif(shutil.which("CloudCompare") is None, reason="CloudCompare is not installed")
@pytest.mark.skipif(shutil.which("xvfb-run") is None, reason="xvfb-run is not installed")
@pytest.mark.slow
def test_cloudcompare_opens_written_files(tmp_path: Path) -> None:
    mesh = textured(tmp_path)
    words = ["xvfb-run", "-a", "CloudCompare", "-SILENT", "-AUTO_SAVE", "OFF"]
    (tmp_path / "out").mkdir()
    for ending in (".obj", ".ply"):
        write_model(mesh, None, tmp_path / "out" / f"m{ending}")
        words += ["-O", str(tmp_path / "out" / f"m{ending}")]
    for ending in (".ply", ".xyz"):
        write_model(cloud(), None, tmp_path / "out" / f"c{ending}")
        words += ["-O", str(tmp_path / "out" / f"c{ending}")]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, check=False)
    assert done.stdout.count("loaded successfully") == 4
    assert done.stdout.count("mesh with 6 faces") == 2
    assert done.stdout.count("500 points") == 2


def test_a_mesh_without_materials_and_without_uv_is_written(tmp_path: Path) -> None:
    mesh = textured(tmp_path)
    bare = Mesh(mesh.vertices, mesh.faces)
    for ending in (".obj", ".ply", ".glb"):
        write_model(bare, None, tmp_path / f"bare{ending}")
        found = back(tmp_path / f"bare{ending}")
        assert isinstance(found, Mesh)
        assert found.materials == ()
        assert np.abs(triangles(found) - triangles(bare)).max() < 3e-5


@pytest.mark.parametrize("ending", [".obj", ".ply", ".glb"])
def test_vertices_without_texture_coordinates_stay_without(tmp_path: Path, ending: str) -> None:
    mesh = textured(tmp_path)
    assert mesh.uv is not None
    mesh.uv[3::4] = np.nan
    write_model(mesh, None, tmp_path / f"part{ending}")
    found = back(tmp_path / f"part{ending}")
    assert isinstance(found, Mesh)
    assert found.uv is not None

    def placed(model: Mesh) -> dict[tuple[float, ...], bool]:
        """Whether a triangle, by its middle, has texture coordinates throughout."""
        assert model.uv is not None
        middles = triangles(model).mean(axis=1).round(3)
        whole = np.isfinite(model.uv[model.faces]).all(axis=(1, 2))
        return dict(zip(map(tuple, middles.tolist()), whole.tolist(), strict=True))

    before, after = placed(mesh), placed(found)
    assert sorted(before.values()) == sorted(after.values()) == [False] * 2 + [True] * 4
    if ending != ".glb":  # which rounds to float32
        assert before == after


def test_trimesh_finds_no_texture_coordinates_on_untextured_faces(tmp_path: Path) -> None:
    """By trimesh, which gives each part of a scene on its own."""
    import trimesh

    mesh = textured(tmp_path)
    assert mesh.uv is not None
    mesh.uv[3::4] = np.nan
    write_model(mesh, None, tmp_path / "part.glb")
    parts = trimesh.load(tmp_path / "part.glb", process=False).geometry.values()
    with_uv = [len(p.faces) for p in parts if getattr(p.visual, "uv", None) is not None]
    assert sum(with_uv) == 4
    assert sum(len(p.faces) for p in parts) == 6


def test_existing_image_is_never_overwritten(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    theirs = image(tmp_path / "out", "rock.png", (9, 9, 9)).read_bytes()
    mesh = textured(tmp_path)
    for _ in range(2):
        write_model(mesh, None, tmp_path / "out" / "m.obj", force=True)
    assert (tmp_path / "out" / "rock.png").read_bytes() == theirs
    names = sorted(p.name for p in (tmp_path / "out").glob("*.png"))
    assert names == ["m_rock.png", "m_rock_2.png", "rock.png"] or len(names) == 3
    found = back(tmp_path / "out" / "m.obj")
    assert isinstance(found, Mesh)
    assert {m.texture.name for m in found.materials if m.texture} == set(names) - {"rock.png"}


def test_a_model_may_be_written_over_itself(tmp_path: Path) -> None:
    write_model(textured(tmp_path), "EPSG:32615", tmp_path / "m.obj")
    before = sorted(p.name for p in tmp_path.iterdir())
    first = (tmp_path / "m.obj").read_bytes()
    write_model(back(tmp_path / "m.obj"), "EPSG:32615", tmp_path / "m.obj", force=True)
    assert (tmp_path / "m.obj").read_bytes() == first
    assert sorted(p.name for p in tmp_path.iterdir()) == before


@pytest.mark.parametrize("ending", [".obj", ".ply", ".glb", ".laz", ".csv", ".dxf", ".shp"])
def test_existing_file_is_kept_unless_forced(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"m{ending}"
    path.write_text("precious")
    mesh = textured(tmp_path)
    with refused("output.exists", TargetError):
        write_model(mesh, None, path)
    assert path.read_text() == "precious"
    write_model(mesh, None, path, force=True)
    assert path.read_bytes()[:8] != b"precious"


@pytest.mark.parametrize(
    "ending", [".obj", ".ply", ".glb", ".las", ".laz", ".xyz", ".csv", ".dxf", ".shp"]
)
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("kind", ["mesh", "cloud"])
def test_non_finite_coordinates_are_rejected_before_writing(
    tmp_path: Path, ending: str, value: float, kind: str
) -> None:
    (tmp_path / "in").mkdir()
    data = textured(tmp_path / "in") if kind == "mesh" else cloud(5)
    points = data.vertices if isinstance(data, Mesh) else data.points
    points[2, 1] = value
    path = tmp_path / f"m{ending}"
    with refused("model.not-finite", GeometryError, count=1, first_row=2, file=path):
        write_model(data, "EPSG:32615", path)
    assert [p.name for p in tmp_path.iterdir()] == ["in"]


@pytest.mark.parametrize("beside", ["m.mtl", "m.prj", "m.offset.txt"])
def test_existing_companion_file_prevents_all_writing(tmp_path: Path, beside: str) -> None:
    (tmp_path / beside).write_text("precious")
    path = tmp_path / ("m.glb" if "offset" in beside else "m.obj")
    with refused("output.exists", TargetError):
        write_model(textured(tmp_path), "EPSG:32615", path)
    assert not path.exists()
    assert (tmp_path / beside).read_text() == "precious"
    assert not [p for p in tmp_path.iterdir() if p.name.startswith(".")]


def test_stale_prj_of_another_model_is_reported(tmp_path: Path) -> None:
    write_model(cloud(5), "EPSG:32615", tmp_path / "m.ply")
    (finding,) = write_model(cloud(5), None, tmp_path / "m.ply", force=True)
    assert (finding.code, finding.values["file"]) == ("frame.stale-crs-file", "m.prj")


@pytest.mark.parametrize("ending", [".obj", ".ply", ".glb", ".las", ".laz", ".xyz", ".dxf", ".shp"])
def test_cancelled_write_leaves_no_files(tmp_path: Path, ending: str) -> None:
    class Later(SilentProgress):
        def step(self, done: int) -> None:
            if done:
                token.cancel()
            super().step(done)

    token = CancelToken()
    with pytest.raises(Cancelled):
        write_model(cloud(), None, tmp_path / f"m{ending}", progress=Later(token))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("ending", [".obj", ".ply", ".glb", ".las", ".laz", ".xyz", ".dxf", ".shp"])
def test_full_disk_is_reported_and_leaves_no_files(tmp_path: Path, ending: str) -> None:
    given = cloud(20_000)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, before[1]))
    try:
        with refused("disk.full", TargetError):
            write_model(given, None, tmp_path / f"m{ending}")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)
    assert list(tmp_path.iterdir()) == []


def test_a_texture_that_is_gone_stops_the_writing(tmp_path: Path) -> None:
    mesh = textured(tmp_path)
    shutil.rmtree(tmp_path / "a")
    (tmp_path / "out").mkdir()
    for ending in (".obj", ".ply", ".glb"):
        with refused("texture.unreadable", TargetError) as error:
            write_model(mesh, None, tmp_path / "out" / f"m{ending}")
        assert error.value.file is not None
        assert error.value.file.endswith("rock.png")
    assert list((tmp_path / "out").iterdir()) == []


def test_a_tiff_becomes_png_inside_a_glb(tmp_path: Path) -> None:
    mesh = textured(tmp_path)
    picture = image(tmp_path, "rock.tif", (1, 2, 3))
    first = replace(mesh.materials[0], texture=picture)
    mesh = replace(mesh, materials=(first, *mesh.materials[1:]))
    write_model(mesh, None, tmp_path / "m.glb")
    found = back(tmp_path / "m.glb")
    assert isinstance(found, Mesh)
    assert found.materials[0].texture is not None
    content = found.materials[0].texture.read_bytes()
    assert content.startswith(b"\x89PNG")
    with Image.open(io.BytesIO(content)) as inside:
        assert inside.getpixel((0, 0)) == (1, 2, 3)


def test_unusual_field_names_stay_distinct_and_are_reported(tmp_path: Path) -> None:
    values = np.arange(3.0)
    fields = {
        "Roughness (0.5)": values,
        "roughness 0 5": values + 1,
        "x": values + 2,
        "red": values + 3,
        "é": values + 4,
        "a name that is much longer than thirty-two bytes": values + 5,
        "X": values + 6,
        "big": np.array([2**60, 1, 2]),
    }
    given = PointCloud(np.eye(3), fields=fields)
    for ending in (".ply", ".laz", ".csv", ".glb"):
        findings = write_model(given, None, tmp_path / f"m{ending}")
        found = back(tmp_path / f"m{ending}")
        assert np.abs(found.bounds - [[0, 0, 0], [1, 1, 1]]).max() == 0
        first = sorted(float(v[0]) for v in found.fields.values())
        assert first == [0, 1, 2, 3, 4, 5, 6, 2**60]
        if ending != ".glb":
            assert len(findings) >= 4


def test_unknown_extension_is_rejected_with_a_list_of_formats(tmp_path: Path) -> None:
    with refused("output.unknown-format", UsageError, suffix=".docx") as error:
        write_model(cloud(3), None, tmp_path / "m.docx")
    formats = error.value.values["formats"]
    assert {".glb", ".laz", ".obj", ".ply", ".xyz"} <= set(formats.split(", "))
    assert len(find_writers()) == 7


def test_a_writer_of_another_package_writes_its_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "their_writers.py").write_text(
        "from vomstudio.core.findings import uncoded_finding\n"
        "from vomstudio.io.models.writer import Writer\n"
        "def write(out):\n"
        "    out.path.write_text(f'{len(out.data.points)} points')\n"
        "    return [uncoded_finding('Numbers only.')]\n"
        "WRITER = Writer('Made-up', ('.count',), write)\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    points = [
        EntryPoint("theirs", "their_writers:WRITER", writing.GROUP),
        EntryPoint("worse", "no_such_package:WRITER", writing.GROUP),
    ]
    monkeypatch.setattr(importlib.metadata, "entry_points", lambda group: points)
    writing.find_writer_plugins.cache_clear()
    try:
        findings = write_model(cloud(3), None, tmp_path / "m.count")
        assert findings == [uncoded_finding("Numbers only.")]
        assert (tmp_path / "m.count").read_text() == "3 points"
        with refused("output.unknown-format", UsageError) as error:
            write_model(cloud(3), None, tmp_path / "m.docx")
        assert ".count" in error.value.values["formats"]
        assert "no_such_package" in error.value.values["formats"]
    finally:
        writing.find_writer_plugins.cache_clear()


def test_default_writer_is_the_first_one_for_the_extension() -> None:
    """Which spares the import of the others must not change who writes."""
    endings = {ending for writer in find_writers() for ending in writer.extensions}
    assert endings >= writers.MODULES_BY_SUFFIX.keys()
    for ending in writers.MODULES_BY_SUFFIX:
        first = next(w for w in find_writers() if ending in w.extensions)
        assert writing.choose_writer(Path(f"m{ending}")) is first


def test_coordinates_out_of_format_range_are_rejected_before_writing(
    tmp_path: Path,
) -> None:
    far = PointCloud(np.array([[0.0, 0.0, 0.0], [1e200, 0.0, 0.0]]))
    with refused("model.exceeds-format", TargetError, format="GLB"):
        write_model(far, None, tmp_path / "far.glb")
    assert list(tmp_path.iterdir()) == []


def test_a_single_coordinate_with_more_decimals_refines_the_scale_of_all() -> None:
    """Also one that is not among the points on which the scales are tried first."""
    values = np.round(np.random.default_rng(8).uniform(5e6, 5e6 + 900.0, 5 * SAMPLE_POINTS), 3)
    assert quantise_axis(values).scale == 1e-3
    values[4] = round(values[4] + 0.0004, 4)
    axis = quantise_axis(values)
    assert axis.scale == 1e-4
    assert np.abs(axis.integers * axis.scale + axis.offset - values).max() == axis.rounding < 1e-8
