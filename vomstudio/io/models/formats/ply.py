"""PLY: meshes and point clouds, as text or binary of either byte order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from vomstudio.errors import InputError
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.io.models.formats._clean import (
    drop_unsound,
    drop_unsound_points,
    read_whole,
    scale_colors,
    some,
)
from vomstudio.io.models.mtl import check_image, decode, find_beside
from vomstudio.io.models.reader import LoadedModel, Reader
from vomstudio.progress import Progress

Array = npt.NDArray[np.generic]

MAX_HEADER_BYTES = 1 << 20
MAX_ROWS = 2**31 - 1
VALUES_PER_STEP = 1 << 20

TYPES = {
    "char": "i1",
    "int8": "i1",
    "uchar": "u1",
    "uint8": "u1",
    "short": "i2",
    "int16": "i2",
    "ushort": "u2",
    "uint16": "u2",
    "int": "i4",
    "int32": "i4",
    "uint": "u4",
    "uint32": "u4",
    "float": "f4",
    "float32": "f4",
    "double": "f8",
    "float64": "f8",
}
FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}

COLOR_NAMES = (
    ("red", "green", "blue"),
    ("diffuse_red", "diffuse_green", "diffuse_blue"),
    ("r", "g", "b"),
)
UV_NAMES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"), ("texture_s", "texture_t"))
NORMAL_NAMES = ("nx", "ny", "nz")
FACE_NAMES = ("vertex_indices", "vertex_index")


@dataclass(frozen=True)
class Property:
    name: str
    type: str  # numpy, without byte order
    count_type: str | None = None  # of a list's length


@dataclass(frozen=True)
class Element:
    name: str
    count: int
    properties: tuple[Property, ...]


@dataclass(frozen=True)
class Header:
    order: str  # "<", ">" or "" for text
    elements: tuple[Element, ...]
    textures: tuple[str, ...]
    body: int  # first byte after it


@dataclass
class Table:
    """One element's values: plain ones by name, lists as (lengths, all items)."""

    n: int
    plain: dict[str, Array] = field(default_factory=dict)
    lists: dict[str, tuple[npt.NDArray[np.int64], Array]] = field(default_factory=dict)


def matches(path: Path, head: bytes) -> bool:
    return head.startswith((b"ply\n", b"ply\r", b"ply "))


def read(path: Path, progress: Progress) -> LoadedModel:
    """The mesh or cloud of a PLY file.

    Records that are missing or unsound are left out and counted in the warnings. Raises InputError
    where the header cannot be understood or nothing sound follows it.
    """
    data = read_whole(path, progress)
    header = read_header(data[:MAX_HEADER_BYTES].tobytes(), path)
    said: list[str] = []
    if header.order == "":
        tables = _read_text(bytearray(data), header, path, said, progress)
    else:
        tables = _read_binary(data, header, said, progress)
    del data
    model = _assemble(header, tables, path, said)
    kind: Literal["mesh", "cloud"] = "cloud" if isinstance(model, PointCloud) else "mesh"
    return LoadedModel(model, kind, None, tuple(said), path)


