"""Sound models and rasters of about so many bytes: what large ones cost in memory is not told by
small ones, nor by files that are refused."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.formats.dem import MAX_VERTICES
from vomstudio.io.models.writing import write_model

Array = npt.NDArray[Any]
_ROWS = 100_000


def _surface(triangles: int) -> tuple[Array, Array]:
    """A rough sheet: vertices (n, 3) float64, faces (m, 3) int32."""
    n = int(np.sqrt(triangles / 2)) + 2
    x, z = np.meshgrid(np.linspace(0, 100, n), np.linspace(0, 60, n))
    y = np.random.default_rng(0).normal(0, 0.01, x.shape) + np.sin(x)
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate([np.stack([a, a + 1, a + n + 1], 1), np.stack([a, a + n + 1, a + n], 1)])
    return np.stack([x, y, z], -1).reshape(-1, 3), faces.astype("<i4")


def _ply_triangles(path: Path, size: int) -> int:
    return _ply(path, *_surface(size // 20))


def _ply_squares(path: Path, size: int) -> int:
    vertices, faces = _surface(size // 15)
    half = len(faces) // 2
    return _ply(path, vertices, np.column_stack([faces[:half], faces[half:, 2]]))


def _ply(path: Path, vertices: Array, corners: Array) -> int:
    """A binary one; corners (n, k)"""
    k = corners.shape[1]
    rows = np.zeros(len(corners), [("n", "u1"), ("i", "<i4", k)])
    rows["n"], rows["i"] = k, corners
    with open(path, "wb") as file:
        file.write(_ply_head("binary_little_endian", vertices, corners))
        vertices.astype("<f4").tofile(file)
        rows.tofile(file)
    return vertices.nbytes + 12 * (k - 2) * len(corners)


def _ply_head(form: str, vertices: Array, corners: Array) -> bytes:
    lines = ["ply", f"format {form} 1.0", f"element vertex {len(vertices)}"]
    lines += [f"property float {axis}" for axis in "xyz"]
    lines += [f"element face {len(corners)}", "property list uchar int vertex_indices"]
    return "\n".join([*lines, "end_header\n"]).encode()


def _ply_text(path: Path, size: int) -> int:
    vertices, faces = _surface(size // 36)
    with open(path, "wb") as file:
        file.write(_ply_head("ascii", vertices, faces))
        np.savetxt(file, vertices, "%.4f %.4f %.4f")
        np.savetxt(file, faces, "3 %d %d %d")
    return vertices.nbytes + faces.nbytes


def _cloud(path: Path, size: int) -> int:
    """By the program's own writer; LAZ of a quarter of the bytes."""
    points = np.random.default_rng(0).uniform(0, 100, (size // 27, 3))
    write_model(PointCloud(points, (2.5 * points).astype(np.uint8)), "EPSG:32632", path, force=True)
    return 27 * len(points)


def _mesh(path: Path, size: int) -> int:
    """Likewise."""
    vertices, faces = _surface(size // 38)
    write_model(Mesh(vertices, faces), "EPSG:32632", path, force=True)
    return vertices.nbytes + faces.nbytes


def _stl(path: Path, size: int) -> int:
    vertices, faces = _surface(size // 50)
    rows = np.zeros(len(faces), [("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    rows["v"] = vertices[faces]
    with open(path, "wb") as file:
        file.write(bytes(80) + struct.pack("<I", len(rows)))
        rows.tofile(file)
    return rows.nbytes


def _glb(path: Path, size: int) -> int:
    vertices, faces = _surface(size // 18)
    # No origin is stated, as it is by the program's own writer: which way is up is asked for.
    parts = [vertices.astype("<f4"), faces.astype("<u4")]
    content = sum(part.nbytes for part in parts)
    scene = {
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": content}],
        "bufferViews": [
            {"buffer": 0, "byteLength": parts[0].nbytes},
            {"buffer": 0, "byteOffset": parts[0].nbytes, "byteLength": parts[1].nbytes},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": faces.size, "type": "SCALAR"},
        ],
    }
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + content))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", content, b"BIN\0"))
        for part in parts:
            part.tofile(file)
    return content


def _xyz(path: Path, size: int) -> int:
    places = np.random.default_rng(0).uniform(0, 100, (_ROWS, 3)).tolist()
    rows = "".join(f"{x:.4f} {y:.4f} {z:.4f} 100 110 120\n" for x, y, z in places)
    times = size // len(rows) + 1
    with open(path, "w") as file:
        for _ in range(times):
            file.write(rows)
    return 27 * _ROWS * times


def _heights(path: Path, size: int) -> int:
    import rasterio

    n = int(np.sqrt(size / 4)) + 1
    heights = np.random.default_rng(0).normal(0, 0.01, (n, n)).astype(np.float32).cumsum(0)
    place = rasterio.transform.from_origin(5e5, 5e6, 0.5, 0.5)
    with rasterio.open(
        path, "w", "GTiff", n, n, 1, dtype="float32", crs="EPSG:32633", transform=place
    ) as file:
        file.write(heights, 1)
    # A mesh is made of it: of each point, of which there are no more, 24 bytes and two triangles.
    return 48 * min(heights.size, MAX_VERTICES)


MADE: Mapping[str, Sequence[Callable[[Path, int], int]]] = {
    "a.ply": (_ply_triangles, _ply_text, _ply_squares),
    "b.ply": (_cloud,),
    "b.las": (_cloud,),
    "b.laz": (_cloud,),
    "a.stl": (_stl,),
    "a.glb": (_glb,),
    "a.obj": (_mesh,),
    "b.xyz": (_xyz,),
    "c.tif": (_heights,),
}
"""By kind: write about so many bytes; how many they are once decoded, as points x fields."""
