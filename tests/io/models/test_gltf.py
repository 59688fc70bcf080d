"""GLB and glTF: frames, images, odd but lawful scenes, damage."""

from __future__ import annotations

import base64
import io
import json
import shutil
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image

from tests.messages import by_code, refused
from vomstudio.core.errors import Cancelled, InputError
from vomstudio.core.progress import CancelToken, SilentProgress
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models import image_store, model_cache
from vomstudio.io.models.opening import read_model

# A roof of two triangles, in metres, Z up: a ridge from west to east.
ROOF = np.array([[0, 0, 0], [4, 0, 0], [4, 1, 1], [0, 1, 1], [0, 2, 0]], float)
ROOF_FACES = np.array([[0, 1, 2], [0, 2, 3]])


def png(color: tuple[int, int, int] = (200, 100, 50), side: int = 4) -> bytes:
    stream = io.BytesIO()
    Image.new("RGB", (side, side), color).save(stream, "PNG")
    return stream.getvalue()


def y_up(points: np.ndarray) -> np.ndarray:
    """(x East, y North, z Up) as glTF has it: x East, y Up, z South."""
    return np.stack([points[:, 0], points[:, 2], -points[:, 1]], axis=1).astype("<f4")


class Scene:
    """A glTF scene under construction: its JSON, and one buffer."""

    def __init__(self) -> None:
        self.body = b""
        self.json: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": []}],
            "accessors": [],
            "bufferViews": [],
            "buffers": [],
        }

    def view(self, content: bytes) -> int:
        self.json["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(self.body), "byteLength": len(content)}
        )
        self.body += content + b"\0" * (-len(content) % 4)
        return len(self.json["bufferViews"]) - 1

    def accessor(self, values: np.ndarray, **more: Any) -> int:
        kinds = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
        table = np.atleast_2d(values.T).T
        kind = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}[table.shape[1]]
        self.json["accessors"].append(
            {
                "bufferView": self.view(np.ascontiguousarray(table).tobytes()),
                "componentType": kinds[table.dtype.str[1:]],
                "count": len(table),
                "type": kind,
                **more,
            }
        )
        return len(self.json["accessors"]) - 1

    def primitive(self, points: np.ndarray, faces: np.ndarray | None = None, **more: Any) -> dict:
        made: dict[str, Any] = {"attributes": {"POSITION": self.accessor(y_up(points))}, **more}
        if faces is not None:
            made["indices"] = self.accessor(faces.reshape(-1).astype("<u2"))
        self.json["meshes"][0]["primitives"].append(made)
        return made

    def glb(self, path: Path) -> Path:
        self.json["buffers"] = [{"byteLength": len(self.body)}]
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        size = 28 + len(text) + len(self.body)
        path.write_bytes(
            struct.pack("<4sIII4s", b"glTF", 2, size, len(text), b"JSON")
            + text
            + struct.pack("<I4s", len(self.body), b"BIN\0")
            + self.body
        )
        return path


def roof() -> Scene:
    scene = Scene()
    scene.primitive(ROOF, ROOF_FACES)
    return scene


def mesh_of(path: Path) -> tuple[Mesh, dict[str, dict[str, Any]]]:
    loaded = read_model(path)
    assert isinstance(loaded.data, Mesh)
    return loaded.data, by_code(loaded.warnings)


def triangles(mesh: Mesh) -> np.ndarray:
    return mesh.vertices[mesh.faces]


def test_scene_is_converted_to_z_up(tmp_path: Path) -> None:
    loaded = read_model(roof().glb(tmp_path / "roof.glb"))
    assert isinstance(loaded.data, Mesh)
    assert np.array_equal(triangles(loaded.data), ROOF[ROOF_FACES])
    assert (loaded.crs, loaded.warnings, loaded.turned_about) == (None, (), (0.0, 0.0, 0.0))


