"""STL: both forms, joined corners, origins, damage."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from tests.messages import by_code
from vomstudio.core.errors import InputError
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.opening import read_model


def sphere(folder: Path, kind: str) -> tuple[Path, trimesh.Trimesh]:
    ball = trimesh.creation.icosphere(subdivisions=2, radius=3.0)
    path = folder / "ball.stl"
    path.write_bytes(
        ball.export(file_type=kind) if kind == "stl" else ball.export(file_type=kind).encode()
    )
    return path, ball


def mesh_of(path: Path) -> tuple[Mesh, dict[str, dict[str, Any]]]:
    loaded = read_model(path)
    assert isinstance(loaded.data, Mesh)
    return loaded.data, by_code(loaded.warnings)


@pytest.mark.parametrize("kind", ["stl", "stl_ascii"])
def test_trimesh_export_is_read_and_vertices_are_merged(tmp_path: Path, kind: str) -> None:
    path, ball = sphere(tmp_path, kind)
    mesh, findings = mesh_of(path)
    assert findings == {}
    assert np.allclose(mesh.vertices[mesh.faces], ball.triangles, atol=1e-6)
    assert len(mesh.vertices) == len(ball.vertices)


def test_a_binary_file_may_begin_with_solid(tmp_path: Path) -> None:
    path, ball = sphere(tmp_path, "stl")
    path.write_bytes(b"solid facet" + bytes(69) + path.read_bytes()[80:])
    assert len(mesh_of(path)[0].faces) == len(ball.faces)


def test_offset_file_origin_is_added_in_float64(tmp_path: Path) -> None:
    path, _ = sphere(tmp_path, "stl")
    bare = mesh_of(path)[0].vertices
    (tmp_path / "ball.offset.txt").write_text(
        "EPSG:32615; World = (x, y, z) + offset 576000 5188000 0"
    )
    loaded = read_model(path)
    assert isinstance(loaded.data, Mesh)
    assert np.array_equal(loaded.data.vertices, bare + [576000, 5188000, 0])
    assert loaded.crs == "EPSG:32615"


def test_truncated_file_gives_its_faces_with_a_warning(tmp_path: Path) -> None:
    for kind in ("stl", "stl_ascii"):
        path, ball = sphere(tmp_path, kind)
        content = path.read_bytes()
        path.write_bytes(content[: len(content) // 2])
        mesh, findings = mesh_of(path)
        assert 0.4 * len(ball.faces) < len(mesh.faces) < 0.6 * len(ball.faces)
        assert findings.keys() & {"model.incomplete", "model.maybe-cut-short"}


def test_missing_vertex_line_loses_only_one_face(tmp_path: Path) -> None:
    path, ball = sphere(tmp_path, "stl_ascii")
    lines = path.read_text().splitlines()
    del lines[next(i for i, line in enumerate(lines) if "vertex" in line)]
    path.write_text("\n".join(lines))
    mesh, findings = mesh_of(path)
    assert findings["model.faces-incomplete"] == {"count": 1}
    assert np.allclose(mesh.vertices[mesh.faces], ball.triangles[1:], atol=1e-6)


def test_non_numeric_coordinates_lose_only_their_faces(tmp_path: Path) -> None:
    path = tmp_path / "a.stl"
    loop = (
        "facet normal 0 0 1\nouter loop\nvertex 0 0 {}\nvertex 1 0 0\nvertex 0 1 0\n"
        "endloop\nendfacet\n"
    )
    path.write_text("solid a\n" + loop.format("0") + loop.format("up") + "endsolid a\n")
    mesh, findings = mesh_of(path)
    assert len(mesh.faces) == 1
    assert "model.points-invalid" in findings


def test_excessive_face_count_is_ignored(tmp_path: Path) -> None:
    path, ball = sphere(tmp_path, "stl")
    content = bytearray(path.read_bytes())
    struct.pack_into("<I", content, 80, 2**32 - 1)
    path.write_bytes(content)
    mesh, findings = mesh_of(path)
    assert len(mesh.faces) == len(ball.faces)
    assert "model.incomplete" in findings


@pytest.mark.parametrize(
    "content", [b"s", b"solid\n", b"\0" * 84, b"solid x\nendsolid x\n", b"?" * 90]
)
def test_file_that_is_not_a_mesh_is_rejected_by_name(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a.stl"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"a\.stl"):
        read_model(path)


@pytest.mark.parametrize("kind", ["stl", "stl_ascii"])
def test_damaged_file_gives_model_or_input_error(tmp_path: Path, kind: str) -> None:
    content = sphere(tmp_path, kind)[0].read_bytes()[:4000]
    path = tmp_path / "bad.stl"
    rng = np.random.default_rng(6)
    for _ in range(150):
        bad = bytearray(content[: rng.integers(1, len(content))])
        for at in rng.integers(0, len(bad), 3):
            bad[at] = rng.integers(0, 256)
        path.write_bytes(bad)
        try:
            read_model(path)
        except InputError:
            continue


def test_long_numbers_keep_their_exponent(tmp_path: Path) -> None:
    number = "1." + "0" * 31 + "e5"
    huge = "2." + "0" * 100 + "e-3"
    text = f"solid a\nfacet normal 0 0 1\nouter loop\nvertex {number} 0 {huge}\n"
    text += "vertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n"
    path = tmp_path / "a.stl"
    for content in (text, text.replace(huge, "0")):
        path.write_text(content)
        mesh, findings = mesh_of(path)
        assert findings == {}
        assert mesh.vertices[0].tolist() == [float(number), 0, 0.002 if huge in content else 0]


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be", "utf-8-sig"])
def test_text_of_another_encoding_is_read(tmp_path: Path, encoding: str) -> None:
    path, ball = sphere(tmp_path, "stl_ascii")
    mark = "\ufeff" if encoding == "utf-16-be" else ""
    path.write_bytes((mark + path.read_text()).encode(encoding))
    mesh, _ = mesh_of(path)
    assert mesh.vertices[mesh.faces].shape == ball.triangles.shape


@pytest.mark.parametrize("size", [80, 131, 400, 4096])
def test_blockwise_ascii_read_gives_the_same_mesh(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, size: int
) -> None:
    from vomstudio.io.models.formats import stl

    path, made = sphere(tmp_path, "stl_ascii")
    # Words of a loop on two lines, and a stretch without corners that is longer than a piece.
    text = path.read_text().replace("outer loop", "outer\nloop", 40)
    words = text.split("facet", 30)
    path.write_text("facet".join(words[:30]) + " " * 3000 + "facet" + words[30])
    whole, _ = mesh_of(path)
    monkeypatch.setattr(stl, "BLOCK_BYTES", size)
    monkeypatch.setattr(stl, "LOOK_BACK_BYTES", size)
    pieces, _ = mesh_of(path)
    assert len(whole.faces) == len(made.faces)
    assert np.array_equal(whole.vertices, pieces.vertices)
    assert np.array_equal(whole.faces, pieces.faces)