def read_header(top: bytes, path: Path) -> Header:
    """The header; raises InputError with the line that is wrong."""
    if not matches(path, top):
        raise InputError("This is not a PLY file: it does not begin with 'ply'.", file=path, line=1)
    at = 0
    order: str | None = None
    elements: list[tuple[str, int, list[Property]]] = []
    textures: list[str] = []
    names: set[tuple[int, str]] = set()
    number = 0

    def wrong(sentence: str) -> InputError:
        return InputError(f"{sentence}; export the file again.", file=path, line=number)

    while True:
        ends = [e for e in (top.find(b"\n", at), top.find(b"\r", at)) if e >= 0]
        if not ends:
            raise wrong("The PLY header has no 'end_header'")
        end = min(ends)
        line = decode(top[at:end])
        at = end + (2 if top[end : end + 2] == b"\r\n" else 1)
        number += 1
        words = line.split()
        if not words or words[0] == "obj_info" or (number == 1 and words == ["ply"]):
            continue
        if words[0] == "end_header":
            break
        if words[0] == "comment":
            if len(words) > 2 and words[1].lower() == "texturefile":
                textures.append(line.split(None, 2)[2].strip())
        elif words[0] == "format":
            if len(words) < 2 or words[1] not in FORMATS:
                raise wrong(f"The PLY format '{' '.join(words[1:])}' is not known")
            order = FORMATS[words[1]]
        elif words[0] == "element":
            if len(words) != 3 or not words[2].isdecimal() or len(words[2]) > 18:
                raise wrong(f"'{line.strip()}' names no element and count")
            elements.append((words[1], int(words[2]), []))
        elif words[0] == "property":
            if not elements:
                raise wrong("A property stands before the first element")
            is_list = words[1:2] == ["list"]
            kinds = words[2:4] if is_list else words[1:2]
            if len(words) != (5 if is_list else 3) or any(k not in TYPES for k in kinds):
                raise wrong(f"'{line.strip()}' is no property of a known type")
            if is_list:
                if TYPES[kinds[0]][0] == "f":
                    raise wrong(f"'{line.strip()}' counts a list in broken numbers")
                new = Property(words[4], TYPES[kinds[1]], TYPES[kinds[0]])
            else:
                new = Property(words[2], TYPES[kinds[0]])
            known = (len(elements), new.name)
            if known in names:
                raise wrong(f"The property '{new.name}' stands twice in one element")
            names.add(known)
            elements[-1][2].append(new)
        else:
            raise wrong(f"The PLY header line '{line.strip()[:60]}' is not understood")
    if order is None:
        raise InputError("The PLY header names no format; export it again.", file=path)
    return Header(
        order, tuple(Element(n, c, tuple(p)) for n, c, p in elements), tuple(textures), at
    )


def _missing(element: Element, found: int, said: list[str]) -> None:
    """The header promised more than there is."""
    what = "points" if element.name == "vertex" else f"'{element.name}' records"
    said.append(f"The file is cut short: {found:,} of {element.count:,} promised {what} are there.")