def test_embedded_origin_is_added_in_float64(tmp_path: Path) -> None:
    scene = roof()
    scene.json["asset"]["extras"] = {"origin": [576000, 5188000, -3], "crs": "EPSG:32615"}
    loaded = read_model(scene.glb(tmp_path / "roof.glb"))
    assert isinstance(loaded.data, Mesh)
    assert np.array_equal(triangles(loaded.data), (ROOF + [576000, 5188000, -3])[ROOF_FACES])
    assert loaded.crs == "EPSG:32615"


def test_offset_file_origin_is_used_if_none_is_embedded(tmp_path: Path) -> None:
    path = roof().glb(tmp_path / "roof.glb")
    (tmp_path / "roof.offset.txt").write_text("EPSG:32633; World = (x, -z, y) + offset 10 20.5 -3")
    loaded = read_model(path)
    assert loaded.data.bounds[0].tolist() == [10.0, 20.5, -3.0]
    assert loaded.crs == "EPSG:32633"


@pytest.mark.parametrize("origin", ["far", [1, 2], [1, 2, "3"], [1e300, 0, 0], [True, 0, 0]])
def test_invalid_origin_is_reported_and_not_added(tmp_path: Path, origin: object) -> None:
    scene = roof()
    scene.json["asset"]["extras"] = {"origin": origin, "crs": "EPSG:1"}
    loaded = read_model(scene.glb(tmp_path / "roof.glb"))
    assert loaded.data.bounds[0].tolist() == [0, 0, 0]
    assert [each.code for each in loaded.warnings[:2]] == [
        "model.origin-invalid",
        "frame.crs-unreadable",
    ]


@pytest.mark.parametrize("text", ["no numbers", "offset 1 2", "\0\xff", "offset 1e99 2 3"])
def test_invalid_offset_file_is_reported(tmp_path: Path, text: str) -> None:
    path = roof().glb(tmp_path / "roof.glb")
    (tmp_path / "roof.offset.txt").write_bytes(text.encode("latin-1"))
    mesh, findings = mesh_of(path)
    assert mesh.bounds[0].tolist() == [0, 0, 0]
    assert findings["model.origin-invalid"]["file"] == "roof.offset.txt"


def test_model_lying_on_its_side_is_reported(tmp_path: Path) -> None:
    scene = Scene()
    grid = np.array([[0, 0, 0], [0, 0, -9], [9, 0, 0]], float)  # faces +z of the file
    scene.primitive(grid, np.array([[0, 1, 2]]))
    _, findings = mesh_of(scene.glb(tmp_path / "side.glb"))
    assert "model.maybe-lying" in findings


