"""The primitives of a glTF's scene, each in its place."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray, FloatArray, IntArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.models.formats._common import scale_colors
from vomstudio.io.models.formats._gltf_document import Document, numbers
from vomstudio.io.models.formats._gltf_materials import color_map, moved, uv_set

MAX_VERTICES = 200_000_000
# What Python itself keeps for each.
_PLACE_BYTES, _PRIMITIVE_BYTES = 400, 1000
POINTS, TRIANGLES, STRIP, FAN = 0, 4, 5, 6


@dataclass
class Piece:
    """One primitive in its place: positions (n, 3) float64, still Y-up; faces (m, 3) of whole
    numbers, as wide as the file has them, or None of points; the rest per vertex."""

    positions: FloatArray
    faces: AnyArray | None
    material: int
    uv: AnyArray | None = None
    colors: AnyArray | None = None
    normals: AnyArray | None = None
    fields: dict[str, AnyArray] = field(default_factory=dict)


def pieces_of(document: Document, messages: list[Finding]) -> Iterator[Piece]:
    placed = []
    for place in _placed_meshes(document, messages):
        document.budget.take(_PLACE_BYTES, "nodes")
        placed.append(place)
    uses: dict[object, int] = {}
    steps = 0
    for index, _, _ in placed:
        primitives = _primitives(document, index)
        steps += len(primitives)
        document.budget.take(_PRIMITIVE_BYTES * len(primitives), "meshes")
        for primitive in primitives:
            key = document.section("attributes", primitive).get("POSITION")
            uses[_key(key)] = uses.get(_key(key), 0) + 1
    total = lines = done = 0
    progress = document.progress
    progress.stage(tr("Reading the scene"), steps)
    for index, matrix, weights in placed:
        for primitive in _primitives(document, index):
            progress.step(done)
            done += 1
            mode = primitive.get("mode", TRIANGLES)
            if mode in (1, 2, 3):
                lines += 1
                continue
            key = document.section("attributes", primitive).get("POSITION")
            shared = uses[_key(key)] > 1
            piece = _piece(document, primitive, matrix, weights, shared, messages)
            total += len(piece.positions)
            if total > MAX_VERTICES:
                raise InputError(
                    Finding("model.too-many-elements", limit=MAX_VERTICES), file=document.path
                )
            if len(piece.positions):
                yield piece
    progress.step(steps)
    if lines:
        messages.append(Finding("model.lines-left-out", count=lines))


def _key(index: object) -> object:
    return index if isinstance(index, int) else None


def _primitives(document: Document, mesh: object) -> list[dict[str, Any]]:
    found = document.item("meshes", mesh).get("primitives")
    return [p for p in found if isinstance(p, dict)] if isinstance(found, list) else []


def _placed_meshes(
    document: Document, messages: list[Finding]
) -> Iterator[tuple[object, AnyArray, object]]:
    """Each mesh of the scene with the 4x4 matrix of its place, and the weights of its shapes."""
    n = document.count("nodes")
    if n == 0:
        for mesh in range(document.count("meshes")):
            yield mesh, np.eye(4), document.item("meshes", mesh).get("weights")
        return
    if document.count("scenes"):
        scene = document.item("scenes", document.json.get("scene", 0))
        roots = scene.get("nodes", [])
    else:
        below = {c for i in range(n) for c in _children(document, i) if isinstance(c, int)}
        roots = [i for i in range(n) if i not in below]
    if not isinstance(roots, list):
        raise document.wrong(tr("'nodes' is not a list"), "scenes")
    seen: set[int] = set()
    waiting: list[tuple[object, AnyArray]] = [(node, np.eye(4)) for node in reversed(roots)]
    while waiting:
        index, above = waiting.pop()
        node = document.item("nodes", index)
        assert isinstance(index, int)
        if index in seen:
            raise document.wrong(tr("a node has two parents or contains itself"), f"nodes[{index}]")
        seen.add(index)
        matrix = above @ _local_matrix(document, node, index)
        if "skin" in node:
            messages.append(Finding("model.pose-unused"))
        for name in document.section("extensions", node):
            reason = Finding("model.extension-unsupported", extension=name)
            if not document.is_understood(name) and reason not in messages:
                messages.append(reason)
        if "mesh" in node:
            weights = node.get("weights", document.item("meshes", node["mesh"]).get("weights"))
            for place in _instances(document, node, index):
                yield node["mesh"], matrix @ place, weights
        waiting.extend((child, matrix) for child in reversed(_children(document, index)))


def _children(document: Document, index: int) -> list[Any]:
    found = document.item("nodes", index).get("children", [])
    return found if isinstance(found, list) else []


def _instances(document: Document, node: dict[str, Any], index: int) -> Iterator[AnyArray]:
    """The 4x4 places of a node's mesh within the node (EXT_mesh_gpu_instancing); one, the node's
    own, where it is not repeated."""
    repeated = document.section("extensions", node).get("EXT_mesh_gpu_instancing")
    if not isinstance(repeated, dict):
        yield np.eye(4)
        return
    attributes = document.section("attributes", repeated)
    widths = {"translation": 3, "rotation": 4, "scale": 3}
    found = {
        name: document.accessor(attributes[name.upper()], width).astype(np.float64)
        for name, width in widths.items()
        if name.upper() in attributes
    }
    counts = {len(values) for values in found.values()}
    if len(counts) > 1:
        raise document.wrong(tr("the instances have different counts"), f"nodes[{index}]")
    for row in range(counts.pop() if counts else 0):
        place = {name: values[row].tolist() for name, values in found.items()}
        yield _local_matrix(document, place, index)


def _rows_used(faces: AnyArray, n: int) -> tuple[IntArray, IntArray]:
    """Which of n vertices faces use, and the faces by their places among these."""
    if 8 * faces.size < n:
        # Thousands of small pieces may be cut out of one large buffer.
        rows, inverse = np.unique(faces, return_inverse=True)
        return rows, inverse.reshape(faces.shape)
    used = np.zeros(n, bool)
    used[faces] = True
    return np.flatnonzero(used), (np.cumsum(used) - 1)[faces]


def _shaped(
    document: Document, primitive: dict[str, Any], stored: AnyArray, rows: Any, weights: object
) -> FloatArray:
    """Positions with the shapes of the mesh (morph targets) at their weights; without weights they
    are as they stand (glTF 2.0, 3.7.2.2)."""
    positions: FloatArray = stored[rows].astype(np.float64)
    targets = primitive.get("targets")
    if not isinstance(targets, list) or not targets or weights is None:
        return positions
    shares = numbers(document, weights, len(targets), "weights")
    for share, target in zip(shares.tolist(), targets, strict=True):
        if share and isinstance(target, dict) and "POSITION" in target:
            moves = document.accessor(target["POSITION"], 3)
            if len(moves) != len(stored):
                raise document.wrong(
                    tr(
                        "it has {count:,} rows for {vertices:,} vertices",
                        count=len(moves),
                        vertices=len(stored),
                    ),
                    "targets",
                )
            positions += share * moves[rows].astype(np.float64)
    return positions


def _local_matrix(document: Document, node: dict[str, Any], index: int) -> AnyArray:
    place = f"nodes[{index}]"
    if "matrix" in node:
        return numbers(document, node["matrix"], 16, place).reshape(4, 4).T
    matrix = np.eye(4)
    if "rotation" in node:
        x, y, z, w = numbers(document, node["rotation"], 4, place)
        length = np.sqrt(x * x + y * y + z * z + w * w)
        if not length > 0:
            raise document.wrong(tr("the rotation is not valid"), place)
        x, y, z, w = np.array([x, y, z, w]) / length
        matrix[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    if "scale" in node:
        matrix[:3, :3] *= numbers(document, node["scale"], 3, place)
    if "translation" in node:
        matrix[:3, 3] = numbers(document, node["translation"], 3, place)
    return matrix


def _piece(
    document: Document,
    primitive: dict[str, Any],
    matrix: AnyArray,
    weights: object,
    shared: bool,
    messages: list[Finding],
) -> Piece:
    attributes = document.section("attributes", primitive)
    if "POSITION" not in attributes:
        return Piece(np.empty((0, 3)), None, -1)
    stored = document.accessor(attributes["POSITION"], 3)
    mode = primitive.get("mode", TRIANGLES)
    faces = None
    if mode != POINTS:
        faces = _faces(document, primitive, mode, len(stored), messages)
    material = primitive.get("material", -1)
    if material != -1:
        document.item("materials", material)
    rows: Any = slice(None)
    if faces is not None and shared:
        # One large buffer cut into many primitives: each takes only what it needs.
        rows, faces = _rows_used(faces, len(stored))
    document.budget.take(24 * (len(stored) if isinstance(rows, slice) else len(rows)), "meshes")
    positions = _shaped(document, primitive, stored, rows, weights)
    if not np.array_equal(matrix, np.eye(4)):
        positions = positions @ matrix[:3, :3].T + matrix[:3, 3]
        if faces is not None and np.linalg.det(matrix[:3, :3]) < 0:
            faces = faces[:, ::-1]
    piece = Piece(positions, faces, material)
    n = len(stored)

    def values(name: str, *widths: int) -> AnyArray | None:
        if name not in attributes:
            return None
        found = document.accessor(attributes[name], *widths)
        if len(found) != n:
            raise document.wrong(
                tr("it has {count:,} rows for {vertices:,} vertices", count=len(found), vertices=n),
                name,
            )
        taken = np.asarray(found[rows])
        document.budget.take(taken.nbytes, name)
        return taken

    texture = color_map(document, material)
    piece.uv = values(f"TEXCOORD_{uv_set(document, texture)}", 2)
    if piece.uv is not None:
        piece.uv = moved(document, piece.uv.astype(np.float64), texture)
    colors = values("COLOR_0", 3, 4)
    if colors is not None:
        piece.colors = scale_colors(np.ascontiguousarray(colors[:, :3]))
    if faces is None:
        piece.normals = values("NORMAL", 3)
        if piece.normals is not None:
            # Directions: right for rotations and even scales, which is what clouds come with.
            piece.normals = piece.normals @ matrix[:3, :3].T
    for name in attributes:
        if not name.startswith("_"):
            continue
        found = values(name, 1, 2, 3, 4)
        assert found is not None
        for j in range(found.shape[1]):
            label = name[1:] if found.shape[1] == 1 else f"{name[1:]} {j + 1}"
            piece.fields[label] = np.ascontiguousarray(found[:, j])
    return piece


def _faces(
    document: Document, primitive: dict[str, Any], mode: object, n: int, messages: list[Finding]
) -> AnyArray:
    corners: AnyArray
    if "indices" in primitive:
        corners = document.accessor(primitive["indices"], 1)[:, 0]
        if corners.dtype.kind != "u":
            raise document.wrong(tr("the indices are not whole numbers"), "primitives")
        document.budget.take(8 * len(corners), "primitives")
    else:
        document.budget.take(8 * n, "primitives")
        corners = np.arange(n)
    if mode == TRIANGLES:
        faces = corners[: len(corners) // 3 * 3].reshape(-1, 3)
    elif mode in (STRIP, FAN):
        if len(corners) < 3:
            return np.empty((0, 3), corners.dtype)
        document.budget.take(16 * len(corners), "primitives")
        second, third = corners[1:-1], corners[2:]
        if mode == FAN:
            first = np.broadcast_to(corners[0], second.shape)
            faces = np.stack([first, second, third], axis=1)
        else:
            faces = np.stack([corners[:-2], second, third], axis=1)
            faces[1::2] = faces[1::2, ::-1]
    else:
        raise document.wrong(tr("'{mode}' is not a kind of primitive", mode=mode), "primitives")
    if len(faces) and faces.max() >= n:
        sound: AnyArray = np.asarray((faces < n).all(axis=1))
        bad = int(len(sound) - np.count_nonzero(sound))
        messages.append(Finding("model.faces-without-vertices", count=bad))
        faces = faces[sound]
    return faces
