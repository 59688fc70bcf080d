"""A piece of a model as a model of its own."""

from __future__ import annotations

import json

import numpy as np
from PIL import Image

from tests.messages import refused
from vomstudio.core.errors import GeometryError
from vomstudio.core.progress import SilentProgress
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.io.models.opening import read_model
from vomstudio.io.models.piece_writing import extract_piece, write_piece
from vomstudio.io.models.reader import LoadedModel


def two_materials(folder) -> Mesh:
    """Four triangles, two of each of two textures, and one of a material of which none is taken."""
    for name, grey in (("a", 50), ("b", 200), ("c", 90)):
        Image.new("L", (4, 4), grey).save(folder / f"{name}.png")
    x, z = np.meshgrid(np.arange(6.0), np.arange(2.0))
    vertices = np.stack([x.ravel(), 0.0 * x.ravel(), z.ravel()], axis=1) + [4e5, 4e6, 500.0]
    faces = np.array([[k, k + 1, k + 6] for k in range(5)], np.int32)
    uv = np.stack([x.ravel() / 5.0, z.ravel()], axis=1).astype(np.float32)
    materials = tuple(Material(n, folder / f"{n}.png") for n in "abc")
    return Mesh(
        vertices,
        faces,
        materials,
        np.array([0, 2, 4, 5]),
        uv,
        fields={"height": vertices[:, 2].copy()},
    )


def loaded(data, path) -> LoadedModel:
    kind = "mesh" if isinstance(data, Mesh) else "cloud"
    return LoadedModel(data, kind, None, (), path, "hash")


def written(data, mask, tmp_path, name="A piece: 1", crs=None):
    bits = np.packbits(np.asarray(mask, bool))
    source = tmp_path / "cliff.obj"
    given = loaded(data, source), bits, source, "hash", crs, tmp_path / "models", name
    return write_piece(*given, SilentProgress())


def test_a_piece_keeps_textures_coordinates_and_fields(tmp_path):
    mesh = two_materials(tmp_path)
    path, findings = written(mesh, [False, True, False, True, False], tmp_path)
    assert path.parent.parent == tmp_path / "models"
    back = read_model(path).data
    wanted = mesh.faces[[1, 3]]
    assert np.array_equal(back.vertices[back.faces], mesh.vertices[wanted])
    assert np.allclose(back.uv[back.faces], mesh.uv[wanted])
    assert np.array_equal(back.fields["height"][back.faces], mesh.fields["height"][wanted])
    assert [np.asarray(Image.open(m.texture)).ravel()[0] for m in back.materials] == [50, 200]
    assert back.material_offsets.tolist() == [0, 1, 2]
    facts = json.loads(next(path.parent.glob("*.piece.json")).read_text())
    assert facts["piece_of"] == "cliff.obj"
    assert facts["content_hash"] == "hash"
    assert (facts["element"], facts["count"], facts["of"]) == ("face", 2, 5)
    assert findings == []
    # Once more goes beside it.
    again, _ = written(mesh, [True, True, True, True, True], tmp_path)
    assert again.parent != path.parent
    assert not list((tmp_path / "models").glob("*.part"))


def test_a_material_of_plain_colour_is_kept(tmp_path):
    mesh = two_materials(tmp_path)
    plain = (Material("red", None, (1.0, 0.0, 0.0)), *mesh.materials[1:])
    mesh = Mesh(mesh.vertices, mesh.faces, plain, mesh.material_offsets, mesh.uv)
    path, _ = written(mesh, [True, False, True, False, False], tmp_path)
    back = read_model(path).data
    assert path.suffix == ".obj"
    assert back.materials[0].diffuse == (1.0, 0.0, 0.0)
    assert back.materials[1].texture is not None


def test_points_keep_colours_normals_and_fields(tmp_path):
    rng = np.random.default_rng(0)
    cloud = PointCloud(
        rng.random((50, 3)) + [4e5, 4e6, 500.0],
        rng.integers(0, 256, (50, 3)).astype(np.uint8),
        rng.normal(size=(50, 3)).astype(np.float32),
        {"intensity": np.arange(50, dtype=np.uint16)},
    )
    mask = np.arange(50) % 3 == 0
    path, _ = written(cloud, mask, tmp_path, crs="EPSG:32633")
    read = read_model(path)
    assert read.crs == "EPSG:32633"
    assert np.array_equal(read.data.points, cloud.points[mask])
    assert np.array_equal(read.data.colors, cloud.colors[mask])
    assert np.array_equal(read.data.normals, cloud.normals[mask])
    assert np.array_equal(read.data.fields["intensity"], cloud.fields["intensity"][mask])


def test_invalid_selection_is_rejected_and_leaves_no_files(tmp_path):
    mesh = two_materials(tmp_path)
    with refused("model.empty-selection", GeometryError):
        written(mesh, [False] * 5, tmp_path)
    with refused("model.other-selection", GeometryError, selected=4, count=5):
        extract_piece(mesh, np.ones(4, bool))
    other = LoadedModel(mesh, "mesh", None, (), tmp_path / "cliff.obj", "another")
    with refused("model.file-changed"):
        write_piece(
            other,
            np.packbits(np.ones(5, bool)),
            tmp_path / "cliff.obj",
            "hash",
            None,
            tmp_path / "models",
            "x",
            SilentProgress(),
        )
    assert not (tmp_path / "models").exists() or not list((tmp_path / "models").iterdir())


def test_a_mesh_without_materials_has_none():
    mesh = Mesh(np.random.default_rng(0).random((9, 3)), np.arange(9, dtype=np.int32).reshape(3, 3))
    piece = extract_piece(mesh, np.array([True, False, True]))
    assert piece.materials == ()
    assert len(piece.vertices) == 6
    assert piece.faces.tolist() == [[0, 1, 2], [3, 4, 5]]
