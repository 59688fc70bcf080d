"""glTF 2.0: .glb, and .gltf with its buffers and images beside or inside.

The format is Y-up, in metres, and float32; so a georeferenced model is written as World minus an
origin, which `asset.extras` or `NAME.offset.txt` carries. What comes out of here is upright again
(x East, y North, z Up), with the origin added in float64.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from vomstudio.errors import InputError
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.io.models import image_store
from vomstudio.io.models.formats._clean import drop_unsound, drop_unsound_points, scale_colors, some
from vomstudio.io.models.formats._gltf_document import Document
from vomstudio.io.models.mtl import check_image
from vomstudio.io.models.offset_file import checked_origin, crs_or_problem, offset_path, read_offset
from vomstudio.io.models.reader import LoadedModel, Reader
from vomstudio.progress import Progress

Array = npt.NDArray[Any]

MAX_VERTICES = 200_000_000
POINTS, TRIANGLES, STRIP, FAN = 0, 4, 5, 6
# From Y up to Z up: x stays, North is -z, Up is y.
UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
MAPS_NOT_USED = ("normalTexture", "occlusionTexture", "emissiveTexture")


@dataclass
class Piece:
    """One primitive in its place: positions (n, 3) float64, still Y-up; faces (m, 3), or None of
    points; the rest per vertex."""

    positions: npt.NDArray[np.float64]
    faces: npt.NDArray[np.int64] | None
    material: int
    uv: Array | None = None
    colors: Array | None = None
    normals: Array | None = None
    fields: dict[str, Array] = field(default_factory=dict)


def matches(path: Path, head: bytes) -> bool:
    return head.startswith(b"glTF")


def read(path: Path, progress: Progress) -> LoadedModel:
    """The triangles of the file's scene, or its points where it has no triangles.

    Embedded images are laid out as files (io.image_store). Raises InputError for what is no sound
    glTF, is compressed, or lacks a file that it needs.
    """
    try:
        return _read(Document(path, progress))
    except (TypeError, ValueError, LookupError, ArithmeticError, AttributeError) as error:
        # Somebody else's JSON can be wrong in more ways than can be asked for one by one.
        raise InputError(
            f"The scene contradicts itself ({' '.join(str(error).split())[:120]}); export it"
            " again.",
            file=path,
        ) from error


def _read(document: Document) -> LoadedModel:
    said: list[str] = []
    for name in document.unknown_extensions():
        said.append(f"It uses '{name}', which is not understood here; look whether all is there.")
    pieces = list(_pieces(document, said))
    solid = [p for p in pieces if p.faces is not None]
    if not pieces:
        raise document.wrong("There are no triangles and no points in its scene")
    if solid and len(solid) < len(pieces):
        said.append("It has loose points beside its triangles; they are left out.")
    origin, crs, declared = _origin(document, said)
    data: Mesh | PointCloud
    if solid:
        if not declared:
            _warn_if_z_looks_up(solid, said)
        data = drop_unsound(_mesh(document, solid, origin, said), said, document.path)
    else:
        data = drop_unsound_points(_cloud(pieces, origin), said, document.path)
    kind: Literal["mesh", "cloud"] = "mesh" if isinstance(data, Mesh) else "cloud"
    x, y, z = origin.tolist()
    return LoadedModel(
        data, kind, crs, tuple(said), document.path, document.content_hash, (x, y, z)
    )


def _origin(
    document: Document, said: list[str]
) -> tuple[npt.NDArray[np.float64], str | None, bool]:
    """What is added to the turned positions, the CRS, and whether the file says either."""
    path = document.path
    extras = document.section("extras", document.section("asset"))
    inside = None
    if "origin" in extras:
        inside = checked_origin(extras["origin"])
        if inside is None:
            said.append("The origin in its asset.extras is no place and is not added.")
    crs, problem = crs_or_problem(extras.get("crs"), path.name)
    beside = read_offset(path)
    said.extend(text for text in (problem, beside.problem) if text)
    if inside is not None and beside.origin not in (None, inside):
        said.append(
            f"'{offset_path(path).name}' has another origin than the file itself, whose own is"
            " taken."
        )
    origin = inside or beside.origin
    crs = crs or beside.crs
    return np.array(origin or (0.0, 0.0, 0.0)), crs, origin is not None or crs is not None


def _pieces(document: Document, said: list[str]) -> Iterator[Piece]:
    placed = list(_placed_meshes(document, said))
    uses: dict[object, int] = {}
    for index, _ in placed:
        for primitive in _primitives(document, index):
            key = document.section("attributes", primitive).get("POSITION")
            uses[_key(key)] = uses.get(_key(key), 0) + 1
    total = lines = 0
    progress = document.progress
    progress.stage("Reading the scene", len(placed))
    for done, (index, matrix) in enumerate(placed):
        for primitive in _primitives(document, index):
            mode = primitive.get("mode", TRIANGLES)
            if mode in (1, 2, 3):
                lines += 1
                continue
            key = document.section("attributes", primitive).get("POSITION")
            piece = _piece(document, primitive, matrix, uses[_key(key)] > 1, said)
            total += len(piece.positions)
            if total > MAX_VERTICES:
                raise InputError(
                    f"The scene has more than {MAX_VERTICES:,} vertices once its meshes are in all"
                    " their places; divide it.",
                    file=document.path,
                )
            if len(piece.positions):
                yield piece
        progress.step(done + 1)
    if lines:
        said.append("It has lines, which are left out.")


def _key(index: object) -> object:
    return index if isinstance(index, int) else None


def _primitives(document: Document, mesh: object) -> list[dict[str, Any]]:
    found = document.item("meshes", mesh).get("primitives")
    return [p for p in found if isinstance(p, dict)] if isinstance(found, list) else []


def _placed_meshes(document: Document, said: list[str]) -> Iterator[tuple[object, Array]]:
    """Each mesh of the scene with the 4x4 matrix of its place."""
    n = document.count("nodes")
    if n == 0:
        for mesh in range(document.count("meshes")):
            yield mesh, np.eye(4)
        return
    if document.count("scenes"):
        scene = document.item("scenes", document.json.get("scene", 0))
        roots = scene.get("nodes", [])
    else:
        below = {c for i in range(n) for c in _children(document, i) if isinstance(c, int)}
        roots = [i for i in range(n) if i not in below]
    if not isinstance(roots, list):
        raise document.wrong("'nodes' is no list", "scenes")
    seen: set[int] = set()
    waiting: list[tuple[object, Array]] = [(node, np.eye(4)) for node in reversed(roots)]
    while waiting:
        index, above = waiting.pop()
        node = document.item("nodes", index)
        assert isinstance(index, int)
        if index in seen:
            raise document.wrong("A node stands in two places or within itself", f"nodes[{index}]")
        seen.add(index)
        matrix = above @ _local_matrix(document, node, index)
        if "skin" in node:
            said.append("It has a skeleton; the model is shown as it is without its pose.")
        if "mesh" in node:
            yield node["mesh"], matrix
        waiting.extend((child, matrix) for child in reversed(_children(document, index)))


def _children(document: Document, index: int) -> list[Any]:
    found = document.item("nodes", index).get("children", [])
    return found if isinstance(found, list) else []


def _local_matrix(document: Document, node: dict[str, Any], index: int) -> Array:
    place = f"nodes[{index}]"
    if "matrix" in node:
        return _numbers(document, node["matrix"], 16, place).reshape(4, 4).T
    matrix = np.eye(4)
    if "rotation" in node:
        x, y, z, w = _numbers(document, node["rotation"], 4, place)
        length = np.sqrt(x * x + y * y + z * z + w * w)
        if not length > 0:
            raise document.wrong("Its rotation is none", place)
        x, y, z, w = np.array([x, y, z, w]) / length
        matrix[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    if "scale" in node:
        matrix[:3, :3] *= _numbers(document, node["scale"], 3, place)
    if "translation" in node:
        matrix[:3, 3] = _numbers(document, node["translation"], 3, place)
    return matrix


def _numbers(document: Document, values: object, n: int, place: str) -> npt.NDArray[np.float64]:
    if isinstance(values, list) and len(values) == n:
        try:
            found = np.array(values, np.float64)
        except (TypeError, ValueError, OverflowError):
            found = np.full(n, np.nan)
        if found.shape == (n,) and np.isfinite(found).all():
            return found
    raise document.wrong(f"{n} numbers are wanted in it", place)


def _piece(
    document: Document, primitive: dict[str, Any], matrix: Array, shared: bool, said: list[str]
) -> Piece:
    attributes = document.section("attributes", primitive)
    if "POSITION" not in attributes:
        return Piece(np.empty((0, 3)), None, -1)
    stored = document.accessor(attributes["POSITION"], 3)
    mode = primitive.get("mode", TRIANGLES)
    faces = None
    if mode != POINTS:
        faces = _faces(document, primitive, mode, len(stored), said)
    material = primitive.get("material", -1)
    if material != -1:
        document.item("materials", material)
    rows: Any = slice(None)
    if faces is not None and shared:
        # One large buffer cut into many primitives: each takes only what it needs.
        used = np.zeros(len(stored), bool)
        used[faces] = True
        rows = np.flatnonzero(used)
        faces = (np.cumsum(used) - 1)[faces]
    positions = stored[rows].astype(np.float64)
    if not np.array_equal(matrix, np.eye(4)):
        positions = positions @ matrix[:3, :3].T + matrix[:3, 3]
        if faces is not None and np.linalg.det(matrix[:3, :3]) < 0:
            faces = faces[:, ::-1]
    piece = Piece(positions, faces, material)
    n = len(stored)

    def values(name: str, *widths: int) -> Array | None:
        if name not in attributes:
            return None
        found = document.accessor(attributes[name], *widths)
        if len(found) != n:
            raise document.wrong(f"It has {len(found):,} rows for {n:,} vertices", name)
        return np.asarray(found[rows])

    texture = _color_map(document, material)
    piece.uv = values(f"TEXCOORD_{_uv_set(document, texture)}", 2)
    if piece.uv is not None:
        piece.uv = _moved(document, piece.uv.astype(np.float64), texture)
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
    document: Document, primitive: dict[str, Any], mode: object, n: int, said: list[str]
) -> npt.NDArray[np.int64]:
    if "indices" in primitive:
        raw = document.accessor(primitive["indices"], 1)[:, 0]
        if raw.dtype.kind != "u":
            raise document.wrong("Its indices are no whole numbers", "primitives")
        corners = raw.astype(np.int64)
    else:
        corners = np.arange(n)
    if mode == TRIANGLES:
        faces = corners[: len(corners) // 3 * 3].reshape(-1, 3)
    elif mode in (STRIP, FAN):
        if len(corners) < 3:
            return np.empty((0, 3), np.int64)
        second, third = corners[1:-1], corners[2:]
        if mode == FAN:
            first = np.broadcast_to(corners[0], second.shape)
            faces = np.stack([first, second, third], axis=1)
        else:
            faces = np.stack([corners[:-2], second, third], axis=1)
            faces[1::2] = faces[1::2, ::-1]
    else:
        raise document.wrong(f"'{mode}' is no kind of primitive", "primitives")
    sound: Array = np.asarray((faces < n).all(axis=1))
    if not sound.all():
        bad = int(len(sound) - np.count_nonzero(sound))
        said.append(f"{some(bad, 'face')} left out that name vertices the file does not have.")
        faces = faces[sound]
    return faces


# --- materials ---------------------------------------------------------------------------------


def _color_map(document: Document, material: object) -> dict[str, Any]:
    """The textureInfo of a material's colour; empty where it has none."""
    if material == -1:
        return {}
    entry = document.item("materials", material)
    found = document.section("baseColorTexture", document.section("pbrMetallicRoughness", entry))
    if found:
        return found
    older = document.section(
        "KHR_materials_pbrSpecularGlossiness", document.section("extensions", entry)
    )
    return document.section("diffuseTexture", older)


