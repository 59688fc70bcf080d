"""OBJ files against an independent, plain parser of the same text."""

from __future__ import annotations

import math
import random
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image

from tests.messages import by_code
from vomstudio.core.errors import Cancelled, InputError
from vomstudio.core.progress import CancelToken, SilentProgress
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.formats import obj
from vomstudio.io.models.opening import read_model


def write(folder: Path, text: str | bytes, name: str = "model.obj") -> Path:
    path = folder / name
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def read_mesh(folder: Path, text: str | bytes) -> tuple[Mesh, dict[str, dict[str, Any]]]:
    loaded = read_model(write(folder, text))
    assert isinstance(loaded.data, Mesh), loaded.warnings
    return loaded.data, by_code(loaded.warnings)


def naive(text: str) -> tuple[list, list, list]:
    """Positions, texture coordinates and fans of (material, position, texture) corners."""
    v, vt, triangles, material = [], [], [], ""
    for line in text.splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] == "v":
            v.append(tuple(float(w) for w in words[1:4]))
        elif words[0] == "vt":
            vt.append(tuple(float(w) for w in words[1:3]))
        elif words[0] == "usemtl":
            material = words[1]
        elif words[0] == "f":
            corners = []
            for word in words[1:]:
                parts = word.split("/")
                a = int(parts[0])
                b = int(parts[1]) if len(parts) > 1 and parts[1] else None
                xyz = v[a - 1 if a > 0 else a]
                st_ = None if b is None else vt[b - 1 if b > 0 else b]
                corners.append((xyz, st_))
            for k in range(1, len(corners) - 1):
                triangles.append((material, corners[0], corners[k], corners[k + 1]))
    return v, vt, triangles


def corners_of(mesh: Mesh) -> list:
    found = []
    names = [m.name for m in mesh.materials] or [""]
    ids = (
        np.repeat(np.arange(len(names)), np.diff(mesh.material_offsets))
        if mesh.materials
        else (np.zeros(len(mesh.faces), int))
    )
    for face, id_ in zip(mesh.faces, ids, strict=True):
        row = [names[id_]]
        for k in face:
            uv = None
            if mesh.uv is not None and not np.isnan(mesh.uv[k]).any():
                uv = tuple(mesh.uv[k].tolist())
            row.append((tuple(mesh.vertices[k].tolist()), uv))
        found.append(tuple(row))
    return found


def as_float32(uv: tuple[float, float] | None) -> tuple[float, float] | None:
    return None if uv is None else tuple(np.float32(uv).tolist())


def expected_of(text: str) -> list:
    _, _, triangles = naive(text)
    order = list(dict.fromkeys(t[0] for t in triangles))
    triangles = sorted(triangles, key=lambda t: order.index(t[0]))
    return [(t[0], *((xyz, as_float32(uv)) for xyz, uv in t[1:])) for t in triangles]


coordinate = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False, width=64).map(repr),
    st.floats(-1e7, 1e7).map(lambda x: f"{x:.3f}"),
    st.integers(-(10**9), 10**9).map(str),
    st.floats(-1e3, 1e3).map(lambda x: f"{x:+.17e}"),
)
unit = st.floats(0, 1).map(lambda x: f"{x:.6f}")


@st.composite
def obj_texts(draw: st.DrawFn) -> str:
    n = draw(st.integers(3, 8))
    m = draw(st.integers(1, 5))
    lines = ["v " + " ".join(draw(st.tuples(*[coordinate] * 3))) for _ in range(n)]
    lines += ["vt " + " ".join(draw(st.tuples(unit, unit))) for _ in range(m)]
    for _ in range(draw(st.integers(1, 8))):
        if draw(st.booleans()):
            lines.append("usemtl " + draw(st.sampled_from("abc")))
        rows = draw(st.lists(st.integers(1, n), min_size=3, max_size=3, unique=True))
        form = draw(st.integers(0, 3))
        words = []
        for row in rows:
            a = row if draw(st.booleans()) else row - n - 1
            b = draw(st.integers(1, m))
            b = b if draw(st.booleans()) else b - m - 1
            words.append((f"{a}", f"{a}/{b}", f"{a}//1", f"{a}/{b}/1")[form])
        lines.append("f  " + "\t".join(words) + draw(st.sampled_from(["", " ", " # end"])))
        lines.append(draw(st.sampled_from(["", "# note", "g part", "s 1", "o thing", "vn 0 0 1"])))
    return draw(st.sampled_from(["\n", "\r\n"])).join(lines) + "\n"