def test_node_transforms_are_applied_to_meshes(tmp_path: Path) -> None:
    scene = roof()
    half = float(np.sqrt(0.5))
    scene.json["nodes"] = [
        {"children": [1, 2], "translation": [100.0, 0, 0]},
        {"mesh": 0, "scale": [2, 2, 2], "rotation": [0, half, 0, half]},  # 90 degrees about Up
        {"mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 5, 0, 1]},
    ]
    path = scene.glb(tmp_path / "roof.glb")
    mesh, _ = mesh_of(path)
    first, second = triangles(mesh)[:2], triangles(mesh)[2:]
    east, north, up = ROOF.T
    turned = np.stack([-2 * north + 100, 2 * east, 2 * up], axis=1)
    assert np.allclose(first, turned[ROOF_FACES], atol=1e-5)
    mirrored = np.stack([100 - east, north, up + 5], axis=1)[ROOF_FACES[:, ::-1]]
    assert np.allclose(second, mirrored, atol=1e-5)
    other = trimesh.load(path).to_geometry()
    upright = np.stack(
        [other.triangles[..., 0], -other.triangles[..., 2], other.triangles[..., 1]], -1
    )
    assert np.allclose(
        np.sort(upright.reshape(-1, 9), 0), np.sort(triangles(mesh).reshape(-1, 9), 0)
    )


def test_node_containing_itself_is_rejected(tmp_path: Path) -> None:
    scene = roof()
    scene.json["nodes"] = [{"mesh": 0, "children": [1]}, {"children": [0]}]
    with refused("file.damaged", field="nodes[0]"):
        read_model(scene.glb(tmp_path / "loop.glb"))


def test_embedded_image_is_extracted_unchanged(tmp_path: Path, image_folder: Path) -> None:
    scene = Scene()
    uv = np.array([[0, 1], [1, 1], [1, 0.25], [0, 0], [0, 0]], "<f4")
    made = scene.primitive(ROOF, ROOF_FACES, material=0)
    made["attributes"]["TEXCOORD_0"] = scene.accessor(uv)
    content = png()
    scene.json |= {
        "images": [{"bufferView": scene.view(content), "mimeType": "image/png"}],
        "textures": [{"source": 0}],
        "materials": [
            {"name": "../rock face", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
        ],
    }
    mesh, findings = mesh_of(scene.glb(tmp_path / "roof.glb"))
    (material,) = mesh.materials
    assert findings == {}
    assert material.texture is not None
    assert material.texture.read_bytes() == content
    assert material.texture.is_relative_to(image_folder)
    assert material.texture.name == "rock_face.png"
    assert mesh.uv is not None
    assert np.array_equal(mesh.uv[:3], [[0, 0], [1, 0], [1, 0.75]])


def test_images_load_from_data_uris_and_model_folder_only(tmp_path: Path) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    (folder / "a b.png").write_bytes(png((1, 2, 3)))
    (tmp_path / "outside.png").write_bytes(png((4, 5, 6)))
    scene = Scene()
    for i in range(4):
        scene.primitive(ROOF, ROOF_FACES, material=i)
    inside = "data:image/png;base64," + base64.b64encode(png()).decode()
    uris = [inside, "a%20b.png", "../outside.png", "none.png"]
    scene.json |= {
        "images": [{"uri": uri} for uri in uris],
        "textures": [{"source": i} for i in range(4)],
        "materials": [
            {"name": f"m{i}", "pbrMetallicRoughness": {"baseColorTexture": {"index": i}}}
            for i in range(4)
        ],
    }
    loaded = read_model(scene.glb(folder / "roof.glb"))
    assert isinstance(loaded.data, Mesh)
    mesh = loaded.data
    textures = [m.texture for m in mesh.materials]
    assert textures[0] is not None
    assert textures[0].read_bytes() == png()
    assert textures[1:] == [folder / "a b.png", None, None]
    unusable = [each for each in loaded.warnings if each.code == "texture.unusable"]
    assert [each.values["material"] for each in unusable] == ["m2", "m3"]


def test_a_texture_transform_is_applied(tmp_path: Path) -> None:
    scene = Scene()
    made = scene.primitive(ROOF, ROOF_FACES, material=0)
    made["attributes"]["TEXCOORD_0"] = scene.accessor(np.full((5, 2), (1.0, 0.0), "<f4"))
    move = {"offset": [0.5, 0.25], "scale": [0.5, 1.0], "rotation": np.pi / 2}
    info = {"index": 0, "extensions": {"KHR_texture_transform": move}}
    scene.json |= {
        "images": [{"bufferView": scene.view(png())}],
        "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": info}}],
    }
    mesh, _ = mesh_of(scene.glb(tmp_path / "roof.glb"))
    # (1, 0) scaled to (0.5, 0), turned counter-clockwise as seen (v runs down) to (0, -0.5).
    assert mesh.uv is not None
    assert np.allclose(mesh.uv[0], [0.5, 1 - (0.25 - 0.5)])


