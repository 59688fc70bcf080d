"""Files whose few bytes stand for much: refused before it is made, or read within bounds."""

from __future__ import annotations

import json
import os
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.messages import by_code, refused
from vomstudio.core.progress import SilentProgress
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.gis.crs import sidecar_crs
from vomstudio.io.models.opening import MAX_FIELDS, read_model
from vomstudio.io.text.rows import read_rows
from vomstudio.io.text.xml_tree import read_xml

MAX_BYTES = 400 << 20
"""Of numpy's arrays at once, for files below a megabyte. The attacks took gigabytes."""


def glb(path: Path, scene: dict[str, Any], binary: bytes) -> Path:
    text = json.dumps(scene | {"asset": {"version": "2.0"}}).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text
    body += struct.pack("<II", len(binary), 0x004E4942) + binary
    path.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body)
    return path


def scene(vertices: int, faces: int) -> tuple[dict[str, Any], bytes]:
    """One mesh of random triangles."""
    chance = np.random.default_rng(1)
    positions = chance.random((vertices, 3)).astype("<f4").tobytes()
    corners = chance.integers(0, vertices, 3 * faces).astype("<u2").tobytes()
    views = [
        {"buffer": 0, "byteLength": len(positions)},
        {"buffer": 0, "byteOffset": len(positions), "byteLength": len(corners)},
    ]
    accessors = [
        {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": vertices},
        {"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": 3 * faces},
    ]
    meshes = [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]
    whole = {"bufferViews": views, "accessors": accessors, "meshes": meshes}
    buffers = {"buffers": [{"byteLength": len(positions) + len(corners)}]}
    return whole | buffers, positions + corners


@pytest.fixture
def measured(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The most that Python and numpy have held at once since it was asked for."""
    import tracemalloc

    tracemalloc.start()
    yield lambda: tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()


@pytest.mark.full
def test_mesh_instanced_thousands_of_times_is_rejected_within_memory_limit(
    tmp_path: Path, measured: Any
) -> None:
    made, binary = scene(20_000, 20_000)
    made["nodes"] = [{"mesh": 0}] * 3_000
    with refused("file.inflated"):
        read_model(glb(tmp_path / "a.glb", made, binary))
    assert measured() < MAX_BYTES
    made["nodes"] = [{"mesh": 0}] * 30
    found = read_model(glb(tmp_path / "b.glb", made, binary)).data
    assert isinstance(found, Mesh)
    assert len(found.faces) == 600_000


def test_accessors_without_bytes_are_rejected(tmp_path: Path, measured: Any) -> None:
    place = {"bufferView": 0, "componentType": 5123}
    sparse = {"count": 1, "indices": place, "values": {"bufferView": 0}}
    empty = {"componentType": 5126, "type": "VEC3", "count": 49_000_000, "sparse": sparse}
    made = {
        "buffers": [{"byteLength": 16}],
        "bufferViews": [{"buffer": 0, "byteLength": 16}],
        "accessors": [empty],
        "meshes": [{"primitives": [{"mode": 0, "attributes": {"POSITION": 0}}]}],
    }
    with refused("file.inflated"):
        read_model(glb(tmp_path / "a.glb", made, b"\0" * 16))
    assert measured() < MAX_BYTES


def test_each_primitive_of_a_shared_buffer_is_a_progress_step(tmp_path: Path) -> None:
    class Counted(SilentProgress):
        steps = 0

        def step(self, done: int) -> None:
            Counted.steps += 1

    made, binary = scene(60_000, 20_000)
    made["accessors"] = made["accessors"][:1] + [
        {"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": 3, "byteOffset": 6 * i}
        for i in range(3_000)
    ]
    made["meshes"] = [
        {"primitives": [{"attributes": {"POSITION": 0}, "indices": 1 + i} for i in range(3_000)]}
    ]
    found = read_model(glb(tmp_path / "a.glb", made, binary), Counted()).data
    assert isinstance(found, Mesh)
    assert len(found.faces) == 3_000
    assert len(found.vertices) <= 9_000
    assert Counted.steps >= 3_000


@pytest.mark.parametrize("text", [True, False])
def test_ply_of_empty_lists_is_rejected_within_memory_limit(
    tmp_path: Path, measured: Any, text: bool
) -> None:
    count = 30_000_000
    head = (
        f"ply\nformat {'ascii' if text else 'binary_little_endian'} 1.0\nelement vertex 3\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {count}\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode()
    body = b"0 0 0\n1 0 0\n0 1 0\n" if text else np.eye(3, dtype="<f4").tobytes()
    path = tmp_path / "a.ply"
    path.write_bytes(head + body + (b"0\n" if text else b"\0") * count)
    with refused("file.inflated"):
        read_model(path)
    assert measured() < MAX_BYTES + 6 * path.stat().st_size


def test_ply_with_thousands_of_fields_is_limited(tmp_path: Path) -> None:
    names = "".join(f"property float p{i}\n" for i in range(5_000))
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex 3\n{names}"
    head += "property float x\nproperty float y\nproperty float z\nend_header\n"
    path = tmp_path / "a.ply"
    path.write_bytes(head.encode() + np.random.default_rng(1).random(15_009, np.float32).tobytes())
    found = read_model(path)
    assert len(found.data.fields) == MAX_FIELDS
    assert by_code(found.warnings)["model.fields-limited"]["count"] == 5_000


def test_obj_with_thousands_of_material_files_is_limited(tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    names = "".join(f"mtllib f{i}.mtl\n" for i in range(20_000))
    path.write_text(names + "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    found = read_model(path)
    assert len(found.warnings) < 200
    assert by_code(found.warnings)["material.too-many-files"]["count"] == 20_000


def test_excessive_xml_elements_and_empty_lines_are_rejected(tmp_path: Path) -> None:
    path = tmp_path / "a.xml"
    path.write_bytes(b"<document>" + b"<a/>" * 2_000_000 + b"</document>")
    with refused("file.too-many-parts", file=path):
        read_xml(path)
    path.write_bytes(b"\n" * 30_000_000 + b"strike,dip\n10,20\n")
    with refused("file.inflated", file=path):
        read_rows(path)


def test_special_files_beside_a_model_are_ignored(tmp_path: Path) -> None:
    model = tmp_path / "a.ply"
    model.write_text(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n0 0 0\n1 0 0\n0 1 0\n"
    )
    os.mkfifo(tmp_path / "a.prj")
    (tmp_path / "a.offset.txt").symlink_to("/dev/zero")
    cloud = read_model(model).data
    assert isinstance(cloud, PointCloud)
    assert len(cloud.points) == 3
    (tmp_path / "a.prj").unlink()
    (tmp_path / "a.prj").write_bytes(b"x" * 50_000_000)
    assert sidecar_crs(model)[0] is None
    os.mkfifo(tmp_path / "b.ply")
    with refused("file.not-regular"):
        read_model(tmp_path / "b.ply")