@pytest.mark.full
@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
@given(text=obj_texts())
def test_valid_obj_matches_a_simple_parser(text: str, tmp_path: Path) -> None:
    plain = "\n".join(line.split("#")[0] for line in text.splitlines())
    mesh, _ = read_mesh(tmp_path, text)
    assert corners_of(mesh) == expected_of(plain)


def test_decimals_are_rounded_as_python_rounds_them(tmp_path: Path) -> None:
    rng = random.Random(7)
    words = []
    for _ in range(3000):
        bits = struct.unpack("<d", struct.pack("<Q", rng.getrandbits(64)))[0]
        if math.isfinite(bits):
            words.append(repr(bits))
        words.append(f"{rng.uniform(-1e7, 1e7):.{rng.randint(0, 17)}f}")
        words.append(f"{rng.getrandbits(rng.randint(1, 70))}e{rng.randint(-40, 30)}")
        # Halfway between two doubles, and a hair beside it.
        a = rng.uniform(1, 2) * 2.0 ** rng.randint(-3, 20)
        middle = f"{a + math.ulp(a) / 2:.18g}"
        words += [middle, middle + "1", f"{rng.random():.25f}"]
    words += [
        "0",
        "-0",
        ".5",
        "5.",
        "1E5",
        "1e-400",
        "1e308",
        "4.9e-324",
        "+7",
        "0.1",
        "1e22",
        "1e23",
    ]
    words = [w for w in words if math.isfinite(float(w))]
    words += ["0"] * (-len(words) % 3)
    lines = ["v " + " ".join(words[i : i + 3]) for i in range(0, len(words), 3)]
    mesh, _ = read_mesh(tmp_path, "\n".join(lines) + "\nf 1 2 3\n")
    expected = np.array([float(w) for w in words])
    assert mesh.vertices.reshape(-1).tobytes() == expected.tobytes()


def test_separately_parsed_blocks_join_seamlessly(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(3)
    lines = []
    for k in range(400):
        lines.append("v {} {} {}".format(*rng.random(3).round(5)))
        lines.append("vt {} {}".format(*rng.random(2).round(5)))
        if k % 50 == 3:
            lines.append(f"usemtl m{k % 3}")
        if k > 4:
            a, b, c = rng.choice(5, 3, replace=False) + 1
            lines.append(f"f -{a}/-{b} -{b}/-{c} {k - c}/{k}")
    text = "\n".join(lines) + "\n"
    whole, _ = read_mesh(tmp_path, text)
    monkeypatch.setattr(obj, "BLOCK_BYTES", 97)
    cut, _ = read_mesh(tmp_path, text)
    assert corners_of(cut) == corners_of(whole) == expected_of(text)


def test_vertex_with_two_texture_coordinates_is_duplicated(tmp_path: Path) -> None:
    mesh, _ = read_mesh(
        tmp_path,
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt .5 .5\n"
        "f 1/1 2/2 3/3\nf 1/4 3/3 4/1\n",
    )
    assert len(mesh.vertices) == 5
    assert mesh.uv is not None
    assert mesh.uv[mesh.faces[0, 0]].tolist() == [0, 0]
    assert mesh.uv[mesh.faces[1, 0]].tolist() == [0.5, 0.5]
    assert (mesh.vertices[mesh.faces[0, 0]] == mesh.vertices[mesh.faces[1, 0]]).all()


def test_untextured_faces_in_textured_mesh_have_nan_uv(tmp_path: Path) -> None:
    mesh, _ = read_mesh(
        tmp_path,
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\nf 1 3 4\n",
    )
    assert mesh.uv is not None
    assert not np.isnan(mesh.uv[mesh.faces[0]]).any()
    assert np.isnan(mesh.uv[mesh.faces[1]]).all()


@pytest.mark.parametrize("scale", [1, 255])
def test_vertex_colors_may_range_to_1_or_255(tmp_path: Path, scale: int) -> None:
    rows = [(1, 0, 0), (0, 1, 0), (0.2, 0.4, 1)]
    text = "".join(
        f"v {k} {k * k} 0 " + " ".join(str(c * scale) for c in row) + "\n"
        for k, row in enumerate(rows)
    )
    mesh, _ = read_mesh(tmp_path, text + "f 1 2 3\n")
    assert mesh.colors is not None
    assert mesh.colors.tolist() == [[255, 0, 0], [0, 255, 0], [51, 102, 255]]


def test_vertex_weight_is_not_read_as_color(tmp_path: Path) -> None:
    mesh, _ = read_mesh(tmp_path, "v 0 0 0 1\nv 1 0 0 1\nv 0 1 0 1\nf 1 2 3\n")
    assert mesh.colors is None


def test_old_mac_line_ends_and_continued_lines_are_parsed(tmp_path: Path) -> None:
    mesh, findings = read_mesh(
        tmp_path, "v 0 0 \\\n 0\r\nv 1 0 0\nv 1 1 0\nf 1 \\\r\n 2 3\nf 1 2 9\n"
    )
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0]]
    assert len(mesh.faces) == 1
    assert findings["model.faces-without-vertices"]["line"] == 7
    mesh, _ = read_mesh(tmp_path, "v 0 0 0\rv 1 0 0\rv 1 1 0\rf 1 2 3\r")
    assert len(mesh.faces) == 1


