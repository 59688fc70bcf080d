from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.io.photos import camera_files
from tests.messages import refused
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.model_copy import companions, copy_model, count_photos
from vomstudio.io.models.opening import read_model
from vomstudio.io.photos.cameras_file import Cameras, find_photos, read_cameras, write_cameras


@pytest.fixture
def model(tmp_path):
    (tmp_path / "p.vom").mkdir()
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


def test_files_outside_the_model_folder_are_not_copied(model):
    assert {p.name for p in companions(model)} == {"my cliff.mtl", "a.png", "b.png", "cliff.prj"}


def test_second_copy_gets_its_own_folder(model, tmp_path):
    first = copy_model(model, tmp_path / "m")
    assert copy_model(model, tmp_path / "m") != first
    assert sorted(p.name for p in (tmp_path / "m").iterdir()) == ["cliff", "cliff-2"]


def test_failed_copy_leaves_no_files(model, tmp_path):
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
    with refused("file.unreadable", file=tmp_path / "gone.ply"):
        copy_model(tmp_path / "gone.ply", tmp_path / "m")
    assert not list((tmp_path / "m").iterdir())


def test_gltf_buffers_and_gltf_and_ply_images_are_copied(tmp_path: Path) -> None:
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


# --- the photos of a reconstructed model ---------------------------------------------------------
LENS = Intrinsics("PINHOLE", 40, 30, (50.0, 50.0, 20.0, 15.0))


def photographed(model: Path, photos: Path, name: Path) -> Path:
    """Cameras of two photos, one of them in a folder of its own."""
    (photos / "left").mkdir(parents=True)
    views = []
    for k, photo in enumerate(("left/a.jpg", "b.jpg")):
        Image.new("RGB", (40, 30), "blue").save(photos / photo)
        views.append(View(photo, LENS, np.eye(3), np.array([float(k), 0.0, 5.0])))
    write_cameras(name, Cameras(tuple(views), photos, (100, 200, 0), "EPSG:32633"), force=True)
    return photos


def test_copy_keeps_cameras_and_photo_folder(model, tmp_path):
    photos = photographed(model, tmp_path / "photos", model.with_name("cameras.json"))
    copy = copy_model(model, tmp_path / "p.vom" / "models")
    was, now = (read_cameras(m.with_name("cameras.json")) for m in (model, copy))
    assert now.photos == photos
    assert now.origin == was.origin
    assert now.crs == was.crs
    for a, b in zip(was.views, now.views, strict=True):
        assert a.name == b.name
        np.testing.assert_array_equal(a.centre, b.centre)
    assert not (copy.parent / "photos").exists()


def test_a_relative_folder_of_photos_is_found_from_the_copy(model, tmp_path):
    photos = photographed(model, model.parent / "pictures", model.with_name("cameras.json"))
    cameras = read_cameras(model.with_name("cameras.json"))
    write_cameras(
        model.with_name("cameras.json"), replace(cameras, photos=Path("pictures")), force=True
    )
    copy = copy_model(model, tmp_path / "p.vom" / "models")
    beside = copy.with_name("cameras.json")
    assert find_photos(read_cameras(beside), beside) == photos


def test_copied_photos_are_found_after_moving_the_folder(model, tmp_path):
    photographed(model, tmp_path / "photos", tmp_path / "chosen.json")
    count, size = count_photos(model, tmp_path / "chosen.json")
    assert (count, size) == (2, sum(p.stat().st_size for p in (tmp_path / "photos").rglob("*.jpg")))
    assert count_photos(model) == (0, 0)
    copy_model(model, tmp_path / "p.vom" / "models", cameras=tmp_path / "chosen.json", photos=True)
    (tmp_path / "p.vom").rename(tmp_path / "moved.vom")
    (tmp_path / "photos").rename(tmp_path / "gone")
    beside = tmp_path / "moved.vom" / "models" / "cliff" / "cameras.json"
    cameras = read_cameras(beside)
    folder = find_photos(cameras, beside)
    assert folder == beside.parent / "photos"
    assert all((folder / view.name).is_file() for view in cameras.views)


def test_photo_names_outside_the_photo_folder_are_not_copied(model, tmp_path):
    photographed(model, tmp_path / "photos", model.with_name("cameras.json"))
    (tmp_path / "secret.jpg").write_bytes(b"x")
    cameras = read_cameras(model.with_name("cameras.json"))
    bad = View("../secret.jpg", LENS, np.eye(3), np.zeros(3))
    write_cameras(
        model.with_name("cameras.json"), replace(cameras, views=(*cameras.views, bad)), force=True
    )
    copy = copy_model(model, tmp_path / "p.vom" / "models", photos=True)
    assert not list((tmp_path / "p.vom").rglob("secret.jpg"))
    assert (copy.parent / "photos" / "b.jpg").is_file()


def test_unreadable_cameras_do_not_prevent_copying_the_model(model, tmp_path):
    model.with_name("cameras.json").write_text("{")
    copy = copy_model(model, tmp_path / "p.vom" / "models", photos=True)
    assert copy.is_file()
    assert not copy.with_name("cameras.json").exists()


def test_cameras_of_other_programs_are_copied_with_their_photos(model, tmp_path):
    """In the frame of the model, under the names of the files."""
    views = camera_files.ring(3)
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]])
    turn, shift = np.eye(3), np.array([500.0, 0.0, 0.0])
    cameras = camera_files.metashape_xml(
        model.parent / "cameras.xml", views, 1.0, turn, shift, "LOCAL_CS[]"
    )
    for view in views:
        photos = model.parent / "photos" / "day 1"
        photos.mkdir(parents=True, exist_ok=True)
        Image.new("L", (4, 3)).save(photos / view.name)
    assert read_model(model).data.bounds == pytest.approx(corners)
    assert count_photos(model, cameras)[0] == 3
    copy = copy_model(model, tmp_path / "p.vom" / "models", cameras=cameras, photos=True)
    taken = read_cameras(copy.with_name("cameras.json"))
    assert [view.name for view in taken.views] == [view.name for view in views]
    for there, view in zip(taken.views, views, strict=True):
        np.testing.assert_allclose(there.centre + taken.origin, view.centre, atol=1e-6)
        assert (find_photos(taken, copy.with_name("cameras.json")) / there.name).is_file()
