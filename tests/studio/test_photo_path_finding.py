"""Ways in the pixels of a photo of an open model, thrown on it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.extraction.test_photo_following import Wall, clicks, wall, written
from tests.messages import refused
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.geometry import transform
from vomstudio.geometry.rays.raytree import RayTree
from vomstudio.io.photos.cameras_file import read_cameras
from vomstudio.photogrammetry.inspect.photo_views import PhotoViews
from vomstudio.studio.photo_path_finding import PhotoPaths
from vomstudio.studio.photos import ModelPhotos

# The model is turned, shifted and twice as large in World.
TO_WORLD = np.array(
    [[0.0, -2.0, 0.0, 50.0], [2.0, 0.0, 0.0, -20.0], [0.0, 0.0, 2.0, 7.0], [0.0, 0.0, 0.0, 1.0]]
)


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> tuple[Wall, Path]:
    made = wall(4)
    return made, written(made, tmp_path_factory.mktemp("wall"))


def photos_in(folder: Path, names: Iterable[str]) -> dict[str, Path]:
    return {name: folder / name for name in names}


def photos_of(scene: tuple[Wall, Path]) -> ModelPhotos:
    made, folder = scene
    cameras = read_cameras(folder / "cameras.json")
    views = PhotoViews(cameras, RayTree(made.mesh()), TO_WORLD, 0.05)
    files = photos_in(folder, [view.name for view in cameras.views])
    return ModelPhotos("m", "wall", views, files)


@pytest.mark.full
def test_photo_path_follows_the_bed_and_other_photos_confirm_it(scene) -> None:
    made, _ = scene
    ends = clicks(made)[[0, 2]]
    way = PhotoPaths().find_path(photos_of(scene), "p0.png", "dark", ends, is_live=False)
    off = np.abs(way.points @ made.normal - made.level)
    assert np.median(off) < 0.012, "half as wide as the bed"
    assert np.linalg.norm(way.points[[0, -1]] - ends, axis=1).max() < 0.03
    assert way.photo == "p0.png"
    assert set(way.voters) == {"p1.png", "p2.png"}
    assert way.confirmed_count >= 0.9 * way.checked_count > 0
    assert way.is_final


def test_live_photo_path_uses_no_other_photo(scene) -> None:
    made, _ = scene
    paths, photos = PhotoPaths(), photos_of(scene)
    way = paths.find_path(photos, "p0.png", "dark", clicks(made)[[0, 1]], is_live=True)
    assert not way.is_final
    assert way.voters == ()
    assert np.median(np.abs(way.points @ made.normal - made.level)) < 0.012


def test_path_in_a_downscaled_photo_uses_the_scaled_camera(scene, tmp_path) -> None:
    made, folder = scene
    for name in ("p0.png", "p1.png", "p2.png"):
        with Image.open(folder / name) as image:
            image.resize((320, 240), Image.Resampling.BOX).save(tmp_path / name)
    photos = photos_of(scene)
    small = ModelPhotos("m", "wall", photos.views, photos_in(tmp_path, photos.files))
    way = PhotoPaths().find_path(small, "p0.png", "dark", clicks(made)[[0, 2]], is_live=False)
    assert np.median(np.abs(way.points @ made.normal - made.level)) < 0.02


def test_unusable_photo_or_cost_is_rejected(scene, tmp_path) -> None:
    made, _ = scene
    photos, paths, ends = photos_of(scene), PhotoPaths(), clicks(made)[[0, 1]]
    beside = np.array([ends[0], [900.0, 0.0, 0.0]])
    with refused("photo.not-showing", GeometryError):
        paths.find_path(photos, "p0.png", "dark", beside, is_live=False)
    with refused("option.not-a-choice", UsageError, value="curvature", field="--cost"):
        paths.find_path(photos, "p0.png", "curvature", ends, is_live=False)
    gone = ModelPhotos("m", "wall", photos.views, photos_in(tmp_path, photos.files))
    with refused("photo.file-missing", GeometryError):
        paths.find_path(gone, "p0.png", "dark", ends, is_live=False)
    nowhere = ModelPhotos("m", "wall", photos.views, {})
    with refused("photo.file-missing", GeometryError):
        paths.find_path(nowhere, "p0.png", "dark", ends, is_live=False)


@pytest.mark.full
def test_photo_path_does_not_depend_on_the_world_transform(scene) -> None:
    made, _ = scene
    photos, ends = photos_of(scene), clicks(made)[[0, 2]]
    way = PhotoPaths().find_path(photos, "p0.png", "dark", ends, is_live=False)
    assert photos.views.shows(0, transform.apply(TO_WORLD, way.points), 0.2).mean() > 0.95
    plain = PhotoViews(photos.views.cameras, photos.views.tree, None, 0.05)
    same = PhotoPaths().find_path(
        ModelPhotos("m", "w", plain, photos.files), "p0.png", "dark", ends, is_live=False
    )
    assert np.allclose(same.points, way.points, atol=1e-6)