def area(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def shoelace(ring: list[tuple[float, float]]) -> float:
    return abs(sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(ring, ring[1:] + ring[:1]))) / 2  # noqa: B905


@pytest.mark.parametrize(
    "ring",
    [
        [(0, 0), (4, 0), (4, 4), (0, 4)],
        [(1, 1), (4, 0), (0, 0), (0, 4)],
        [(0, 0), (4, 0), (1, 1), (0, 4)],
        [(0, 0), (4, 0), (4, 4), (2, 1), (0, 4)],
        [
            (0, 0),
            (5, 0),
            (5, 3),
            (4, 3),
            (4, 1),
            (3, 1),
            (3, 3),
            (2, 3),
            (2, 1),
            (1, 1),
            (1, 3),
            (0, 3),
        ],
    ],
)
@pytest.mark.parametrize("turn", range(4))
def test_the_triangles_of_a_polygon_cover_it_once(
    tmp_path: Path, ring: list[tuple[float, float]], turn: int
) -> None:
    ring = ring[turn:] + ring[:turn]
    tilted = "".join(f"v {x} {0.8 * y} {0.6 * y}\nvt {x / 9} {y / 9}\n" for x, y in ring)
    text = tilted + "f " + " ".join(f"{k}/{k}" for k in range(1, len(ring) + 1)) + "\n"
    mesh, _ = read_mesh(tmp_path, text)
    assert len(mesh.faces) == len(ring) - 2
    assert area(mesh) == pytest.approx(shoelace(ring))
    assert mesh.uv is not None
    assert np.allclose(mesh.uv[:, 0] * 9, mesh.vertices[:, 0], atol=1e-6)


def test_invalid_vertices_and_faces_are_skipped_and_counted(tmp_path: Path) -> None:
    mesh, findings = read_mesh(
        tmp_path,
        "v 0 0 0\nv nan 0 0\nv 1 0 0\nv 1 1 0\nv x 1 2\nv 1\nv 2 inf 0\n"
        "f 1 3 4\nf 1 2 3\nf 1 3 99\nf 1 3 0\nf 3 3 4\nf 1 3\nf 1 a 3\n",
    )
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0]]
    assert mesh.faces.tolist() == [[0, 1, 2], [1, 1, 2]]
    assert findings == {
        "model.points-invalid": {"count": 4},
        "model.values-not-numbers": {"count": 1, "line": 5},
        "model.faces-without-vertices": {"count": 3, "line": 10},
        "model.faces-incomplete": {"count": 1},
        "model.faces-invalid": {"count": 1},
        "model.faces-without-area": {"count": 1},
    }