def test_point_primitive_keeps_colors_normals_and_fields(tmp_path: Path) -> None:
    scene = Scene()
    made = scene.primitive(ROOF, mode=0)
    colors = np.array([[255, 0, 7, 255]] * 5, "u1")
    made["attributes"] |= {
        "COLOR_0": scene.accessor(colors, normalized=True),
        "NORMAL": scene.accessor(np.full((5, 3), (0, 1, 0), "<f4")),
        "_intensity": scene.accessor(np.arange(5, dtype="<f4")),
    }
    loaded = read_model(scene.glb(tmp_path / "cloud.glb"))
    cloud = loaded.data
    assert isinstance(cloud, PointCloud)
    assert np.array_equal(cloud.points, ROOF)
    assert cloud.colors is not None
    assert cloud.colors[0].tolist() == [255, 0, 7]
    assert cloud.normals is not None
    assert cloud.normals[0].tolist() == [0, 0, 1]
    assert cloud.fields["intensity"].tolist() == [0, 1, 2, 3, 4]


@pytest.mark.parametrize(
    ("mode", "faces"), [(5, [[0, 1, 2], [3, 2, 1]]), (6, [[0, 1, 2], [0, 2, 3]])]
)
def test_strips_and_fans_are_cut_into_triangles(
    tmp_path: Path, mode: int, faces: list[list[int]]
) -> None:
    scene = Scene()
    scene.primitive(ROOF[:4], mode=mode)
    mesh, _ = mesh_of(scene.glb(tmp_path / "roof.glb"))
    assert sorted(map(sorted, mesh.faces.tolist())) == sorted(map(sorted, faces))
    assert np.array_equal(triangles(mesh), ROOF[:4][mesh.faces])


def test_trimesh_exports_round_trip(tmp_path: Path) -> None:
    sphere = trimesh.creation.icosphere(subdivisions=3, radius=7.0)
    for name in ("s.glb", "s.gltf"):
        path = tmp_path / name
        if name == "s.glb":
            sphere.export(path)
        else:
            for file, content in trimesh.Scene(sphere).export(file_type="gltf").items():
                (tmp_path / file.replace("model.gltf", name)).write_bytes(content)
        mesh, _ = mesh_of(path)
        corners = np.stack([mesh.vertices[:, 0], mesh.vertices[:, 2], -mesh.vertices[:, 1]], 1)
        assert np.allclose(corners[mesh.faces], sphere.triangles, atol=1e-6)


def test_gltf_hash_includes_its_buffers(tmp_path: Path) -> None:
    scene = roof()
    scene.json["buffers"] = [{"byteLength": len(scene.body), "uri": "roof.bin"}]
    (tmp_path / "roof.gltf").write_text(json.dumps(scene.json))
    hashes = []
    for body in (scene.body, bytes(12) + scene.body[12:]):
        (tmp_path / "roof.bin").write_bytes(body)
        hashes.append(read_model(tmp_path / "roof.gltf").content_hash)
    assert hashes[0] != hashes[1]
    (tmp_path / "roof.bin").unlink()
    with refused("model.part-missing") as error:
        read_model(tmp_path / "roof.gltf")
    assert "roof.bin" in error.value.message


def test_cached_model_restores_its_images(tmp_path: Path, image_folder: Path) -> None:
    path = trimesh_textured(tmp_path / "box.glb")
    for _ in range(2):
        loaded = model_cache.load(path, tmp_path / "cache")
        assert isinstance(loaded.data, Mesh)
        (material,) = loaded.data.materials
        assert material.texture is not None
        assert material.texture.is_file()
        shutil.rmtree(image_folder)


def test_offset_file_added_after_caching_is_applied(tmp_path: Path) -> None:
    path = roof().glb(tmp_path / "roof.glb")
    model_cache.load(path, tmp_path / "cache")
    (tmp_path / "roof.offset.txt").write_text("offset 100 0 0")
    loaded = model_cache.load(path, tmp_path / "cache")
    assert loaded.data.bounds[0, 0] == 100
    assert loaded.turned_about == (100, 0, 0)


def test_unwritable_image_cache_only_loses_the_texture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(image_store, "folder", lambda: tmp_path / "file" / "images")
    mesh, findings = mesh_of(trimesh_textured(tmp_path / "box.glb"))
    assert mesh.materials[0].texture is None
    assert "texture.unusable" in findings


