"""The photos of the sample outcrop agree with the truth that is stored beside them."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.sample_maker import maker
from vomstudio.core.paths import resource
from vomstudio.geometry.rays.raytree import RayTree
from vomstudio.io.models.opening import read_model
from vomstudio.photogrammetry.inspect.photo_views import PhotoViews
from vomstudio.project.sample import (
    read_true_cameras,
    sample_control,
    sample_marks,
    sample_model,
    sample_photos,
)


def rows(path: Path) -> list[dict[str, str]]:
    lines = path.read_text("utf-8").splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def places(path: Path) -> dict[str, np.ndarray]:
    return {row["label"]: np.array([float(row[a]) for a in "xyz"]) for row in rows(path)}


TRUE = places(resource("sample", "control_truth.csv"))


@pytest.fixture(scope="module")
def photos() -> PhotoViews:
    return PhotoViews(read_true_cameras(), RayTree(read_model(sample_model()).data))


def test_marks_are_projections_with_the_stated_noise(photos: PhotoViews) -> None:
    """The program's lens against the maker's, which share no code."""
    off = []
    for mark in rows(sample_marks()):
        pixel = photos.pixels(photos.row(mark["photo"]), TRUE[mark["label"]])[0]
        off.append(np.array([float(mark["x"]), float(mark["y"])]) - pixel)
    off_by = np.array(off)
    assert len(off_by) >= 50
    assert np.abs(off_by).max() < 1.5
    assert 0.24 < off_by.std() < 0.36
    assert np.abs(off_by.mean(axis=0)).max() < 4 * 0.3 / np.sqrt(len(off_by))


def test_targets_appear_in_photos_at_true_positions(photos: PhotoViews) -> None:
    import cv2

    off = []
    for mark in rows(sample_marks()):
        expected = photos.pixels(photos.row(mark["photo"]), TRUE[mark["label"]])[0]
        picture = np.asarray(Image.open(sample_photos() / mark["photo"]).convert("L"))
        # OpenCV counts from the middle of the first pixel.
        found = np.ascontiguousarray((expected - 0.5)[None, None], np.float32)
        stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 50, 1e-3)
        found = cv2.cornerSubPix(picture, found, (5, 5), (-1, -1), stop)[0, 0] + 0.5
        off.append(found - expected)
    off_by = np.array(off)
    assert np.abs(np.median(off_by, axis=0)).max() < 0.05
    assert np.median(np.hypot(*off_by.T)) < 0.25


def test_marked_targets_are_seen_and_lie_on_the_model(photos: PhotoViews) -> None:
    for mark in rows(sample_marks()):
        view = photos.row(mark["photo"])
        assert photos.shows(view, TRUE[mark["label"]], slack_m=0.03).all()
        seen = photos.pick(view, photos.pixels(view, TRUE[mark["label"]])[0])
        assert seen is not None
        assert np.linalg.norm(seen.position - TRUE[mark["label"]]) < 0.02


def test_every_target_is_marked_in_three_photos_and_some_are_for_checking() -> None:
    marked = [mark["label"] for mark in rows(sample_marks())]
    assert min(marked.count(label) for label in TRUE) >= 3
    uses = [row["use"] for row in rows(sample_control())]
    assert uses.count("control") >= 4
    assert uses.count("check") >= 3


def test_control_point_errors_match_stated_sigma() -> None:
    given = places(sample_control())
    off = np.array([given[label] - TRUE[label] for label in TRUE])
    (sigma,) = {float(row["sigma"]) for row in rows(sample_control())}
    assert 0.6 * sigma < off.std() < 1.5 * sigma


def test_gps_errors_match_stated_accuracy(photos: PhotoViews) -> None:
    from pyproj import Transformer

    from vomstudio.io.photos.reading import read_photos

    read = {photo.name: photo for photo in read_photos(sample_photos()).photos}
    assert len(read) == len(photos.views) == 12
    to_metres = Transformer.from_crs(4326, 32633, always_xy=True)
    off = []
    for view in photos.views:
        photo = read[view.name]
        assert (photo.width, photo.height) == (1500, 1000)
        assert photo.orientation == 1
        assert photo.gps_accuracy_m == pytest.approx(maker("photos").GPS_SD)
        assert photo.focal_px == pytest.approx(view.intrinsics.focal[0], rel=0.04)
        east, north = to_metres.transform(photo.longitude_deg, photo.latitude_deg)
        centre = view.centre + photos.cameras.origin
        off.append(np.array([east, north, photo.altitude_m]) - centre)
    assert 1.8 < np.std(off) < 4.2


def test_neighbouring_photos_overlap_and_rows_have_two_heights(photos: PhotoViews) -> None:
    centres = np.array([view.centre for view in photos.views])
    assert np.ptp(centres[:, 2]) > 6.0
    u, v = np.meshgrid(np.linspace(60, 1440, 24), np.linspace(60, 940, 16))
    grid = np.column_stack([u.ravel(), v.ravel()])
    for row in (range(6), range(6, 12)):
        for first, second in zip(row, list(row)[1:], strict=False):
            seen = [photos.pick(first, pixel) for pixel in grid]
            world = np.array([s.position for s in seen if s is not None])
            shared = photos.views[second].contains(photos.pixels(second, world)).mean()
            assert shared > 0.75, (first, second, shared)