def test_materials_keep_their_faces_if_some_are_skipped(tmp_path: Path) -> None:
    text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv nan 0 0\n" + (
        "usemtl a\nf 1 2 3\nf 1 2 4\nusemtl b\nf 1 2 9\nf 3 2 1\n"
        "usemtl a\nf 2 3 1\nusemtl c\nf 1 2 8\n"
    )
    mesh, _ = read_mesh(tmp_path, text)
    assert [m.name for m in mesh.materials] == ["a", "b", "c"]
    assert mesh.material_offsets.tolist() == [0, 2, 3, 3]
    assert mesh.faces.tolist() == [[0, 1, 2], [1, 2, 0], [2, 1, 0]]


def test_points_without_faces_become_a_cloud_with_a_warning(tmp_path: Path) -> None:
    loaded = read_model(write(tmp_path, "v 0 0 0\nv 1 2 3\n"))
    assert loaded.kind == "cloud"
    assert isinstance(loaded.data, PointCloud)
    assert "model.opened-as-cloud" in by_code(loaded.warnings)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\n\n",
        b"# nothing\n",
        b"v nan nan nan\n",
        b"f 1 2 3\n",
        b"\x00\x01\x02\x03" * 99,
        b"hello world\nthis is prose\n",
        b"vt 0 0\n",
    ],
)
def test_file_without_model_is_rejected_by_name(tmp_path: Path, content: bytes) -> None:
    path = write(tmp_path, content)
    with pytest.raises(InputError) as caught:
        read_model(path)
    assert str(path) in str(caught.value)


def test_last_line_without_line_end_is_reported(tmp_path: Path) -> None:
    _, findings = read_mesh(tmp_path, "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3")
    assert "model.maybe-cut-short" in findings


def test_truncated_obj_gives_model_or_input_error(tmp_path: Path) -> None:
    text = (
        b"mtllib model.mtl\nv 1.5 2.5e0 3 1 0 0\nv 4 5 6 0 1 0\nv 7 8 0 0 0 1\nv 1 1 1 1 1 1\n"
        b"vt 0 1\nvt 1 1\nvt .5 0\nusemtl stone\nf 1/1/1 2/2 3/3 4/1\n"
        b"f -1 -2 \\\n -3\nusemtl x\nf 1 2 4\n"
    )
    write(tmp_path, b"newmtl stone\nmap_Kd gone.jpg\n", "model.mtl")
    for n in range(len(text)):
        try:
            read_model(write(tmp_path, text[:n]))
        except InputError:
            continue


@settings(max_examples=200, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    data=st.one_of(
        st.binary(max_size=300),
        st.text("vftusemlib 0123456789.-+e/\\\n\r#\tnan", max_size=300).map(str.encode),
    )
)
def test_arbitrary_bytes_give_model_or_input_error(data: bytes, tmp_path: Path) -> None:
    try:
        loaded = read_model(write(tmp_path, data))
    except InputError:
        return
    assert np.isfinite(loaded.data.bounds).all()
    if isinstance(loaded.data, Mesh):
        assert 0 <= loaded.data.faces.min() <= loaded.data.faces.max() < len(loaded.data.vertices)


def test_reading_stops_when_it_is_cancelled(tmp_path: Path) -> None:
    token = CancelToken()
    token.cancel()
    with pytest.raises(Cancelled):
        read_model(write(tmp_path, "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"), SilentProgress(token))


def test_textures_are_found_beside_the_model(tmp_path: Path) -> None:
    Image.new("RGB", (4, 4)).save(tmp_path / "my photo.jpg")
    (tmp_path / "two words.mtl").write_text("newmtl a\nKd .2 .4 .6\nmap_Kd -s 1 1 1 my photo.jpg\n")
    mesh, findings = read_mesh(
        tmp_path,
        "mtllib two words.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 3 2 1\n"
        "usemtl a\nf 1 2 3\nusemtl b\nf 2 3 1\n",
    )
    assert [m.name for m in mesh.materials] == ["", "a", "b"]
    assert mesh.materials[1].texture == tmp_path / "my photo.jpg"
    assert mesh.materials[1].diffuse == (0.2, 0.4, 0.6)
    assert mesh.materials[2].texture is None
    assert findings["material.missing"]["names"] == ("b",)


