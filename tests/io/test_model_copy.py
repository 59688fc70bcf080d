from __future__ import annotations

from pathlib import Path

import pytest
from PIL import Image

from vomstudio.errors import InputError
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.model_copy import companions, copy_model
from vomstudio.io.models import read_model


@pytest.fixture
def model(tmp_path):
    folder = tmp_path / "survey"
    (folder / "tex tures").mkdir(parents=True)
    for name in ("a.png", "b.png"):
        Image.new("RGB", (4, 4), "red").save(folder / "tex tures" / name)
    (folder / "my cliff.mtl").write_text(
        "newmtl one\nmap_Kd tex tures/a.png\nnewmtl two\nmap_Kd tex tures\\b.png\n"
        "newmtl three\nmap_Kd ../secret.png\n"
    )
    (tmp_path / "secret.png").write_bytes(b"x")
    (folder / "cliff.prj").write_text("EPSG:32633")
    (folder / "cliff.obj").write_text(
        "mtllib my cliff.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
        "usemtl one\nf 1/1 2/2 3/3\nusemtl two\nf 3/3 2/2 1/1\n"
    )
    return folder / "cliff.obj"


def test_the_copy_is_the_same_model_with_its_textures_and_its_crs(model, tmp_path):
    copy = copy_model(model, tmp_path / "p.vom" / "models")
    assert copy == tmp_path / "p.vom" / "models" / "cliff" / "cliff.obj"
    was, now = read_model(model), read_model(copy)
    assert now.content_hash == was.content_hash
    assert now.crs == "EPSG:32633"
    assert isinstance(now.data, Mesh)
    assert [m.texture.name for m in now.data.materials] == ["a.png", "b.png"]
    assert all(m.texture.is_relative_to(copy.parent) for m in now.data.materials)


def test_nothing_outside_the_models_folder_is_taken_along(model):
    assert {p.name for p in companions(model)} == {"my cliff.mtl", "a.png", "b.png", "cliff.prj"}


def test_a_second_copy_stands_beside_the_first(model, tmp_path):
    first = copy_model(model, tmp_path / "m")
    assert copy_model(model, tmp_path / "m") != first
    assert sorted(p.name for p in (tmp_path / "m").iterdir()) == ["cliff", "cliff-2"]


def test_a_copy_that_fails_leaves_nothing(model, tmp_path):
    class Stopped(Exception):
        pass

    class Stopping:
        def stage(self, name, total=None):
            return

        def step(self, done):
            if done == 2:
                raise Stopped

    with pytest.raises(Stopped):
        copy_model(model, tmp_path / "m", Stopping())
    assert not list((tmp_path / "m").iterdir())
    with pytest.raises(InputError, match="gone"):
        copy_model(tmp_path / "gone.ply", tmp_path / "m")
    assert not list((tmp_path / "m").iterdir())


def test_the_buffers_and_images_of_a_gltf_and_of_a_ply_come_along(tmp_path: Path) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    for name in ("a b.bin", "rock.png", "other.png"):
        (folder / name).write_bytes(b"x")
    (folder / "m.gltf").write_text(
        '{"asset": {"version": "2.0"}, "buffers": [{"uri": "a%20b.bin"}],'
        ' "images": [{"uri": "rock.png"}, {"uri": "data:,x"}, {"uri": "../m.ply"}, {"uri": 3}]}'
    )
    assert [p.name for p in companions(folder / "m.gltf")] == ["a b.bin", "rock.png"]
    (folder / "m.ply").write_text(
        "ply\nformat ascii 1.0\ncomment TextureFile other.png\nelement vertex 0\nend_header\n"
    )
    assert [p.name for p in companions(folder / "m.ply")] == ["other.png"]
    (folder / "bad.gltf").write_text("nonsense")
    assert companions(folder / "bad.gltf") == []
