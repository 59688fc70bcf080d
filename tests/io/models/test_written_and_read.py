"""Laws over the registries: what a writer writes, a reader reads."""

from __future__ import annotations

import contextlib
import struct
from pathlib import Path

import ezdxf
import numpy as np
import pytest
from ezdxf.acis import api as acis
from ezdxf.layouts import Modelspace
from ezdxf.render.forms import cube

from tests.messages import codes
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.io.models.opening import describe, read_model
from vomstudio.io.models.registry import extensions
from vomstudio.io.models.writing import find_writers, write_model

PLACE = np.array([576712.345, 5188123.456, 151.5])
ENDINGS = [ending for writer in find_writers() for ending in writer.extensions]
WITH_FACES = {".dxf", ".glb", ".obj", ".ply"}
STEP_M = {".las": 1e-3, ".laz": 1e-3, ".glb": 1e-4}
"""Coarsest coordinate of each format; others are exact."""


def surface() -> Mesh:
    """Two materials, no two vertices at one place, all vertices used in their order."""
    x, y = np.meshgrid(np.arange(6.0), np.arange(4.0))
    heights = np.sin(x) * np.cos(y)
    vertices = (np.stack([x, y, heights], -1).reshape(-1, 3) + PLACE).round(3)
    k = np.arange(24).reshape(4, 6)
    quads = np.stack([k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]], -1).reshape(-1, 4)
    faces = quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3).astype(np.int32)
    materials = (Material("bed", None, (1.0, 0.0, 0.0)), Material("joint", None, (0.0, 0.0, 1.0)))
    return Mesh(vertices, faces, materials, np.array([0, 10, len(faces)]))


def cloud() -> PointCloud:
    rng = np.random.default_rng(5)
    points = (rng.random((300, 3)) * 40 + PLACE).round(3)
    return PointCloud(points, rng.integers(0, 256, (300, 3)).astype(np.uint8))


@pytest.mark.parametrize("ending", ENDINGS)
def test_every_written_format_can_be_read(tmp_path: Path, ending: str) -> None:
    assert ending in extensions()
    mesh, points = surface(), cloud()
    write_model(mesh, "EPSG:32615", tmp_path / f"mesh{ending}")
    write_model(points, "EPSG:32615", tmp_path / f"cloud{ending}")
    step = STEP_M.get(ending, 0.0)
    found = read_model(tmp_path / f"mesh{ending}")
    assert found.crs == "EPSG:32615"
    assert isinstance(found.data, Mesh) == (ending in WITH_FACES)
    if isinstance(found.data, Mesh):
        corners = found.data.vertices[found.data.faces]
        assert np.abs(corners - mesh.vertices[mesh.faces]).max() <= step
        assert found.data.material_offsets.tolist() in ([0, 10, 30], [0])
    else:
        assert np.abs(found.data.points - mesh.vertices).max() <= step
    again = read_model(tmp_path / f"cloud{ending}")
    assert isinstance(again.data, PointCloud)
    assert np.abs(again.data.points - points.points).max() <= step


def test_dxf_layers_become_materials(tmp_path: Path) -> None:
    mesh = surface()
    write_model(mesh, None, tmp_path / "mesh.dxf")
    found = read_model(tmp_path / "mesh.dxf")
    assert isinstance(found.data, Mesh)
    assert len(found.data.vertices) == len(mesh.vertices)
    assert [(m.name, m.diffuse) for m in found.data.materials] == [
        ("bed", (1.0, 0.0, 0.0)),
        ("joint", (0.0, 0.0, 1.0)),
    ]
    assert found.units == ("m", "m", "m")


def test_shapefile_attributes_round_trip(tmp_path: Path) -> None:
    points = cloud()
    rng = np.random.default_rng(6)
    fields = {
        "curvature": rng.normal(size=300) * 10.0 ** rng.integers(-20, 20, 300),
        "facet": rng.integers(-5, 5, 300),
        "checked": rng.random(300) < 0.5,
    }
    normals = rng.normal(size=(300, 3)).astype(np.float32)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    fields["curvature"][7] = np.nan
    write_model(
        PointCloud(points.points, points.colors, normals, fields), None, tmp_path / "points.shp"
    )
    found = read_model(tmp_path / "points.shp").data
    assert isinstance(found, PointCloud)
    assert found.colors is not None
    assert found.normals is not None
    assert points.colors is not None
    assert (found.colors == points.colors).all()
    assert (found.normals == normals).all()
    assert list(found.fields) == ["curvature", "facet", "checked"]
    for name, values in fields.items():
        np.testing.assert_array_equal(found.fields[name], values)