def trimesh_textured(path: Path) -> Path:
    box = trimesh.creation.box()
    image = Image.open(io.BytesIO(png()))
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=image, name="rock")
    uv = np.random.default_rng(1).random((len(box.vertices), 2))
    box.visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    box.export(path)
    return path


def test_compressed_geometry_is_rejected(tmp_path: Path) -> None:
    scene = roof()
    scene.json["extensionsRequired"] = ["KHR_draco_mesh_compression"]
    with refused("model.unsupported", feature="Draco"):
        read_model(scene.glb(tmp_path / "roof.glb"))


def test_faces_beyond_the_vertices_are_left_out(tmp_path: Path) -> None:
    scene = Scene()
    scene.primitive(ROOF, np.array([[0, 1, 2], [0, 2, 9]]))
    mesh, findings = mesh_of(scene.glb(tmp_path / "roof.glb"))
    assert len(mesh.faces) == 1
    assert findings["model.faces-without-vertices"] == {"count": 1}


def test_excessive_counts_are_rejected_before_allocation(
    tmp_path: Path,
) -> None:
    for change in (
        {"count": 2**40},
        {"byteOffset": 2**40},
        {"count": -1},
        {"bufferView": 99},
        {"count": 10**9, "bufferView": None, "sparse": {"count": 10**9}},
    ):
        scene = roof()
        scene.json["accessors"][0] |= change
        if change.get("bufferView", 0) is None:
            del scene.json["accessors"][0]["bufferView"]
        with pytest.raises(InputError):
            read_model(scene.glb(tmp_path / "roof.glb"))


def test_truncated_glb_is_rejected_by_name(tmp_path: Path) -> None:
    content = trimesh_textured(tmp_path / "box.glb").read_bytes()
    path = tmp_path / "cut.glb"
    for n in range(0, len(content), 41):
        path.write_bytes(content[:n])
        with pytest.raises(InputError, match=r"cut\.glb"):
            read_model(path)


