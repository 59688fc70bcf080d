import io

import cv2
import numpy as np
import pytest
from PIL import Image

from tests.messages import refused
from tests.tiers import first_in_default_tier
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.photogrammetry.dense.undistortion import UndistortTask, undistort

W, H = 480, 360
LENSES = {
    "SIMPLE_PINHOLE": (400.0, 243.3, 177.2),
    "PINHOLE": (400.0, 410.0, 243.3, 177.2),
    "SIMPLE_RADIAL": (400.0, 243.3, 177.2, -0.12),
    "RADIAL": (400.0, 243.3, 177.2, 0.08, -0.05),
    "OPENCV": (400.0, 404.0, 243.3, 177.2, -0.1, 0.03, 0.002, -0.001),
    "FULL_OPENCV": (400.0, 404.0, 243.3, 177.2, -0.1, 0.03, 0.002, -0.001, 0.01, 0.01, 0.0, 0.0),
    "OPENCV_FISHEYE": (300.0, 300.0, 243.3, 177.2, 0.02, -0.01, 0.0, 0.0),
}


def png(picture):
    return cv2.imencode(".png", picture)[1].tobytes()


def view_of(model="PINHOLE", size=(W, H)):
    return View("a.jpg", Intrinsics(model, *size, LENSES[model]), np.eye(3), np.zeros(3))


def dots(view, points, sigma=2.0):
    """A photo with a round spot where each point is seen."""
    lens = view.intrinsics
    x, y = np.meshgrid(np.arange(lens.width) + 0.5, np.arange(lens.height) + 0.5)
    picture = np.zeros((lens.height, lens.width))
    for u, v in view.project(points):
        picture += 200.0 * np.exp(-0.5 * ((x - u) ** 2 + (y - v) ** 2) / sigma**2)
    return np.repeat(np.round(picture)[..., None], 3, axis=2).astype(np.uint8)


def spot(picture, at, reach=7):
    """The centre of gravity of the spot near a place, pixel centres at halves."""
    column, row = np.floor(at).astype(int)
    part = picture[row - reach : row + reach + 1, column - reach : column + reach + 1].astype(float)
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    middle = np.array([(part * x).sum(), (part * y).sum()]) / part.sum()
    return middle + [column + 0.5, row + 0.5]


@pytest.mark.parametrize("max_size", first_in_default_tier([None, 240, 331], 6))
@pytest.mark.parametrize("model", first_in_default_tier(LENSES, 6))
def test_points_are_where_the_undistorted_camera_projects_them(model, max_size):
    view = view_of(model)
    points = np.array([[x, y, 1.0] for x in (-0.42, -0.1, 0.37) for y in (-0.3, 0.02, 0.31)])
    sigma = 2.0 * W / (max_size or W)
    task = UndistortTask(png(dots(view, points, sigma)), None, view, max_size, is_lossless=True)
    straight = undistort(task)
    lens = straight.view.intrinsics
    assert lens.model == "PINHOLE"
    picture = straight.pixels()[..., 0]
    assert picture.shape == (lens.height, lens.width)
    assert max_size is None or max(picture.shape) <= max_size
    for wanted in straight.view.project(points):
        np.testing.assert_allclose(spot(picture, wanted), wanted, atol=0.06)


def test_orientation_tag_does_not_turn_the_pixels():
    stream = io.BytesIO()
    tags = Image.Exif()
    tags[0x0112] = 6
    picture = np.zeros((H, W, 3), np.uint8)
    picture[:, : W // 2] = [200, 100, 30]
    Image.fromarray(picture).save(stream, "JPEG", exif=tags, quality=95)
    pixels = undistort(UndistortTask(stream.getvalue(), None, view_of())).pixels()
    assert pixels.shape == (H, W, 3)
    np.testing.assert_allclose(pixels[H // 2, 20], [200, 100, 30], atol=6)


def test_exactly_the_masked_pixels_are_invalid_after_undistortion():
    mask = np.full((H, W), 255, np.uint8)
    mask[:, 300:] = 0
    task = UndistortTask(png(np.full((H, W, 3), 90, np.uint8)), png(mask), view_of(), 240)
    valid_mask = undistort(task).valid_mask
    assert valid_mask.shape == (180, 240)
    assert valid_mask[:, :149].all()
    assert not valid_mask[:, 151:].any()


def test_pixels_beyond_the_photo_are_masked():
    photo = png(np.full((H, W, 3), 90, np.uint8))
    straight = undistort(UndistortTask(photo, None, view_of("SIMPLE_RADIAL")))
    lens = straight.view.intrinsics
    assert lens.width > W
    assert straight.valid_mask[lens.height // 2].sum() < lens.width
    shown = view_of("SIMPLE_RADIAL").project(
        np.column_stack([lens.rays(np.argwhere(straight.valid_mask)[::97, ::-1] + 0.5)])
    )
    assert (shown > -0.01).all()
    assert (shown < [W + 0.01, H + 0.01]).all()
    assert undistort(UndistortTask(photo, None, view_of())).mask is None


@pytest.mark.parametrize("bytes_", [b"", b"no picture", b"\xff\xd8\xff\xe0 broken"])
def test_invalid_picture_or_mask_is_rejected(bytes_):
    with refused("photo.unreadable"):
        undistort(UndistortTask(bytes_, None, view_of()))
    photo = png(np.zeros((H, W, 3), np.uint8))
    with refused("mask.unreadable"):
        undistort(UndistortTask(photo, bytes_, view_of()))


def test_a_photo_or_mask_of_another_size_is_refused():
    with refused("photo.other-size"):
        undistort(UndistortTask(png(np.zeros((W, H, 3), np.uint8)), None, view_of()))
    photo = png(np.zeros((H, W, 3), np.uint8))
    with refused("mask.other-size"):
        undistort(UndistortTask(photo, png(np.zeros((300, 100), np.uint8)), view_of()))