def _transform(document: Document, texture: dict[str, Any]) -> dict[str, Any]:
    return document.section("KHR_texture_transform", document.section("extensions", texture))


def _uv_set(document: Document, texture: dict[str, Any]) -> int:
    wanted = _transform(document, texture).get("texCoord", texture.get("texCoord", 0))
    return wanted if isinstance(wanted, int) and 0 <= wanted < 100 else 0


def _moved(document: Document, uv: npt.NDArray[np.float64], texture: dict[str, Any]) -> Array:
    """Texture coordinates as the mesh has them: origin at the lower left, nothing left to apply."""
    move = _transform(document, texture)
    if "scale" in move:
        uv = uv * _numbers(document, move["scale"], 2, "KHR_texture_transform")
    if "rotation" in move:
        (angle,) = _numbers(document, [move["rotation"]], 1, "KHR_texture_transform")
        c, s = np.cos(angle), np.sin(angle)
        uv = uv @ np.array([[c, -s], [s, c]])
    if "offset" in move:
        uv = uv + _numbers(document, move["offset"], 2, "KHR_texture_transform")
    return np.stack([uv[:, 0], 1.0 - uv[:, 1]], axis=1).astype(np.float32)


def _materials(document: Document, used: list[int], said: list[str]) -> tuple[Material, ...]:
    images: dict[object, tuple[Path | None, str | None]] = {}
    result = []
    extra = False
    for index in used:
        if index == -1:
            result.append(Material(""))
            continue
        entry = document.item("materials", index)
        name = str(entry.get("name") or f"material_{index}")
        extra = extra or any(key in entry for key in MAPS_NOT_USED)
        info = _color_map(document, index)
        texture: Path | None = None
        if info:
            source = _image_of(document, info)
            if source not in images:
                images[source] = _image(document, source, name)
            texture, problem = images[source]
            if problem:
                said.append(f"Texture of material '{name}': {problem}.")
        result.append(Material(name, texture, _diffuse(document, entry)))
    if extra:
        said.append("Only colours are used; its maps of relief, shadow or light are not.")
    return tuple(result)