def test_several_libraries_may_share_one_line(tmp_path: Path) -> None:
    (tmp_path / "a.mtl").write_text("newmtl a\nKd 1 0 0\n")
    (tmp_path / "b.mtl").write_text("newmtl b\nKd 0 1 0\n")
    mesh, findings = read_mesh(
        tmp_path,
        "mtllib a.mtl b.mtl gone.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\n"
        "usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n",
    )
    assert [m.diffuse for m in mesh.materials] == [(1, 0, 0), (0, 1, 0)]
    assert "material.file-unusable" in findings


def test_missing_material_file_is_reported_and_geometry_loads(tmp_path: Path) -> None:
    mesh, findings = read_mesh(
        tmp_path, "mtllib no.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"
    )
    assert len(mesh.faces) == 1
    assert "material.file-unusable" in findings


def test_the_survey_model_keeps_its_millimetres_and_textures(data_dir: Path) -> None:
    path = data_dir / "brighton_model" / "brighton_utm15n.obj"
    loaded = read_model(path)
    mesh = loaded.data
    assert isinstance(mesh, Mesh)
    assert loaded.warnings == ()
    v, _, triangles = naive(path.read_text())
    assert np.array_equal(mesh.vertices, np.array(v))
    assert len(mesh.faces) == len(triangles) == 133_830
    names = [t[0] for t in triangles]
    assert [m.name for m in mesh.materials] == list(dict.fromkeys(names))
    for k, material in enumerate(mesh.materials):
        assert mesh.material_offsets[k + 1] - mesh.material_offsets[k] == names.count(material.name)
        assert material.texture is not None
        assert material.texture.is_file()
    assert len({m.texture for m in mesh.materials}) == 9
    expected = np.array([[c[0] for c in t[1:]] for t in triangles])
    assert np.array_equal(mesh.vertices[mesh.faces], expected)
    uv = np.array([[c[1] for c in t[1:]] for t in triangles], np.float32)
    assert mesh.uv is not None
    assert np.array_equal(mesh.uv[mesh.faces], uv)
    low, high = mesh.bounds
    assert low[:2].round(2).tolist() == [576665.72, 5188117.06]
    assert high[:2].round(2).tolist() == [576765.32, 5188208.90]


def test_byte_order_mark_does_not_lose_the_first_vertex(tmp_path: Path) -> None:
    mesh, findings = read_mesh(tmp_path, b"\xef\xbb\xbfv 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n")
    assert mesh.vertices[0].tolist() == [0, 0, 0]
    assert findings == {}


def test_a_polygon_of_very_many_corners_is_still_a_fan(tmp_path: Path) -> None:
    n = 3000
    angles = np.linspace(0, 2 * np.pi, n, endpoint=False)
    text = "".join(f"v {math.cos(a)} {math.sin(a)} 0\n" for a in angles)
    mesh, _ = read_mesh(tmp_path, text + "f " + " ".join(map(str, range(1, n + 1))) + "\n")
    assert len(mesh.faces) == n - 2
    assert area(mesh) == pytest.approx(n / 2 * math.sin(2 * math.pi / n))


def test_vertex_colors_are_read_if_the_first_vertex_has_none(tmp_path: Path) -> None:
    text = "v 0 0 0\nv 1 0 0 1 0 0\nv 1 1 0 0 0.5 1\nv 0 1 0\nf 1 2 3\nf 1 3 4\n"
    mesh, _ = read_mesh(tmp_path, text)
    assert mesh.colors.tolist() == [[255] * 3, [255, 0, 0], [0, 128, 255], [255] * 3]
    plain, _ = read_mesh(tmp_path, "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n")
    assert plain.colors is None


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig"])
def test_obj_and_mtl_in_other_encodings_are_read(tmp_path: Path, encoding: str) -> None:
    text = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl Schluff_ä\nf 1 2 3\n"
    library = "newmtl Schluff_ä\nKd 1 0.5 0\n"
    (tmp_path / "a.mtl").write_bytes(library.encode(encoding))
    mesh, findings = read_mesh(tmp_path, text.encode(encoding))
    assert findings == {}
    assert [(m.name, m.diffuse) for m in mesh.materials] == [("Schluff_ä", (1.0, 0.5, 0.0))]
    assert len(mesh.faces) == 1