def test_scene_with_invalid_values_gives_model_or_input_error(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    junk: list[Any] = [None, -1, 7, 2**70, 1.5, "x", "", [], [1, 2], {}, {"index": 0}, True]
    base = trimesh_textured(tmp_path / "box.glb").read_bytes()
    (size,) = struct.unpack_from("<I", base, 12)
    text, rest = base[20 : 20 + size], base[20 + size :]
    path = tmp_path / "bad.glb"

    def places(value: Any) -> list[tuple[Any, Any]]:
        items = value.items() if isinstance(value, dict) else enumerate(value)
        found = []
        for key, inner in items:
            found.append((value, key))
            if isinstance(inner, dict | list):
                found += places(inner)
        return found

    read = 0
    for _ in range(400):
        scene = json.loads(text)
        options = places(scene)
        for pick in rng.integers(0, len(options), 2):
            holder, key = options[pick]
            holder[key] = junk[rng.integers(0, len(junk))]
        new = json.dumps(scene).encode()
        total = 20 + len(new) + len(rest)
        path.write_bytes(struct.pack("<4sIII4s", b"glTF", 2, total, len(new), b"JSON") + new + rest)
        try:
            read_model(path)
            read += 1
        except InputError:
            continue
    assert read > 20


def test_damaged_bytes_give_model_or_input_error(tmp_path: Path) -> None:
    content = trimesh_textured(tmp_path / "box.glb").read_bytes()
    path = tmp_path / "bad.glb"
    rng = np.random.default_rng(4)
    for _ in range(300):
        bad = bytearray(content)
        for at in rng.integers(0, len(content), 3):
            bad[at] = rng.integers(0, 256)
        path.write_bytes(bad)
        try:
            read_model(path)
        except InputError:
            continue


@pytest.mark.parametrize("content", [b"glTF", b"{}", b"[" * 99999, b'{"asset": 1}', b"\xff{"])
def test_file_that_is_not_a_scene_is_rejected_by_name(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a.gltf"
    path.write_bytes(content)
    with refused("file.damaged", file=path):
        read_model(path)


def test_reading_stops_when_it_is_cancelled(tmp_path: Path) -> None:
    token = CancelToken()
    token.cancel()
    with pytest.raises(Cancelled):
        read_model(roof().glb(tmp_path / "roof.glb"), SilentProgress(token))


def test_the_survey_model_agrees_with_its_obj(data_dir: Path) -> None:
    folder = data_dir / "brighton_model"
    glb, obj = read_model(folder / "brighton_local.glb"), read_model(folder / "brighton_utm15n.obj")
    assert isinstance(glb.data, Mesh)
    assert isinstance(obj.data, Mesh)
    assert (glb.crs, glb.warnings) == ("EPSG:32615", ())
    assert len({m.texture for m in glb.data.materials} - {None}) == 9
    # float32 up to 256 m from its origin: half a step is 0.0305 mm at most beyond 512 m.
    difference = triangles(glb.data) - triangles(obj.data)
    assert np.abs(difference).max() < 3.1e-5


@pytest.mark.parametrize("of", ["node", "mesh", "both", "nobody"])
def test_morph_target_weights_are_applied(tmp_path: Path, of: str) -> None:
    """glTF 2.0: positions + sum of weight x target; a node's weights go before its mesh's."""
    scene = roof()
    lifts = [np.tile([0.0, 0.0, z], (5, 1)) for z in (1.0, 10.0)]
    scene.json["meshes"][0]["primitives"][0]["targets"] = [
        {"POSITION": scene.accessor(y_up(lift))} for lift in lifts
    ]
    if of in ("mesh", "both"):
        scene.json["meshes"][0]["weights"] = [0.25, 0.5]
    if of in ("node", "both"):
        scene.json["nodes"][0]["weights"] = [1.0, 2.0]
    lifted = {"node": 21.0, "both": 21.0, "mesh": 5.25, "nobody": 0.0}[of]
    mesh, _ = mesh_of(scene.glb(tmp_path / "roof.glb"))
    assert np.array_equal(triangles(mesh), (ROOF + [0, 0, lifted])[ROOF_FACES])


def test_instances_are_placed_by_their_transforms(tmp_path: Path) -> None:
    """Three roofs: moved, turned by 90 degrees about the vertical, and twice as large."""
    scene = roof()
    half = np.sqrt(0.5)
    attributes = {
        "TRANSLATION": scene.accessor(y_up(np.array([[10.0, 0, 0], [0, 20, 0], [0, 0, 30]]))),
        "ROTATION": scene.accessor(
            np.array([[0, 0, 0, 1], [0, half, 0, half], [0, 0, 0, 1]], "<f4")
        ),
        "SCALE": scene.accessor(np.array([[1, 1, 1], [1, 1, 1], [2, 2, 2]], "<f4")),
    }
    scene.json["extensionsUsed"] = ["EXT_mesh_gpu_instancing"]
    scene.json["extensionsRequired"] = ["EXT_mesh_gpu_instancing"]
    scene.json["nodes"][0]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    mesh, findings = mesh_of(scene.glb(tmp_path / "roof.glb"))
    assert findings == {}
    turned = np.column_stack([-ROOF[:, 1], ROOF[:, 0], ROOF[:, 2]])
    wanted = [ROOF + [10, 0, 0], turned + [0, 20, 0], 2 * ROOF + [0, 0, 30]]
    found = triangles(mesh).reshape(3, 2, 3, 3)
    for one, three in zip(found, wanted, strict=True):
        assert np.allclose(one, three[ROOF_FACES], atol=1e-5)


def test_unsupported_node_extension_is_reported(tmp_path: Path) -> None:
    scene = roof()
    scene.json["nodes"][0]["extensions"] = {"MSFT_lod": {"ids": []}}
    loaded = read_model(scene.glb(tmp_path / "roof.glb"))
    extensions = [each.values.get("extension") for each in loaded.warnings]
    assert extensions.count("MSFT_lod") == 1


@pytest.mark.parametrize("there", [True, False])
def test_uncompressed_fallback_buffers_are_used(tmp_path: Path, there: bool) -> None:
    scene = roof()
    scene.json["extensionsUsed"] = ["EXT_meshopt_compression"]
    for view in scene.json["bufferViews"]:
        packed = {
            "buffer": 0,
            "byteOffset": 0,
            "byteLength": 4,
            "byteStride": 12,
            "count": 5,
            "mode": "ATTRIBUTES",
        }
        view["extensions"] = {"EXT_meshopt_compression": packed}
        view["buffer"] = 0 if there else 1
    path = scene.glb(tmp_path / "roof.glb")
    if not there:
        scene.json["buffers"].append(
            {
                "byteLength": len(scene.body),
                "extensions": {"EXT_meshopt_compression": {"fallback": True}},
            }
        )
        text = json.dumps(scene.json).encode()
        path.write_bytes(
            struct.pack(
                "<4sIII4s", b"glTF", 2, 28 + len(text) + len(scene.body), len(text), b"JSON"
            )
            + text
            + struct.pack("<I4s", len(scene.body), b"BIN\0")
            + scene.body
        )
        with refused("file.damaged"):
            read_model(path)
        return
    mesh, _ = mesh_of(path)
    assert np.array_equal(triangles(mesh), ROOF[ROOF_FACES])


def test_cesium_rtc_center_is_reported_as_unsupported(tmp_path: Path) -> None:
    """CESIUM_RTC stands at the whole file, and moves all of it."""
    scene = roof()
    scene.json["extensions"] = {"CESIUM_RTC": {"center": [100.0, 200.0, 300.0]}}
    scene.json["extensionsUsed"] = ["CESIUM_RTC"]
    _, findings = mesh_of(scene.glb(tmp_path / "a.glb"))
    assert findings["model.extension-unsupported"] == {"extension": "CESIUM_RTC"}


@pytest.mark.parametrize("kind", ["<u1", "<u2", "<u4"])
@pytest.mark.parametrize("nodes", [1, 2])
def test_primitives_with_narrow_indices_are_joined_and_mirrored_faces_flipped(
    tmp_path: Path, kind: str, nodes: int
) -> None:
    """Places in the joined model are wider than those in each of its pieces; the first node mirrors
    its mesh, the second is the same mesh as it stands."""
    scene = Scene()
    rng = np.random.default_rng(3)
    expected = []
    for number in range(5):
        points = rng.uniform(0, 1, (200, 3)).astype("<f4").astype(float) + [2 * number, 0, 0]
        faces = rng.permutation(198).reshape(-1, 3)
        made = scene.primitive(points, faces)
        made["indices"] = scene.accessor(faces.reshape(-1).astype(kind))
        expected.append(points[faces])
    scene.json["nodes"] = [{"mesh": 0, "scale": [-1, 1, 1]}, {"mesh": 0}]
    scene.json["scenes"] = [{"nodes": list(range(nodes))}]
    mesh, _ = mesh_of(scene.glb(tmp_path / "a.glb"))
    assert mesh.faces.dtype == np.int32
    there = np.concatenate(expected)
    mirrored = (there * [-1, 1, 1])[:, ::-1]
    found = mesh.vertices[mesh.faces]
    assert np.abs(found - np.concatenate([mirrored, there][:nodes])).max() < 1e-6


def test_large_model_lying_on_its_side_is_detected_in_blocks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wall = np.array([[0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 9, 0]], float)
    scene = Scene()
    scene.primitive(wall[:, [0, 2, 1]] * [1, -1, 1], np.array([[0, 1, 2], [0, 2, 3]]))
    findings = []
    for at_once in (1, 1 << 18):
        monkeypatch.setattr("vomstudio.io.models.formats.gltf.BLOCK_ROWS", at_once)
        findings.append(mesh_of(scene.glb(tmp_path / "a.glb"))[1])
    assert findings[0] == findings[1]
    assert "model.maybe-lying" in findings[0]
