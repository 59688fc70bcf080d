"""HEIF photos in the window: the whole photo and its thumbnail."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PySide6.QtGui import QImage

from vomstudio.io.photos.pixels import read_stored_image, thumbnail
from vomstudio.ui.base import photo_images

FOLDER = Path(__file__).parents[1] / "io" / "photos" / "heif"


def pixels_of(image: QImage) -> np.ndarray:
    image = image.convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
    return rows[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).copy()


class Unstopped:
    def emit(self, _: object) -> None:
        pass

    def check(self) -> None:
        pass


@pytest.mark.parametrize("name", ["level.heic", "turned.heic"])
def test_photo_is_stored_as_by_the_sensor_and_its_transform_turns_it_upright(name) -> None:
    picture = photo_images._read_pyramid(FOLDER / name, Unstopped())
    stored, size, orientation = read_stored_image(FOLDER / name, 1000)
    assert (picture.width, picture.height) == size
    np.testing.assert_array_equal(pixels_of(picture.levels[0]), stored)
    corner = picture.to_upright.map(0.0, 0.0)
    assert corner == {1: (0.0, 0.0), 6: (float(size[1]), 0.0)}[orientation]


@pytest.mark.parametrize("name", ["level.heic", "turned.heic"])
def test_thumbnail_is_upright(name) -> None:
    image = photo_images._read_thumbnail(FOLDER / name)
    side = 2 * photo_images.THUMBNAIL_SIZE.width()
    np.testing.assert_array_equal(pixels_of(image), thumbnail(FOLDER / name, side))