# --- drawings of other programs -----------------------------------------------------------------


def add_solid(space: Modelspace) -> None:
    acis.export_dxf(space.add_3dsolid(), [acis.body_from_mesh(cube())])


GRID = [[(x, y, x * y / 10) for y in range(4)] for x in range(3)]


def drawing(path: Path, *, binary: bool = False) -> Path:
    """A polyface mesh, a polygon mesh, a MESH, two 3DFACE, and what is not a face."""
    doc = ezdxf.new("R2010", units=4)
    space = doc.modelspace()
    box = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (1, 1, 5)]
    pyramid = space.add_polyface()
    pyramid.append_faces([[box[0], box[1], box[4]], [box[0], box[3], box[2], box[1]]])
    mesh = space.add_polymesh((3, 4))
    for i, row in enumerate(GRID):
        for j, place in enumerate(row):
            mesh.set_mesh_vertex((i, j), place)
    with space.add_mesh().edit_data() as data:
        data.vertices = [(9, 0, 0), (10, 0, 0), (10, 1, 0), (9, 1, 0.5)]
        data.faces = [[0, 1, 2], [0, 2, 3]]
    space.add_3dface([(20, 0, 0), (21, 0, 0), (21, 1, 0)])
    space.add_3dface([(30, 0, 0), (31, 0, 0), (31, 1, 0), (30, 1, 0)])
    space.add_3dface([(40, 0, 0), (41, 0, 0), (41, 1, 0)], dxfattribs={"invisible": 1})
    space.add_line((0, 0, 0), (1, 1, 1))
    add_solid(space)
    doc.saveas(path, fmt="bin" if binary else "asc")
    return path


@pytest.mark.parametrize("binary", [False, True])
def test_all_dxf_face_entities_are_read(tmp_path: Path, binary: bool) -> None:
    found = read_model(drawing(tmp_path / "faces.dxf", binary=binary))
    assert isinstance(found.data, Mesh)
    # 1 + 2 of the pyramid, 2 x 6 of the grid, 2 of the mesh, 1 + 2 faces.
    assert len(found.data.faces) == 3 + 12 + 2 + 3
    corners = found.data.vertices[found.data.faces]
    area = np.linalg.norm(
        np.cross(*(corners[:, [1, 2]] - corners[:, :1]).transpose(1, 0, 2)), axis=1
    )
    assert (area > 0).all()
    assert found.units == ("mm", "mm", "mm")
    (left_out,) = found.warnings
    assert isinstance(left_out, Finding)
    assert left_out.code == "model.entities-left-out"
    assert left_out.values["entities"] == ("1 3DSOLID", "1 LINE", "1 hidden")


def test_drawing_without_faces_or_points_is_rejected_with_its_entities(tmp_path: Path) -> None:
    doc = ezdxf.new()
    add_solid(doc.modelspace())
    doc.saveas(tmp_path / "solid.dxf")
    with pytest.raises(InputError) as caught:
        read_model(tmp_path / "solid.dxf")
    assert caught.value.code == "model.no-entities"
    assert caught.value.values["entities"] == ("1 3DSOLID",)