def _diffuse(document: Document, entry: dict[str, Any]) -> tuple[float, float, float] | None:
    rough = document.section("pbrMetallicRoughness", entry)
    older = document.section(
        "KHR_materials_pbrSpecularGlossiness", document.section("extensions", entry)
    )
    factor = rough.get("baseColorFactor", older.get("diffuseFactor"))
    if factor is None:
        return None
    r, g, b, _ = srgb(np.clip(_numbers(document, factor, 4, "baseColorFactor"), 0.0, 1.0)).tolist()
    return r, g, b


def srgb(linear: Array) -> Array:
    """From the linear light of glTF's factors to the values that images and MTL files hold
    (IEC 61966-2-1)."""
    low = linear <= 0.0031308
    return np.where(low, 12.92 * linear, 1.055 * np.maximum(linear, 0.0) ** (1 / 2.4) - 0.055)


def _image_of(document: Document, info: dict[str, Any]) -> object:
    texture = document.item("textures", info.get("index"))
    webp = document.section("EXT_texture_webp", document.section("extensions", texture))
    return webp.get("source", texture.get("source"))


def _image(document: Document, index: object, material: str) -> tuple[Path | None, str | None]:
    """The file of an image, or what is wrong with it."""
    if index is None:
        return None, "it has no image of a kind that can be read"
    entry = document.item("images", index)
    where = f"images[{index}]"
    name = entry.get("name")
    label = name if isinstance(name, str) and name else material
    try:
        if "bufferView" in entry:
            content = document.view(entry["bufferView"])[0].tobytes()
        else:
            source = document.uri_bytes(entry.get("uri"), where)
            if isinstance(source, Path):
                wrong = check_image(source)
                return (None, wrong) if wrong else (source, None)
            content = source
    except InputError as error:
        return None, error.message.removesuffix("; export the file again.").rstrip(".")
    if image_store.ending_of(content) == ".img":
        return None, f"'{label}' is not an image that can be read"
    try:
        kept = image_store.keep(content, Path(label).stem if "." in label else label)
    except OSError as error:
        return None, f"it cannot be kept in {image_store.folder()} ({error.strerror})"
    wrong = check_image(kept)
    return (None, wrong) if wrong else (kept, None)


