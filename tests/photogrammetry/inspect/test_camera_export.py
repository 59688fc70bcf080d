"""Cameras written for COLMAP and nerfstudio come back by COLMAP itself and by our readers."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import vomstudio as vs
from tests.io.photos import camera_files as files
from tests.messages import by_code, refused
from tests.photogrammetry.made_reconstruction import ORIGIN, Made, make
from vomstudio.cli import main
from vomstudio.core.errors import TargetError, UsageError
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registrations import Registration
from vomstudio.io.models.registration_file import write_registration
from vomstudio.io.photos.own_cameras.reading import read_camera_file
from vomstudio.photogrammetry.base.colmap import colmap
from vomstudio.photogrammetry.inspect.camera_export import export_cameras


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    return make(tmp_path_factory.mktemp("made"))


def same_poses(found: dict[str, View], expected: dict[str, View], shift: np.ndarray) -> None:
    assert found.keys() == expected.keys()
    for name, view in expected.items():
        np.testing.assert_allclose(found[name].rotation, view.rotation, atol=1e-9)
        np.testing.assert_allclose(found[name].centre, view.centre + shift, atol=1e-6)


@pytest.mark.parametrize("world", [False, True])
@pytest.mark.parametrize("name", ["colmap", "transforms.json"])
def test_exported_reconstruction_is_read_unchanged(
    made: Made, tmp_path: Path, name: str, world: bool
) -> None:
    result = export_cameras(made.out, tmp_path / name, world=world)
    shift = np.array(ORIGIN, float) * world
    expected = {view.name: view for view in made.scene.views}
    # The paths of photos in transforms.json are relative to it.
    found = {Path(n).name: v for n, v in read_camera_file(tmp_path / name).views.items()}
    same_poses(found, expected, shift)
    for photo, view in found.items():
        pixels = view.project(made.scene.points[:20] + shift)
        truth = expected[photo].project(made.scene.points[:20])
        np.testing.assert_allclose(pixels, truth, atol=1e-4)
    assert (result.photos, result.points) == (3, len(made.scene.points))
    assert result.origin == ((0, 0, 0) if world else ORIGIN)


def test_colmap_reads_cameras_points_and_tracks(made: Made, tmp_path: Path) -> None:
    export_cameras(made.out, tmp_path / "colmap")
    model = colmap().Reconstruction(tmp_path / "colmap")
    scene = made.scene
    assert (len(model.cameras), len(model.images)) == (1, 3)
    points = np.array([model.points3D[k].xyz for k in sorted(model.points3D)])
    np.testing.assert_allclose(points, scene.points, atol=1e-9)
    lengths = [model.points3D[k].track.length() for k in sorted(model.points3D)]
    assert lengths == scene.track_lengths.tolist()
    for image in model.images.values():
        pose = image.cam_from_world().matrix()
        view = scene.view(image.name)
        np.testing.assert_allclose(
            pose, np.column_stack([view.rotation, view.translation]), atol=1e-12
        )
    observed = sum(len(image.points2D) for image in model.images.values())
    assert observed == len(scene.track_views)


def test_nerfstudio_frames_name_their_photos_and_points(made: Made, tmp_path: Path) -> None:
    path = tmp_path / "transforms.json"
    export_cameras(made.out, path)
    content = json.loads(path.read_text())
    for frame in content["frames"]:
        assert (tmp_path / frame["file_path"]).is_file()
    cloud = vs.read(tmp_path / content["ply_file_path"], up="z", unit="m")
    assert len(cloud.points) == len(made.scene.points)


def test_registration_beside_the_cameras_transforms_to_world(tmp_path: Path) -> None:
    views = files.ring(4)
    path = files.colmap_text(tmp_path / "sparse", views) / "images.txt"
    with refused("cameras.no-world", UsageError, field="--world"):
        export_cameras(path, tmp_path / "out", world=True)
    matrix = np.array([[0, -2, 0, 500_000.0], [2, 0, 0, 4e6], [0, 0, 2, 300], [0, 0, 0, 1]])
    frame = Frame("crs", "EPSG:32633")
    registration = Registration(
        method="points",
        frame=frame,
        matrix=tuple(map(tuple, matrix.tolist())),
        id="r1",
        name="points",
    )
    (path.parent / "model.ply").write_bytes(b"ply")
    write_registration(registration, [path.parent / "model.ply"])
    result = export_cameras(path, tmp_path / "out", world=True)
    found = read_camera_file(tmp_path / "out").views
    assert (result.frame, result.crs) == ("world", "EPSG:32633")
    for view in views:
        centre = matrix[:3, :3] @ view.centre + matrix[:3, 3]
        np.testing.assert_allclose(found[view.name].centre, centre, atol=1e-5)


def test_data_that_nerfstudio_cannot_store_are_reported(tmp_path: Path) -> None:
    full = (900.0, 900.0, 500.0, 400.0, 0.1, 0.01, 0.0, 0.0, 0.002, 0.3, 0.0, 0.0)
    lenses = [
        Intrinsics("OPENCV_FISHEYE", 1000, 800, (900.0, 910.0, 500.0, 400.0, 0.1, 0.2, 0.3, 0.4)),
        Intrinsics("FULL_OPENCV", 1000, 800, full),
    ]
    views = [replace(v, intrinsics=n) for v, n in zip(files.ring(2), lenses, strict=True)]
    from vomstudio.io.photos.cameras_file import Cameras, write_cameras

    write_cameras(tmp_path / "cameras.json", Cameras(tuple(views), tmp_path))
    result = export_cameras(tmp_path / "cameras.json", tmp_path / "transforms.json")
    simplified = by_code(result.warnings)["cameras.lenses-simplified"]
    assert simplified["photos"] == (views[1].name,)
    found = read_camera_file(tmp_path / "transforms.json").views
    assert found[views[0].name].intrinsics == lenses[0]


def test_command_and_function_write_the_same(made: Made, tmp_path: Path, capsys) -> None:
    assert main(["convert", str(made.out), str(tmp_path / "a"), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    result = vs.export_cameras(made.out, tmp_path / "b").to_dict()
    assert {k: printed[k] for k in ("photos", "points", "frame", "origin")} == {
        k: result[k] for k in ("photos", "points", "frame", "origin")
    }
    for name in ("cameras.txt", "images.txt", "points3D.txt"):
        assert (tmp_path / "a" / name).read_text() == (tmp_path / "b" / name).read_text()
    with pytest.raises(TargetError):
        vs.export_cameras(made.out, tmp_path / "b")
    vs.export_cameras(made.out, tmp_path / "b", force=True)