def _read_binary(
    buffer: npt.NDArray[np.uint8], header: Header, said: list[str], progress: Progress
) -> dict[str, Table]:
    tables: dict[str, Table] = {}
    at = header.body
    progress.stage("Reading the model", len(header.elements))
    for i, element in enumerate(header.elements):
        if element.properties and element.count:
            # Never believe a count: each record takes at least so many bytes.
            least = sum(np.dtype(p.count_type or p.type).itemsize for p in element.properties)
            n = min(element.count, (len(buffer) - at) // least)
            table, at = _binary_table(buffer, at, element, n, header.order)
            if table.n < element.count:
                _missing(element, table.n, said)
                at = len(buffer)
        else:
            table = Table(0)
        tables.setdefault(element.name, table)
        progress.step(i + 1)
    return tables


def _binary_table(
    buffer: npt.NDArray[np.uint8], at: int, element: Element, n: int, order: str
) -> tuple[Table, int]:
    """Up to n records from byte `at`, and the byte after them."""
    lists = [p for p in element.properties if p.count_type]
    guess: dict[str, int] = {}
    if lists:
        guess = _first_lengths(buffer, at, element, order) if n else {}
        if len(guess) < len(lists):
            return _ragged_table(buffer, at, element, n, order)
    parts: list[tuple[str, object]] = []
    for p in element.properties:
        if p.count_type:
            parts.append((f"n {p.name}", order + p.count_type))
            parts.append((p.name, (order + p.type, (guess[p.name],))))
        else:
            parts.append((p.name, order + p.type))
    record = np.dtype(parts)
    fitting = min(n, (len(buffer) - at) // record.itemsize)
    array = np.frombuffer(buffer, record, fitting, at)
    if any(np.any(array[f"n {p.name}"] != guess[p.name]) for p in lists):
        return _ragged_table(buffer, at, element, n, order)
    if lists and fitting < n:
        return _ragged_table(buffer, at, element, n, order)
    table = Table(fitting)
    for p in element.properties:
        values = array[p.name].astype(p.type)
        if p.count_type:
            table.lists[p.name] = (
                np.full(fitting, guess[p.name], np.int64),
                values.reshape(-1),
            )
        else:
            table.plain[p.name] = values
    return table, at + fitting * record.itemsize


def _first_lengths(
    buffer: npt.NDArray[np.uint8], at: int, element: Element, order: str
) -> dict[str, int]:
    """Lengths of the lists of the first record; fewer than there are where it is unsound."""
    found: dict[str, int] = {}
    for p in element.properties:
        size = np.dtype(p.type).itemsize
        if p.count_type is None:
            at += size
            continue
        kind = np.dtype(order + p.count_type)
        if at + kind.itemsize > len(buffer):
            break
        n = int(np.frombuffer(buffer, kind, 1, at)[0])
        at += kind.itemsize + n * size
        if n < 0 or n > 64 or at > len(buffer):
            break
        found[p.name] = n
    return found


def _ragged_table(
    buffer: npt.NDArray[np.uint8], at: int, element: Element, n: int, order: str
) -> tuple[Table, int]:
    from vomstudio.io.models.formats import _ply_kernels as k

    data = buffer
    kinds = [np.dtype(p.type) for p in element.properties]
    sizes = np.array([kind.itemsize for kind in kinds], np.int64)
    count_kinds = [np.dtype(p.count_type) if p.count_type else None for p in element.properties]
    count_sizes = np.array([c.itemsize if c else 0 for c in count_kinds], np.int64)
    signed = np.array([c is not None and c.kind == "i" for c in count_kinds])
    places = np.empty((n, len(sizes)), np.int64)
    counts = np.empty((n, len(sizes)), np.int64)
    n = k.walk(data, at, sizes, count_sizes, signed, order == "<", places, counts)
    places, counts = places[:n], counts[:n]
    table = Table(n)
    for j, p in enumerate(element.properties):
        out = np.empty(int(counts[:, j].sum()) * kinds[j].itemsize, np.uint8)
        k.gather(data, places[:, j], counts[:, j], kinds[j].itemsize, out)
        values = out.view(order + p.type).astype(p.type)
        if p.count_type:
            table.lists[p.name] = (counts[:, j].copy(), values)
        else:
            table.plain[p.name] = values
    if n:
        at = int(places[-1, -1] + counts[-1, -1] * sizes[-1])
    return table, at


def _read_text(
    buffer: bytearray, header: Header, path: Path, said: list[str], progress: Progress
) -> dict[str, Table]:
    from vomstudio.io.models.formats import _ply_kernels as k

    if buffer.find(0, header.body) >= 0:
        raise InputError(
            "The header says the PLY is a text, but binary data follow; export it again.", file=path
        )
    if buffer.find(b"\n", header.body) < 0:
        buffer[header.body :] = buffer[header.body :].replace(b"\r", b"\n")
    cut = not buffer.endswith(b"\n")
    if cut:
        buffer += b"\n"
    data = np.frombuffer(buffer, np.uint8)
    tables: dict[str, Table] = {}
    at = header.body
    wrong = 0
    first_wrong: int | None = None
    progress.stage("Reading the model", len(buffer))
    for element in header.elements:
        if not element.count or not element.properties:
            tables.setdefault(element.name, Table(0))
            continue
        # A record takes two bytes for each of its values at least.
        wanted = min(element.count, (len(buffer) - at) // (2 * len(element.properties)) + 1)
        starts = np.zeros(wanted + 1, np.int64)
        longest = _longest_line(buffer, at)
        room = max(VALUES_PER_STEP, longest)
        parts: list[npt.NDArray[np.float64]] = []
        row = filled = 0
        while row < wanted and at < len(buffer):
            values = np.empty(room)
            left_over = np.empty((room, 3), np.int64)
            before = row
            at, row, n = k.rows(data, at, wanted, starts, values, left_over, row, 0)
            ends = np.flatnonzero(left_over[:, 0] < 0)
            for where, begin, stop in left_over[: ends[0] if len(ends) else room].tolist():
                value, sound = _value(bytes(buffer[begin:stop]))
                values[where] = value
                if not sound:
                    wrong += 1
                    first_wrong = begin if first_wrong is None else first_wrong
            starts[before + 1 : row + 1] += filled
            filled += n
            parts.append(values[:n].copy())
            progress.step(at)
        if row < element.count:
            if cut and at >= len(buffer) and row:
                row -= 1  # its last number may have lost digits
            _missing(element, row, said)
            at = len(buffer)
        tables.setdefault(
            element.name,
            _text_table(element, np.concatenate(parts or [np.empty(0)]), starts[: row + 1], said),
        )
    if cut and not any("cut short" in s for s in said):
        said.append("The last line has no line end: its last number may have been cut short.")
    if first_wrong is not None:
        line = 1 + buffer.count(b"\n", 0, first_wrong)
        said.append(f"{some(wrong, 'value')} not a number, first in line {line}.")
    return tables


def _value(token: bytes) -> tuple[float, bool]:
    from vomstudio.io.models.formats._decimals import python_number

    value = python_number(token)
    return (float("nan"), False) if value is None else (value, True)


def _longest_line(buffer: bytearray, at: int) -> int:
    """An upper bound for the values of one line, and of what else a step needs."""
    lengths = np.diff(np.flatnonzero(np.frombuffer(buffer, np.uint8)[at:] == 10), prepend=-1)
    return int(lengths.max(initial=0)) // 2 + 2


def _text_table(
    element: Element,
    values: npt.NDArray[np.float64],
    starts: npt.NDArray[np.int64],
    said: list[str],
) -> Table:
    from vomstudio.io.models.formats import _ply_kernels as k

    n = len(starts) - 1
    is_list = np.array([p.count_type is not None for p in element.properties])
    places = np.empty((n, len(is_list)), np.int64)
    counts = np.empty((n, len(is_list)), np.int64)
    k.walk_rows(values, starts, is_list, places, counts)
    short = int(np.count_nonzero(counts[:, ~is_list].min(axis=1, initial=1) == 0)) if n else 0
    if short and not is_list.any():
        what = "vertex" if element.name == "vertex" else "record"
        said.append(f"{some(short, what)} with too few values in their line.")
    table = Table(n)
    for j, p in enumerate(element.properties):
        if p.count_type:
            out = np.empty(int(counts[:, j].sum()))
            k.gather_values(values, places[:, j], counts[:, j], out)
            table.lists[p.name] = (counts[:, j].copy(), out)
        else:
            column = np.full(n, np.nan)
            there = counts[:, j] == 1
            column[there] = values[places[there, j]]
            table.plain[p.name] = _as_type(column, p.type)
    return table


def _as_type(values: npt.NDArray[np.float64], type_: str) -> Array:
    kind = np.dtype(type_)
    if kind.kind == "f":
        with np.errstate(over="ignore"):
            return values.astype(kind)
    limits = np.iinfo(kind)
    return np.clip(np.nan_to_num(values), limits.min, limits.max).astype(kind)


def _take(table: Table, names: tuple[str, ...], used: set[str]) -> list[Array] | None:
    by_case = {name.lower(): name for name in table.plain}
    if not all(name in by_case for name in names):
        return None
    used.update(by_case[name] for name in names)
    return [table.plain[by_case[name]] for name in names]


def _assemble(
    header: Header, tables: Mapping[str, Table], path: Path, said: list[str]
) -> Mesh | PointCloud:
    vertex = tables.get("vertex")
    if vertex is None:
        raise InputError("The PLY header names no 'vertex' element; export it again.", file=path)
    used: set[str] = set()
    names = {p.name.lower() for e in header.elements if e.name == "vertex" for p in e.properties}
    if not {"x", "y", "z"} <= names:
        raise InputError("The PLY has no x, y and z; export it again.", file=path, field="vertex")
    if vertex.n == 0:
        raise InputError("The PLY holds no points; export it again.", file=path, field="vertex")
    if vertex.n > MAX_ROWS:
        raise InputError("More than 2147483647 points; divide it into tiles.", file=path)
    xyz = _take(vertex, ("x", "y", "z"), used)
    assert xyz is not None
    points = np.empty((vertex.n, 3))
    for j, column in enumerate(xyz):
        points[:, j] = column
    colors = None
    for triple in COLOR_NAMES:
        found = _take(vertex, triple, used)
        if found is not None:
            used.update(n for n in vertex.plain if n.lower() in ("alpha", "diffuse_alpha", "a"))
            colors = scale_colors(np.stack(found, axis=1))
            break
    normals = _take(vertex, NORMAL_NAMES, used)
    face = tables.get("face")
    promised = any(e.name == "face" and e.count for e in header.elements)
    if face is None or not promised:
        fields = {n: v for n, v in vertex.plain.items() if n not in used}
        return drop_unsound_points(
            PointCloud(
                points,
                colors,
                None if normals is None else np.stack(normals, axis=1).astype(np.float32),
                fields,
            ),
            said,
            path,
        )
    uv = None
    for pair in UV_NAMES:
        found = _take(vertex, pair, used)
        if found is not None:
            uv = np.stack(found, axis=1).astype(np.float32)
            break
    fields = {n: v for n, v in vertex.plain.items() if n not in used}
    return _mesh(
        header,
        face,
        Mesh(points, np.empty((0, 3), np.int32), (), uv=uv, colors=colors, fields=fields),
        path,
        said,
    )


def _mesh(
    header: Header, face: Table, bare: Mesh, path: Path, said: list[str]
) -> Mesh | PointCloud:
    """Faces, their own texture coordinates and textures, onto bare vertices."""
    vertices, uv, colors, fields = bare.vertices, bare.uv, bare.colors, dict(bare.fields)
    key = next((n for n in FACE_NAMES if n in face.lists), None)
    indices: npt.NDArray[Any]
    if key is None:
        said.append("Its faces have no list 'vertex_indices'.")
        counts, indices = np.zeros(0, np.int64), np.zeros(0, np.int64)
    else:
        counts, raw = face.lists[key]
        indices = raw if raw.dtype.kind in "iu" else _whole(raw)
    uv_counts, uv_values = face.lists.get("texcoord", (np.zeros(0, np.int64), np.zeros(0)))
    has_wedges = len(uv_counts) == len(counts) > 0 and len(uv_values) > 0
    room = int(np.maximum(counts - 2, 0).sum())
    if room > MAX_ROWS:
        raise InputError("More than 2147483647 faces; divide it into tiles.", file=path)
    polygons = np.empty((0, 2), np.int64)
    if not has_wedges and len(counts) and (counts == 3).all():
        # The common case, without waiting for compiled code.
        triples: npt.NDArray[Any] = indices.reshape(-1, 3)
        n_vertices = len(vertices)
        if triples.min() >= 0 and triples.max() < n_vertices:
            face_of = np.arange(len(triples))
        else:
            face_of = np.flatnonzero(((triples >= 0) & (triples < n_vertices)).all(axis=1))
        out_of_range, short = len(triples) - len(face_of), 0
        if out_of_range:
            triples = triples[face_of]
        faces: npt.NDArray[np.int32] = triples.astype(np.int32, copy=False)
        uv_corners = np.empty((0, 3), np.int32)
    else:
        from vomstudio.io.models.formats import _ply_kernels as k

        faces = np.empty((room, 3), np.int32)
        uv_corners = np.empty((room if has_wedges else 0, 3), np.int32)
        face_of = np.empty(room, np.int32)
        polygons = np.empty((int(np.count_nonzero(counts > 3)), 2), np.int64)
        n, p, out_of_range, short = k.fan(
            np.ascontiguousarray(counts),
            np.ascontiguousarray(indices, np.int64),
            len(vertices),
            np.ascontiguousarray(uv_counts),
            faces,
            uv_corners,
            face_of,
            polygons,
        )
        faces, face_of, uv_corners, polygons = faces[:n], face_of[:n], uv_corners[:n], polygons[:p]
    if out_of_range:
        said.append(
            f"{some(out_of_range, 'face')} left out that name vertices the file does not have."
        )
    if short:
        said.append(f"{some(short, 'face')} with fewer than 3 corners left out.")
    if len(polygons):
        from vomstudio.io.models.formats import _polygons

        _polygons.cut_concave(vertices, faces, uv_corners, polygons)
    materials: tuple[Material, ...] = ()
    offsets = np.zeros(1, np.int64)
    if header.textures:
        materials = tuple(_texture(name, i, path, said) for i, name in enumerate(header.textures))
        ids = np.zeros(len(faces), np.int64)
        if "texnumber" in face.plain:
            ids = face.plain["texnumber"].astype(np.int64)[face_of]
            odd = (ids < 0) | (ids >= len(materials))
            wrong = odd & (ids != -1)  # -1 is how a face without texture is written
            if wrong.any():
                said.append(
                    f"{some(int(wrong.sum()), 'face')} with a texture number the header does not"
                    " have: without texture."
                )
            if odd.any():
                ids[odd] = len(materials)
                materials = (*materials, Material("no texture"))
        elif len(materials) > 1:
            said.append("Several textures, but no 'texnumber' per face: the first is used.")
        if np.any(np.diff(ids) < 0):
            order = np.argsort(ids, kind="stable")
            ids, faces = ids[order], faces[order]
            uv_corners = uv_corners[order] if has_wedges else uv_corners
        offsets = np.searchsorted(ids, np.arange(len(materials) + 1)).astype(np.int64)
    if has_wedges and len(faces):
        from vomstudio.io.models.formats import _obj_kernels

        # Each face has its own copies: equal values are one.
        pairs = uv_values[: len(uv_values) // 2 * 2].astype(np.float32).reshape(-1, 2)
        keys, same = np.unique(
            np.ascontiguousarray(pairs).view(np.int64).ravel(), return_inverse=True
        )
        worn = uv_corners >= 0
        uv_corners[worn] = same[uv_corners[worn]]
        pairs = keys.view(np.float32).reshape(-1, 2)
        faces, source, texture = _obj_kernels.split_vertices(faces, uv_corners, len(vertices))
        if len(source) > len(vertices):
            vertices = vertices[source]
            colors = None if colors is None else colors[source]
            fields = {name: values[source] for name, values in fields.items()}
        uv = np.full((len(source), 2), np.nan, np.float32)
        has = texture >= 0
        uv[has] = pairs[texture[has]]
    mesh = Mesh(vertices, faces, materials, offsets, uv, colors, fields)
    return drop_unsound(mesh, said, path)


def _whole(raw: npt.NDArray[Any]) -> npt.NDArray[np.int64]:
    """Indices that came as text or floats; -1, which is no vertex, for what is no index."""
    values = np.nan_to_num(raw, nan=-1.0)
    return np.where(np.abs(values) < 2.0**62, values, -1).astype(np.int64)


def _texture(name: str, index: int, path: Path, said: list[str]) -> Material:
    found, problem = find_beside(path.parent, name)
    if found is not None:
        wrong = check_image(found)
        if wrong:
            found, problem = None, wrong
    if problem:
        said.append(f"Texture {index + 1}: {problem}.")
    return Material(name, found)


READER = Reader("PLY mesh or cloud", (".ply",), matches, read)
