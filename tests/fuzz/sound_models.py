"""Sound models and rasters of about so many bytes: what large ones cost in memory is not told by
small ones, nor by files that are refused."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import numpy.typing as npt

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


def _points(n: int) -> Array:
    return np.random.default_rng(0).uniform(0, 100, (n, 3))


def _ply_mesh(path: Path, size: int) -> int:
    vertices, faces = _surface(size // 20)
    rows = np.zeros(len(vertices), [("p", "<f4", 3), ("c", "u1", 3)])
    rows["p"], rows["c"] = vertices, 128
    listed = np.zeros(len(faces), [("n", "u1"), ("i", "<i4", 3)])
    listed["n"], listed["i"] = 3, faces
    with open(path, "wb") as file:
        listing = [f"element face {len(faces)}", "property list uchar int vertex_indices"]
        file.write(_ply_head(len(rows), "float", listing))
        rows.tofile(file)
        listed.tofile(file)
    return 27 * len(vertices) + 12 * len(faces)


def _ply_text(path: Path, size: int) -> int:
    vertices, faces = _surface(size // 36)
    with open(path, "w") as file:
        file.write("ply\nformat ascii 1.0\n" + f"element vertex {len(vertices)}\n")
        file.writelines(f"property float {axis}\n" for axis in "xyz")
        file.write(f"element face {len(faces)}\nproperty list uchar int vertex_indices\n")
        file.write("end_header\n")
        np.savetxt(file, vertices, "%.4f %.4f %.4f")
        np.savetxt(file, faces, "3 %d %d %d")
    return vertices.nbytes + faces.nbytes


def _ply_squares(path: Path, size: int) -> int:
    vertices, faces = _surface(size // 15)
    half = len(faces) // 2
    rows = np.zeros(len(vertices), [("p", "<f4", 3), ("c", "u1", 3)])
    rows["p"], rows["c"] = vertices, 128
    listed = np.zeros(half, [("n", "u1"), ("i", "<i4", 4)])
    listed["n"], listed["i"][:, :3], listed["i"][:, 3] = 4, faces[:half], faces[half:, 2]
    with open(path, "wb") as file:
        listing = [f"element face {half}", "property list uchar int vertex_indices"]
        file.write(_ply_head(len(rows), "float", listing))
        rows.tofile(file)
        listed.tofile(file)
    return 27 * len(vertices) + 24 * half


def _ply_cloud(path: Path, size: int) -> int:
    rows = np.zeros(size // 27, [("p", "<f8", 3), ("c", "u1", 3)])
    rows["p"], rows["c"] = _points(len(rows)), 100
    with open(path, "wb") as file:
        file.write(_ply_head(len(rows), "double"))
        rows.tofile(file)
    return rows.nbytes


def _ply_head(rows: int, kind: str, more: Sequence[str] = ()) -> bytes:
    columns = [f"property {kind} {axis}" for axis in "xyz"]
    columns += [f"property uchar {name}" for name in ("red", "green", "blue")]
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {rows}", *columns]
    return "\n".join([*head, *more, "end_header\n"]).encode()


def _las(path: Path, size: int) -> int:
    """LAZ of a quarter of the bytes."""
    header = laspy.LasHeader(version="1.2", point_format=3)
    header.scales = np.full(3, 0.001)
    points = laspy.LasData(header)
    places = _points(size // 34)
    points.x, points.y, points.z = places.T
    points.red = points.green = points.blue = (places[:, 0] * 600).astype(np.uint16)
    points.write(str(path))
    return 34 * len(places)


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
    parts = [vertices.astype("<f4"), faces.astype("<u4")]
    scene = {
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": sum(part.nbytes for part in parts)}],
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
    content = sum(part.nbytes for part in parts)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + content))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", content, b"BIN\0"))
        for part in parts:
            part.tofile(file)
    return content


def _obj(path: Path, size: int) -> int:
    vertices, faces = _surface(size // 38)
    with open(path, "w") as file:
        np.savetxt(file, vertices, "v %.4f %.4f %.4f")
        np.savetxt(file, faces + 1, "f %d %d %d")
    return vertices.nbytes + faces.nbytes


def _xyz(path: Path, size: int) -> int:
    rows = "".join(f"{x:.4f} {y:.4f} {z:.4f} 100 110 120\n" for x, y, z in _points(_ROWS).tolist())
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
    return int(heights.nbytes)


MADE: Mapping[str, Sequence[Callable[[Path, int], int]]] = {
    "a.ply": (_ply_mesh, _ply_text, _ply_squares), "b.ply": (_ply_cloud,), "b.las": (_las,),
    "b.laz": (_las,), "a.stl": (_stl,), "a.glb": (_glb,), "a.obj": (_obj,), "b.xyz": (_xyz,),
    "c.tif": (_heights,),
}  # fmt: skip
"""By kind: write about so many bytes; how many they are once decoded, as points x fields."""
