"""PLY files: the same content in all encodings, and what damage does."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image

from tests.messages import by_code, refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import InputError
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.opening import read_model

FORMATS = ["ascii", "binary_little_endian", "binary_big_endian"]
CODES = {
    "char": "b",
    "uchar": "B",
    "short": "h",
    "ushort": "H",
    "int": "i",
    "uint": "I",
    "float": "f",
    "double": "d",
}


def encode(form: str, elements: list, comments: tuple[str, ...] = ()) -> bytes:
    """elements: (name, properties, records); a property is 'type name' or 'list count type name'.
    An independent writer, record by record."""
    lines = ["ply", f"format {form} 1.0", *(f"comment {c}" for c in comments)]
    for name, properties, records in elements:
        lines.append(f"element {name} {len(records)}")
        lines += [f"property {p}" for p in properties]
    body = bytearray()
    order = ">" if "big" in form else "<"
    for _, properties, records in elements:
        for record in records:
            words = []
            for p, value in zip(properties, record, strict=True):
                kinds = p.split()
                if kinds[0] == "list":
                    words += [str(len(value)), *map(repr, value)]
                    body += (
                        b""
                        if form == "ascii"
                        else struct.pack(
                            order + CODES[kinds[1]] + CODES[kinds[2]] * len(value),
                            len(value),
                            *value,
                        )
                    )
                else:
                    words.append(repr(value))
                    body += b"" if form == "ascii" else struct.pack(order + CODES[kinds[0]], value)
            if form == "ascii":
                body += (" ".join(words) + "\n").encode()
    return "\n".join([*lines, "end_header\n"]).encode() + bytes(body)


def save(folder: Path, content: bytes) -> Path:
    path = folder / "model.ply"
    path.write_bytes(content)
    return path


XYZ = ["double x", "double y", "double z"]
SQUARE = [
    (576665.123, 5188117.5, 0.0),
    (576666.123, 5188117.5, 0.0),
    (576666.123, 5188118.5, 0.0),
    (576665.123, 5188118.5, 0.0),
]


@pytest.mark.parametrize("form", first_in_default_tier(FORMATS))
def test_coordinates_stay_double(tmp_path: Path, form: str) -> None:
    loaded = read_model(save(tmp_path, encode(form, [("vertex", XYZ, SQUARE)])))
    assert isinstance(loaded.data, PointCloud)
    assert loaded.data.points.tolist() == [list(p) for p in SQUARE]
    assert loaded.warnings == ()


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("count", ["uchar", "int", "ushort"])
def test_triangles_and_polygons_become_fans(tmp_path: Path, form: str, count: str) -> None:
    for faces, wanted in (
        ([[0, 1, 2], [0, 2, 3]], [[0, 1, 2], [0, 2, 3]]),
        ([[0, 1, 2, 3]], [[0, 1, 2], [0, 2, 3]]),
        ([[0, 1, 2], [3, 2, 1, 0], [1, 2, 3]], [[0, 1, 2], [3, 2, 1], [3, 1, 0], [1, 2, 3]]),
    ):
        records = [(1.5, face, 7) for face in faces]
        properties = ["float quality", f"list {count} int vertex_index", "int tag"]
        content = encode(form, [("vertex", XYZ, SQUARE), ("face", properties, records)])
        loaded = read_model(save(tmp_path, content))
        assert isinstance(loaded.data, Mesh)
        assert loaded.data.faces.tolist() == wanted
        assert loaded.warnings == ()


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize(
    ("kind", "white"), [("uchar", 255), ("ushort", 65535), ("float", 1.0), ("float", 255.0)]
)
@pytest.mark.parametrize("prefix", ["", "diffuse_"])
def test_colours_of_every_type_are_bytes(
    tmp_path: Path, form: str, kind: str, white: float, prefix: str
) -> None:
    properties = XYZ + [f"{kind} {prefix}{c}" for c in ("red", "green", "blue")]
    zero = type(white)(0)
    rows = [(*p, white, zero, white) for p in SQUARE]
    data = read_model(save(tmp_path, encode(form, [("vertex", properties, rows)]))).data
    assert data.colors is not None
    assert data.colors.tolist() == [[255, 0, 255]] * 4
    assert data.fields == {}


@pytest.mark.parametrize("form", FORMATS)
def test_normals_and_fields_of_all_types_are_kept(tmp_path: Path, form: str) -> None:
    values = {
        "char": -7,
        "uchar": 200,
        "short": -300,
        "ushort": 60000,
        "int": -(2**31),
        "uint": 2**32 - 1,
        "float": 0.5,
        "double": 1e300,
    }
    properties = XYZ + ["float nx", "float ny", "float nz"] + [f"{t} scalar_{t}" for t in values]
    rows = [(*p, 0.0, 0.0, 1.0, *values.values()) for p in SQUARE]
    extra = ("camera", ["list uchar double pose"], [([1.0, 2.0],), ([],)])
    data = read_model(save(tmp_path, encode(form, [extra, ("vertex", properties, rows)]))).data
    assert isinstance(data, PointCloud)
    assert data.normals is not None
    assert data.normals.tolist() == [[0, 0, 1]] * 4
    for kind, value in values.items():
        field = data.fields[f"scalar_{kind}"]
        assert field.dtype.char == np.dtype(CODES[kind]).char
        assert field.tolist() == [value] * 4


@pytest.mark.parametrize("form", FORMATS)
def test_texture_coordinates_per_face_and_several_textures_are_read(
    tmp_path: Path, form: str
) -> None:
    for k in range(2):
        Image.new("RGB", (2, 2)).save(tmp_path / f"tex {k}.jpg")
    properties = ["list uchar int vertex_indices", "list uchar float texcoord", "int texnumber"]
    faces = [
        ([0, 1, 2], [0.0, 0.0, 1.0, 0.0, 1.0, 1.0], 1),
        ([0, 2, 3], [0.0, 0.0, 1.0, 1.0, 0.0, 1.0], 0),
        ([1, 2, 3], [0.5, 0.5, 1.0, 1.0, 0.0, 0.25], 1),
    ]
    content = encode(
        form,
        [("vertex", XYZ, SQUARE), ("face", properties, faces)],
        ("TextureFile tex 0.jpg", "TextureFile tex 1.jpg"),
    )
    loaded = read_model(save(tmp_path, content))
    mesh = loaded.data
    assert isinstance(mesh, Mesh)
    assert loaded.warnings == ()
    assert [m.texture for m in mesh.materials] == [tmp_path / "tex 0.jpg", tmp_path / "tex 1.jpg"]
    assert mesh.material_offsets.tolist() == [0, 1, 3]
    assert mesh.uv is not None
    for row, (corners, uv, _) in zip(mesh.faces, [faces[1], faces[0], faces[2]], strict=True):
        assert mesh.vertices[row].tolist() == [list(SQUARE[c]) for c in corners]
        assert mesh.uv[row].ravel().tolist() == uv
    assert len(mesh.vertices) == 6  # two vertices are seen with two coordinates each


@pytest.mark.parametrize("names", [("s", "t"), ("u", "v"), ("texture_u", "texture_v")])
def test_texture_coordinates_per_vertex_are_read(tmp_path: Path, names: tuple[str, str]) -> None:
    rows = [(*p, 0.25, 0.75) for p in SQUARE]
    content = encode(
        "ascii",
        [
            ("vertex", XYZ + [f"float {n}" for n in names], rows),
            ("face", ["list uchar int vertex_indices"], [([0, 1, 2],)]),
        ],
        ("TextureFile ../../etc/passwd",),
    )
    loaded = read_model(save(tmp_path, content))
    assert isinstance(loaded.data, Mesh)
    assert loaded.data.uv is not None
    assert loaded.data.uv.tolist() == [[0.25, 0.75]] * 4
    assert loaded.data.materials[0].texture is None
    assert loaded.warnings[0].code == "texture.unusable"


def test_invalid_vertices_and_faces_are_skipped_and_counted(tmp_path: Path) -> None:
    rows = [*SQUARE, (float("nan"), 0.0, 0.0)]
    faces = [([0, 1, 2],), ([0, 1, 4],), ([0, 1, 77],), ([0, -1, 2],), ([0, 1],), ([2, 2, 1],)]
    for form in FORMATS:
        content = encode(
            form, [("vertex", XYZ, rows), ("face", ["list uchar int vertex_indices"], faces)]
        )
        loaded = read_model(save(tmp_path, content))
        assert isinstance(loaded.data, Mesh)
        assert loaded.data.faces.tolist() == [[0, 1, 2], [2, 2, 1]]
        assert by_code(loaded.warnings) == {
            "model.points-invalid": {"count": 1},
            "model.faces-invalid": {"count": 1},
            "model.faces-without-vertices": {"count": 2},
            "model.faces-incomplete": {"count": 1},
            "model.faces-without-area": {"count": 1},
        }


@pytest.mark.parametrize("form", FORMATS)
def test_fewer_records_than_declared_are_read_with_a_warning(tmp_path: Path, form: str) -> None:
    content = encode(form, [("vertex", XYZ, SQUARE)])
    content = content.replace(b"element vertex 4", b"element vertex 1000000000000")
    loaded = read_model(save(tmp_path, content))
    assert len(loaded.data.points) == 4  # type: ignore[union-attr]
    values = by_code(loaded.warnings)["model.incomplete"]
    assert (values["count"], values["promised"]) == (4, 10**12)


@pytest.mark.parametrize("form", FORMATS)
def test_list_longer_than_the_file_is_truncated(tmp_path: Path, form: str) -> None:
    content = encode(
        form,
        [
            ("vertex", XYZ, SQUARE),
            ("face", ["list uint int vertex_indices"], [([0, 1, 2],), ([0, 2, 3],)]),
        ],
    )
    if form == "ascii":
        content = content.replace(b"3 0 2 3", b"999999999 0 2 3")
    else:
        order = ">" if "big" in form else "<"
        content = content[:-16] + struct.pack(order + "I", 2**32 - 1) + content[-12:]
    loaded = read_model(save(tmp_path, content))
    assert isinstance(loaded.data, Mesh)
    assert loaded.data.faces.tolist() == [[0, 1, 2]]
    assert loaded.warnings


@pytest.mark.parametrize("form", first_in_default_tier(FORMATS))
def test_truncated_ply_gives_model_or_input_error(tmp_path: Path, form: str) -> None:
    content = encode(
        form,
        [
            (
                "vertex",
                [*XYZ, "uchar red", "uchar green", "uchar blue", "list uchar short odd"],
                [(*p, 1, 2, 3, [1] * k) for k, p in enumerate(SQUARE)],
            ),
            (
                "face",
                ["list uchar int vertex_indices", "float q"],
                [([0, 1, 2], 1.0), ([0, 1, 2, 3], 1.0)],
            ),
        ],
    )
    for n in range(len(content)):
        path = save(tmp_path, content[:n])
        try:
            loaded = read_model(path)
        except InputError as error:
            if error.file != str(path):
                raise
            continue
        assert np.isfinite(loaded.data.bounds).all()
        if n < len(content) - (form == "ascii"):
            assert loaded.warnings


GOOD = encode("ascii", [("vertex", XYZ, SQUARE)]).decode()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("ply", "plx"),
        ("ascii", "utf8"),
        ("element vertex 4", "element vertex -4"),
        ("element vertex 4", "element vertex four"),
        ("element vertex 4", "element vertex"),
        ("property double x", "property triple x"),
        ("property double x", "property list"),
        ("property double x", "property list uchar"),
        ("property double x", "property"),
        ("property double x", "property list float int x"),
        ("property double y", "property double x"),
        ("end_header", "end"),
        ("double z", "double height"),
        ("element vertex 4", "element vertex 0"),
        ("element vertex 4\n", ""),
        ("format ascii 1.0\n", ""),
        ("element vertex", "element point"),
        ("element vertex 4", "element vertex " + "9" * 30),
    ],
)
def test_invalid_header_is_rejected_by_name(tmp_path: Path, old: str, new: str) -> None:
    path = save(tmp_path, GOOD.replace(old, new, 1).encode())
    with pytest.raises(InputError) as caught:
        read_model(path)
    assert str(path) in str(caught.value)


def test_binary_data_with_ascii_header_is_rejected(tmp_path: Path) -> None:
    content = encode("binary_little_endian", [("vertex", XYZ, SQUARE)])
    with refused("file.damaged", format="PLY"):
        read_model(save(tmp_path, content.replace(b"binary_little_endian", b"ascii")))


def test_windows_line_ends_are_read_and_non_numeric_words_skipped(tmp_path: Path) -> None:
    text = GOOD.replace("0.0\n", "abc\n", 1).replace("\n", "\r\n")
    loaded = read_model(save(tmp_path, text.encode()))
    assert len(loaded.data.points) == 3  # type: ignore[union-attr]
    assert by_code(loaded.warnings)["model.values-not-numbers"]["line"] == 8


@settings(max_examples=200, deadline=None, suppress_health_check=list(HealthCheck))
@given(form=st.sampled_from(FORMATS), at=st.integers(0, 400), new=st.binary(max_size=6))
def test_damaged_bytes_give_model_or_input_error(
    form: str, at: int, new: bytes, tmp_path: Path
) -> None:
    content = encode(
        form,
        [
            (
                "vertex",
                [*XYZ, "ushort red", "ushort green", "ushort blue"],
                [(*p, 1, 2, 3) for p in SQUARE],
            ),
            ("face", ["list uchar int vertex_indices"], [([0, 1, 2],), ([0, 1, 2, 3],)]),
        ],
    )
    try:
        loaded = read_model(save(tmp_path, content[:at] + new + content[at + len(new) :]))
    except InputError:
        return
    if isinstance(loaded.data, Mesh):
        assert 0 <= loaded.data.faces.min() <= loaded.data.faces.max() < len(loaded.data.vertices)


@pytest.mark.parametrize("form", FORMATS)
def test_triangles_beyond_the_vertices_are_counted(tmp_path: Path, form: str) -> None:
    faces = [([0, 1, 2],), ([0, 1, 4],), ([-1, 1, 2],), ([0, 2, 3],)]
    content = encode(
        form, [("vertex", XYZ, SQUARE), ("face", ["list uchar int vertex_indices"], faces)]
    )
    loaded = read_model(save(tmp_path, content))
    assert isinstance(loaded.data, Mesh)
    assert loaded.data.faces.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert by_code(loaded.warnings)["model.faces-without-vertices"] == {"count": 2}


@pytest.mark.parametrize("form", FORMATS)
def test_triangle_strips_give_consistently_oriented_faces(tmp_path: Path, form: str) -> None:
    """Two strips of a plane of 4 by 2, one of them begun anew after -1: area 8, all normals up."""
    place = {}
    for x in range(5):
        for y in range(3):
            place[x, y] = len(place)
    points = [(float(x), float(y), 0.0) for x, y in place]
    rows = [[place[x, y + k] for x in range(5) for k in (1, 0)] for y in range(2)]
    strip = [*rows[0], -1, *rows[1]]
    strips = [("tristrips", ["list int int vertex_indices"], [(strip,)])]
    if form != "ascii":
        strips = [("tristrips", ["list int int vertex_indices"], [(rows[0],), (rows[1],)])]
    loaded = read_model(save(tmp_path, encode(form, [("vertex", XYZ, points), *strips])))
    assert isinstance(loaded.data, Mesh)
    assert loaded.warnings == ()
    a, b, c = loaded.data.vertices[loaded.data.faces].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a) / 2
    assert len(normals) == 16
    assert np.allclose(normals, [0, 0, 0.5])


def test_strips_and_faces_are_joined_and_unread_elements_are_reported(tmp_path: Path) -> None:
    elements = [
        ("vertex", XYZ, SQUARE),
        ("face", ["list uchar int vertex_indices"], [([0, 1, 2],)]),
        ("tristrips", ["list int int vertex_indices"], [([0, 1, 2, -1, 0, 0, 1],)]),
        ("camera", ["float focal"], [(1.5,)]),
    ]
    loaded = read_model(save(tmp_path, encode("ascii", elements)))
    assert loaded.data.faces.tolist() == [[0, 1, 2], [0, 1, 2]]
    assert by_code(loaded.warnings)["model.elements-left-out"] == {"elements": ("camera",)}


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig"])
def test_text_of_another_encoding_is_read(tmp_path: Path, encoding: str) -> None:
    text = encode("ascii", [("vertex", XYZ, SQUARE)]).decode()
    found = read_model(save(tmp_path, text.encode(encoding))).data
    assert np.array_equal(found.points, np.array(SQUARE)[:, :3])


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("prefix", ["", "diffuse_"])
def test_unused_face_colors_are_reported(tmp_path: Path, form: str, prefix: str) -> None:
    colours = [f"uchar {prefix}{name}" for name in ("red", "green", "blue")]
    faces = [([0, 1, 2], 255, 0, 0), ([0, 2, 3], 0, 255, 0)]
    properties = ["list uchar int vertex_indices", *colours]
    content = encode(form, [("vertex", XYZ, SQUARE), ("face", properties, faces)])
    loaded = read_model(save(tmp_path, content))
    assert isinstance(loaded.data, Mesh)
    assert loaded.data.colors is None
    (finding,) = loaded.warnings
    assert finding.code == "model.face-colors-unused"


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("cut", [0, 7])
def test_blockwise_read_matches_whole_file_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, form: str, cut: int
) -> None:
    """Polygons with and without texture coordinates of their own, two textures, unsound corners."""
    rng = np.random.default_rng(8)
    vertices = [(*row, 7) for row in rng.uniform(0, 9, (60, 3)).round(3).tolist()]
    faces = []
    for _ in range(80):
        n = int(rng.integers(2, 7))
        uv = rng.uniform(0, 1, 2 * n).round(3).tolist() if rng.random() < 0.6 else []
        faces.append((rng.choice(61, n, replace=False).tolist(), uv, int(rng.integers(0, 2))))
    for name, color in (("a.png", (9, 9, 9)), ("b.png", (200, 0, 0))):
        Image.new("RGB", (4, 4), color).save(tmp_path / name)
    content = encode(
        form,
        [
            ("vertex", ["double x", "double y", "double z", "short age"], vertices),
            (
                "face",
                ["list uchar int vertex_indices", "list uchar double texcoord", "uchar texnumber"],
                faces,
            ),
        ],
        ("TextureFile a.png", "TextureFile b.png"),
    )
    path = save(tmp_path, content[: len(content) - cut])
    found = []
    for at_once in (1 << 20, 11, 3, 1):
        monkeypatch.setattr("vomstudio.io.models.formats._ply_tables.VALUES_PER_STEP", at_once)
        monkeypatch.setattr("vomstudio.io.models.formats.ply.BLOCK_ROWS", at_once)
        loaded = read_model(path)
        mesh = loaded.data
        assert isinstance(mesh, Mesh)
        assert mesh.uv is not None
        found.append((mesh, loaded.warnings))
    (whole, findings), *others = found
    assert whole.uv is not None
    assert len(whole.faces) > 100
    assert len(findings) > 1
    for mesh, warnings in others:
        assert warnings == findings
        assert np.array_equal(mesh.vertices, whole.vertices)
        assert np.array_equal(mesh.faces, whole.faces)
        assert np.array_equal(mesh.uv, whole.uv, equal_nan=True)
        assert np.array_equal(mesh.material_offsets, whole.material_offsets)
        assert np.array_equal(mesh.fields["age"], whole.fields["age"])


@pytest.mark.parametrize("word", ["nan", "-1e30", "1e30", "2147483648", "-3"])
def test_invalid_corner_index_drops_only_its_face(tmp_path: Path, word: str) -> None:
    content = encode(
        "ascii",
        [
            (
                "vertex",
                ["float x", "float y", "float z"],
                [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)],
            ),
            ("face", ["list uchar uint vertex_indices"], [([0, 1, 2],), ([1, 3, 2],)]),
        ],
    ).replace(b"3 1 3 2", b"3 1 " + word.encode() + b" 2")
    loaded = read_model(save(tmp_path, content))
    assert isinstance(loaded.data, Mesh)
    assert loaded.data.faces.tolist() == [[0, 1, 2]]
    assert any(each.values.get("count") == 1 for each in loaded.warnings)


def test_truncated_last_line_is_not_counted_as_a_short_line(tmp_path: Path) -> None:
    content = encode(
        "ascii", [("vertex", ["float x", "float y", "float z"], [(1, 2, 3), (4, 5, 6), (7, 8, 9)])]
    )
    assert content.endswith(b"4 5 6\n7 8 9\n")
    content = content.replace(b"vertex 3", b"vertex 9").replace(b"4 5 6\n7 8 9\n", b"4 5\n7 8")
    loaded = read_model(save(tmp_path, content))
    assert isinstance(loaded.data, PointCloud)
    assert loaded.data.points.tolist() == [[1, 2, 3]]
    assert by_code(loaded.warnings)["model.short-lines"] == {"count": 1}