@pytest.mark.parametrize("size", [3, 997, 60_000])
def test_the_size_of_the_blocks_does_not_matter(
    tmp_path: Path, size: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    from vomstudio.io.models.formats import dxf

    path = drawing(tmp_path / "faces.dxf")
    whole = read_model(path).data
    monkeypatch.setattr(dxf, "BLOCK_BYTES", size)
    parts = read_model(path).data
    assert isinstance(whole, Mesh)
    assert isinstance(parts, Mesh)
    assert (whole.vertices == parts.vertices).all()
    assert (whole.faces == parts.faces).all()


@pytest.mark.parametrize("line_end", [b"\r\n", b"\r"])
def test_other_line_ends_are_read(tmp_path: Path, line_end: bytes) -> None:
    path = drawing(tmp_path / "faces.dxf")
    other = tmp_path / "other.dxf"
    other.write_bytes(path.read_bytes().replace(b"\n", line_end))
    one, two = read_model(path).data, read_model(other).data
    assert isinstance(one, Mesh)
    assert isinstance(two, Mesh)
    assert (one.faces == two.faces).all()


@pytest.mark.parametrize("ending", [".dxf", ".shp"])
def test_truncated_and_damaged_files_raise_input_error(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"whole{ending}"
    write_model(cloud(), None, path)
    whole = path.read_bytes()
    rng = np.random.default_rng(1)
    for number in range(60):
        data = bytearray(whole[: int(rng.integers(1, len(whole)))])
        for at in rng.integers(0, len(data), number % 5).tolist():
            data[at] = int(rng.integers(0, 256))
        bent = tmp_path / f"bent{number}{ending}"
        bent.write_bytes(bytes(data))
        with contextlib.suppress(InputError):
            assert len(read_model(bent).data.bounds) == 2


# --- shapefiles of other programs ---------------------------------------------------------------


def shapefile(path: Path, kind: int, *contents: bytes) -> Path:
    records = b"".join(
        struct.pack(">2i", number, len(content) // 2) + content
        for number, content in enumerate(contents, 1)
    )
    size = (100 + len(records)) // 2
    head = struct.pack(">7i", 9994, 0, 0, 0, 0, 0, size) + struct.pack(
        "<2i8d", 1000, kind, *[0.0] * 8
    )
    path.write_bytes(head + records)
    return path


def patch(parts: list[tuple[int, list[tuple[float, float, float]]]]) -> bytes:
    points = np.array([p for _, part in parts for p in part], np.float64)
    starts = np.cumsum([0, *[len(part) for _, part in parts]])[:-1]
    return (
        struct.pack("<i4d2i", 31, 0, 0, 0, 0, len(parts), len(points))
        + np.asarray(starts, "<i4").tobytes()
        + np.array([kind for kind, _ in parts], "<i4").tobytes()
        + points[:, :2].astype("<f8").tobytes()
        + struct.pack("<2d", 0, 0)
        + points[:, 2].astype("<f8").tobytes()
    )


def test_multipatch_faces_are_read(tmp_path: Path) -> None:
    strip = [(0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0)]
    fan = [(5.0, 5.0, 0.0), (6.0, 5.0, 0.0), (6.0, 6.0, 0.0), (5.0, 6.0, 0.0), (4.0, 6.0, 1.0)]
    ring = [(8.0, 8.0, 0.0), (9.0, 8.0, 0.0), (9.0, 9.0, 0.0), (8.0, 8.0, 0.0)]
    star = [(float(k), float(k % 2), 0.0) for k in range(7)]
    path = shapefile(tmp_path / "p.shp", 31, patch([(0, strip), (1, fan), (2, ring), (5, star)]))
    found = read_model(path)
    assert isinstance(found.data, Mesh)
    assert len(found.data.faces) == 2 + 3 + 1
    corners = found.data.vertices[found.data.faces]
    up = np.cross(corners[:2, 1] - corners[:2, 0], corners[:2, 2] - corners[:2, 0])[:, 2]
    # Both triangles of the strip face the same side.
    assert (up < 0).all()
    (left_out,) = found.warnings
    assert isinstance(left_out, Finding)
    assert (left_out.code, left_out.values["count"]) == ("model.rings-left-out", 1)


def test_multipoint_records_are_read_and_null_shapes_skipped(tmp_path: Path) -> None:
    places = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    several = (
        struct.pack("<i4di", 18, 0, 0, 0, 0, 2)
        + places[:, :2].tobytes()
        + struct.pack("<2d", 0, 0)
        + places[:, 2].tobytes()
    )
    path = shapefile(tmp_path / "p.shp", 18, struct.pack("<i", 0), several)
    found = read_model(path).data
    assert isinstance(found, PointCloud)
    assert found.points.tolist() == places.tolist()


def test_line_shapefile_is_rejected_with_its_shape_type(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        read_model(shapefile(tmp_path / "l.shp", 13))
    assert caught.value.code == "model.other-shapes"
    assert caught.value.values["shapes"] == "lines"


def test_describe_reports_the_units_of_a_drawing(tmp_path: Path) -> None:
    answer = describe(drawing(tmp_path / "faces.dxf"))
    assert answer["units"] == ["mm", "mm", "mm"]
    assert "model.entities-left-out" in codes(answer)
