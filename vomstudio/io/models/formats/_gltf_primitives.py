"""Primitives in the scene of a glTF file, each at its position."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray, FloatArray, IntArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.models.formats._common import to_uint8_colors
from vomstudio.io.models.formats._gltf_document import Document, numbers
from vomstudio.io.models.formats._gltf_materials import color_map, transform_uv, uv_set

MAX_VERTICES = 200_000_000
# Python overhead per primitive.
BYTES_PER_INSTANCE, BYTES_PER_PRIMITIVE = 400, 1000
POINTS, TRIANGLES, STRIP, FAN = 0, 4, 5, 6


@dataclass
class PlacedPrimitive:
    """Primitive at its position in the scene.

    Attributes
    ----------
    positions : (n, 3) float64
        Vertices, still with Y up.
    faces : (m, 3) array of int or None
        Faces with the integer width of the file, or None for points.

    Notes
    -----
    The other arrays contain one value per vertex.
    """

    positions: FloatArray
    faces: AnyArray | None
    material: int
    uv: AnyArray | None = None
    colors: AnyArray | None = None
    normals: AnyArray | None = None
    fields: dict[str, AnyArray] = field(default_factory=dict)


def read_primitives(document: Document, findings: list[Finding]) -> Iterator[PlacedPrimitive]:
    instances = []
    for instance in _placed_meshes(document, findings):
        document.budget.take(BYTES_PER_INSTANCE, "nodes")
        instances.append(instance)
    use_counts: dict[object, int] = {}
    steps = 0
    for index, _, _ in instances:
        primitives = _primitives(document, index)
        steps += len(primitives)
        document.budget.take(BYTES_PER_PRIMITIVE * len(primitives), "meshes")
        for primitive in primitives:
            accessor_index = document.section("attributes", primitive).get("POSITION")
            use_counts[_key(accessor_index)] = use_counts.get(_key(accessor_index), 0) + 1
    vertex_count = line_count = done_count = 0
    progress = document.progress
    progress.stage(tr("Reading the scene"), steps)
    for index, matrix, weights in instances:
        for primitive in _primitives(document, index):
            progress.step(done_count)
            done_count += 1
            mode = primitive.get("mode", TRIANGLES)
            if mode in (1, 2, 3):
                line_count += 1
                continue
            accessor_index = document.section("attributes", primitive).get("POSITION")
            is_shared = use_counts[_key(accessor_index)] > 1
            piece = _read_primitive(document, primitive, matrix, weights, is_shared, findings)
            vertex_count += len(piece.positions)
            if vertex_count > MAX_VERTICES:
                raise InputError(
                    Finding("model.too-many-elements", limit=MAX_VERTICES), file=document.path
                )
            if len(piece.positions):
                yield piece
    progress.step(steps)
    if line_count:
        findings.append(Finding("model.lines-left-out", count=line_count))


def _key(index: object) -> object:
    return index if isinstance(index, int) else None


def _primitives(document: Document, mesh: object) -> list[dict[str, Any]]:
    primitives = document.item("meshes", mesh).get("primitives")
    return (
        [primitive for primitive in primitives if isinstance(primitive, dict)]
        if isinstance(primitives, list)
        else []
    )


def _placed_meshes(
    document: Document, findings: list[Finding]
) -> Iterator[tuple[object, AnyArray, object]]:
    """Yield each mesh of the scene with its matrix (4, 4) and its morph weights."""
    n = document.count("nodes")
    if n == 0:
        for mesh in range(document.count("meshes")):
            yield mesh, np.eye(4), document.item("meshes", mesh).get("weights")
        return
    if document.count("scenes"):
        scene = document.item("scenes", document.json.get("scene", 0))
        roots = scene.get("nodes", [])
    else:
        child_nodes = {
            child for i in range(n) for child in _children(document, i) if isinstance(child, int)
        }
        roots = [i for i in range(n) if i not in child_nodes]
    if not isinstance(roots, list):
        raise document.error(tr("'nodes' is not a list"), "scenes")
    visited_nodes: set[int] = set()
    pending_nodes: list[tuple[object, AnyArray]] = [(node, np.eye(4)) for node in reversed(roots)]
    while pending_nodes:
        index, parent_matrix = pending_nodes.pop()
        node = document.item("nodes", index)
        assert isinstance(index, int)
        if index in visited_nodes:
            raise document.error(tr("a node has two parents or contains itself"), f"nodes[{index}]")
        visited_nodes.add(index)
        matrix = parent_matrix @ _local_matrix(document, node, index)
        if "skin" in node:
            findings.append(Finding("model.pose-unused"))
        for name in document.section("extensions", node):
            reason = Finding("model.extension-unsupported", extension=name)
            if not document.is_known_extension(name) and reason not in findings:
                findings.append(reason)
        if "mesh" in node:
            weights = node.get("weights", document.item("meshes", node["mesh"]).get("weights"))
            for instance_matrix in _instances(document, node, index):
                yield node["mesh"], matrix @ instance_matrix, weights
        pending_nodes.extend((child, matrix) for child in reversed(_children(document, index)))


def _children(document: Document, index: int) -> list[Any]:
    children = document.item("nodes", index).get("children", [])
    return children if isinstance(children, list) else []


def _instances(document: Document, node: dict[str, Any], index: int) -> Iterator[AnyArray]:
    """Yield the matrix (4, 4) of each instance of a node's mesh (EXT_mesh_gpu_instancing).

    The matrices are relative to the node. Without instancing, a single identity matrix is yielded.
    """
    instancing = document.section("extensions", node).get("EXT_mesh_gpu_instancing")
    if not isinstance(instancing, dict):
        yield np.eye(4)
        return
    attributes = document.section("attributes", instancing)
    widths = {"translation": 3, "rotation": 4, "scale": 3}
    attribute_values = {
        name: document.accessor(attributes[name.upper()], width).astype(np.float64)
        for name, width in widths.items()
        if name.upper() in attributes
    }
    counts = {len(values) for values in attribute_values.values()}
    if len(counts) > 1:
        raise document.error(
            tr("the attributes of the instances have different lengths"), f"nodes[{index}]"
        )
    for row in range(counts.pop() if counts else 0):
        transform = {name: values[row].tolist() for name, values in attribute_values.items()}
        yield _local_matrix(document, transform, index)


def _used_rows(faces: AnyArray, n: int) -> tuple[IntArray, IntArray]:
    """Return the rows of the vertices used by faces, and the faces with indices into them."""
    if 8 * faces.size < n:
        # Thousands of small pieces may share one large buffer.
        rows, inverse = np.unique(faces, return_inverse=True)
        return rows, inverse.reshape(faces.shape)
    is_used = np.zeros(n, bool)
    is_used[faces] = True
    return np.flatnonzero(is_used), (np.cumsum(is_used) - 1)[faces]


def _morphed_positions(
    document: Document,
    primitive: dict[str, Any],
    stored_positions: AnyArray,
    rows: Any,
    weights: object,
) -> FloatArray:
    """Return positions with weighted morph targets applied (glTF 2.0, 3.7.2.2)."""
    positions: FloatArray = stored_positions[rows].astype(np.float64)
    targets = primitive.get("targets")
    if not isinstance(targets, list) or not targets or weights is None:
        return positions
    target_weights = numbers(document, weights, len(targets), "weights")
    for target_weight, target in zip(target_weights.tolist(), targets, strict=True):
        if target_weight and isinstance(target, dict) and "POSITION" in target:
            displacements = document.accessor(target["POSITION"], 3)
            if len(displacements) != len(stored_positions):
                raise document.error(
                    tr(
                        "the morph target has {count:,} rows for {vertices:,} vertices",
                        count=len(displacements),
                        vertices=len(stored_positions),
                    ),
                    "targets",
                )
            positions += target_weight * displacements[rows].astype(np.float64)
    return positions


def _local_matrix(document: Document, node: dict[str, Any], index: int) -> AnyArray:
    location = f"nodes[{index}]"
    if "matrix" in node:
        return numbers(document, node["matrix"], 16, location).reshape(4, 4).T
    matrix = np.eye(4)
    if "rotation" in node:
        x, y, z, w = numbers(document, node["rotation"], 4, location)
        length = np.sqrt(x * x + y * y + z * z + w * w)
        if not length > 0:
            raise document.error(tr("the rotation is not valid"), location)
        x, y, z, w = np.array([x, y, z, w]) / length
        matrix[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    if "scale" in node:
        matrix[:3, :3] *= numbers(document, node["scale"], 3, location)
    if "translation" in node:
        matrix[:3, 3] = numbers(document, node["translation"], 3, location)
    return matrix


def _read_primitive(
    document: Document,
    primitive: dict[str, Any],
    matrix: AnyArray,
    weights: object,
    is_shared: bool,
    findings: list[Finding],
) -> PlacedPrimitive:
    attributes = document.section("attributes", primitive)
    if "POSITION" not in attributes:
        return PlacedPrimitive(np.empty((0, 3)), None, -1)
    stored_positions = document.accessor(attributes["POSITION"], 3)
    mode = primitive.get("mode", TRIANGLES)
    faces = None
    if mode != POINTS:
        faces = _faces(document, primitive, mode, len(stored_positions), findings)
    material = primitive.get("material", -1)
    if material != -1:
        document.item("materials", material)
    rows: Any = slice(None)
    if faces is not None and is_shared:
        # Many primitives share one large buffer, so copy only the part that each one needs.
        rows, faces = _used_rows(faces, len(stored_positions))
    document.budget.take(
        24 * (len(stored_positions) if isinstance(rows, slice) else len(rows)), "meshes"
    )
    positions = _morphed_positions(document, primitive, stored_positions, rows, weights)
    if not np.array_equal(matrix, np.eye(4)):
        positions = positions @ matrix[:3, :3].T + matrix[:3, 3]
        if faces is not None and np.linalg.det(matrix[:3, :3]) < 0:
            faces = faces[:, ::-1]
    piece = PlacedPrimitive(positions, faces, material)
    n = len(stored_positions)

    def values(name: str, *widths: int) -> AnyArray | None:
        if name not in attributes:
            return None
        columns = document.accessor(attributes[name], *widths)
        if len(columns) != n:
            raise document.error(
                tr(
                    "the attribute has {count:,} rows for {vertices:,} vertices",
                    count=len(columns),
                    vertices=n,
                ),
                name,
            )
        used_columns = np.asarray(columns[rows])
        document.budget.take(used_columns.nbytes, name)
        return used_columns

    texture = color_map(document, material)
    piece.uv = values(f"TEXCOORD_{uv_set(document, texture)}", 2)
    if piece.uv is not None:
        piece.uv = transform_uv(document, piece.uv.astype(np.float64), texture)
    colors = values("COLOR_0", 3, 4)
    if colors is not None:
        piece.colors = to_uint8_colors(np.ascontiguousarray(colors[:, :3]))
    if faces is None:
        piece.normals = values("NORMAL", 3)
        if piece.normals is not None:
            # Transforming normals as directions is correct for rotations and uniform scales, which
            # clouds have.
            piece.normals = piece.normals @ matrix[:3, :3].T
    for name in attributes:
        if not name.startswith("_"):
            continue
        columns = values(name, 1, 2, 3, 4)
        assert columns is not None
        for j in range(columns.shape[1]):
            label = name[1:] if columns.shape[1] == 1 else f"{name[1:]} {j + 1}"
            piece.fields[label] = np.ascontiguousarray(columns[:, j])
    return piece


def _faces(
    document: Document, primitive: dict[str, Any], mode: object, n: int, findings: list[Finding]
) -> AnyArray:
    corners: AnyArray
    if "indices" in primitive:
        corners = document.accessor(primitive["indices"], 1)[:, 0]
        if corners.dtype.kind != "u":
            raise document.error(tr("the indices are not unsigned integers"), "primitives")
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
        second_corners, third_corners = corners[1:-1], corners[2:]
        if mode == FAN:
            first_corners = np.broadcast_to(corners[0], second_corners.shape)
            faces = np.stack([first_corners, second_corners, third_corners], axis=1)
        else:
            faces = np.stack([corners[:-2], second_corners, third_corners], axis=1)
            faces[1::2] = faces[1::2, ::-1]
    else:
        raise document.error(tr("'{mode}' is not a valid primitive mode", mode=mode), "primitives")
    if len(faces) and faces.max() >= n:
        is_valid: AnyArray = np.asarray((faces < n).all(axis=1))
        invalid_count = int(len(is_valid) - np.count_nonzero(is_valid))
        findings.append(Finding("model.faces-without-vertices", count=invalid_count))
        faces = faces[is_valid]
    return faces