# --- all pieces together -----------------------------------------------------------------------


def _joined(
    pieces: list[Piece], values: list[Array | None], width: int, fill: float, dtype: Any
) -> Array | None:
    """Values per vertex of all pieces, with `fill` where a piece has none; None where all have
    none."""
    if all(v is None for v in values):
        return None
    parts = [
        np.full((len(p.positions), width), fill, dtype) if v is None else v.astype(dtype)
        for p, v in zip(pieces, values, strict=True)
    ]
    return np.ascontiguousarray(np.concatenate(parts))


def _fields(pieces: list[Piece]) -> dict[str, Array]:
    result: dict[str, Array] = {}
    for name in dict.fromkeys(n for p in pieces for n in p.fields):
        found = [p.fields.get(name) for p in pieces]
        there = [f.dtype for f in found if f is not None]
        dtype: Any = np.result_type(*there)
        if len(there) < len(pieces):
            dtype = np.result_type(dtype, np.float32)
        columns = [None if f is None else f[:, None] for f in found]
        joined = _joined(pieces, columns, 1, np.nan if dtype.kind == "f" else 0, dtype)
        assert joined is not None
        result[name] = np.ascontiguousarray(joined[:, 0])
    return result


def _positions(pieces: list[Piece], origin: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    y_up = np.concatenate([p.positions for p in pieces])
    upright = np.empty_like(y_up)
    upright[:, 0] = y_up[:, 0]
    np.negative(y_up[:, 2], out=upright[:, 1])
    upright[:, 2] = y_up[:, 1]
    upright += origin
    return upright


def _mesh(
    document: Document, pieces: list[Piece], origin: npt.NDArray[np.float64], said: list[str]
) -> Mesh:
    used = sorted({p.material for p in pieces}, key=lambda m: (m == -1, m))
    pieces = sorted(pieces, key=lambda p: used.index(p.material))
    starts = np.concatenate([[0], np.cumsum([len(p.positions) for p in pieces])])
    faces = np.concatenate(
        [
            p.faces + start
            for p, start in zip(pieces, starts[:-1], strict=True)
            if p.faces is not None
        ]
    ).astype(np.int32)
    counts = [
        sum(len(p.faces) for p in pieces if p.material == m and p.faces is not None) for m in used
    ]
    offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    materials = _materials(document, used, said)
    if used == [-1]:
        materials, offsets = (), np.zeros(1, np.int64)
    return Mesh(
        _positions(pieces, origin),
        np.ascontiguousarray(faces),
        materials,
        offsets,
        _joined(pieces, [p.uv for p in pieces], 2, np.nan, np.float32),
        _joined(pieces, [p.colors for p in pieces], 3, 255, np.uint8),
        _fields(pieces),
    )


def _cloud(pieces: list[Piece], origin: npt.NDArray[np.float64]) -> PointCloud:
    normals = _joined(pieces, [p.normals for p in pieces], 3, np.nan, np.float64)
    return PointCloud(
        _positions(pieces, origin),
        _joined(pieces, [p.colors for p in pieces], 3, 255, np.uint8),
        None if normals is None else (normals @ UPRIGHT.T).astype(np.float32),
        _fields(pieces),
    )


def _warn_if_z_looks_up(pieces: list[Piece], said: list[str]) -> None:
    """Outcrops are looked at from above or the side, never from below: a surface that as a whole
    faces along the file's Z was most likely written with Z up."""
    total, area = np.zeros(3), 0.0
    for piece in pieces:
        if piece.faces is None or not len(piece.faces):
            continue
        a, b, c = (piece.positions[piece.faces[:, k]] for k in range(3))
        turned = np.cross(b - a, c - a)
        turned = turned[np.isfinite(turned).all(axis=1)]
        total += turned.sum(axis=0)
        area += float(np.sqrt((turned**2).sum(axis=1)).sum())
    if area > 0 and abs(total[2]) > 0.7 * area and abs(total[1]) < 0.3 * area:
        said.append(
            "Its surface faces along Z, as if Z were up in the file, where the format says Y: if it"
            " lies on its side, convert it with --up z."
        )


READER = Reader("glTF scene", (".glb", ".gltf"), matches, read)
