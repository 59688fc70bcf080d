"""Photos as they are stored and as they are looked at."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QImageReader

from vomstudio.studio.tools.interaction_types import Pointer
from vomstudio.ui.base.photo_images import PhotoImages, PhotoPyramid
from vomstudio.ui.widgets.photo_canvas import Drawn, PhotoCanvas, PhotoPointer

WIDE, HIGH = 60, 40
RED = (52, 7)
"""Column and row of the only red pixel of the stored picture."""


def stored(folder: Path, orientation: int) -> Path:
    pixels = np.full((HIGH, WIDE, 3), 90, np.uint8)
    pixels[RED[1], RED[0]] = (255, 0, 0)
    exif = Image.Exif()
    exif[0x0112] = orientation
    path = folder / f"{orientation}.tif"
    Image.fromarray(pixels).save(path, exif=exif)
    return path


@pytest.fixture
def images(qtbot):
    made = PhotoImages()
    yield made
    made.close()


def read(images: PhotoImages, path: Path, qtbot) -> PhotoPyramid | str:
    with qtbot.waitSignal(images.picture_loaded, timeout=10_000) as got:
        assert images.picture(path) is None
    return got.args[1]


@pytest.mark.parametrize("orientation", range(1, 9))
def test_photo_is_shown_upright_in_file_pixel_coordinates(
    orientation, tmp_path, images, qtbot
) -> None:
    path = stored(tmp_path, orientation)
    picture = read(images, path, qtbot)
    assert isinstance(picture, PhotoPyramid)
    assert (picture.width, picture.height) == (WIDE, HIGH)
    # Where Qt's own turning puts the red pixel.
    reader = QImageReader(str(path))
    reader.setAutoTransform(True)
    turned = reader.read()
    (where,) = [
        (x, y)
        for x in range(turned.width())
        for y in range(turned.height())
        if turned.pixelColor(x, y).red() > 200 and turned.pixelColor(x, y).green() < 60
    ]
    there = picture.to_upright.map(QPointF(RED[0] + 0.5, RED[1] + 0.5))
    assert (there.x(), there.y()) == (where[0] + 0.5, where[1] + 0.5)
    # The same on the screen, for pictures, lines and clicks.
    canvas = PhotoCanvas()
    qtbot.addWidget(canvas)
    canvas.resize(600, 600)
    canvas.show()
    canvas.set_photo(WIDE, HIGH)
    canvas.set_picture(picture)
    x, y = canvas.to_widget([RED[0] + 0.5, RED[1] + 0.5])[0]
    seen = canvas.grab().toImage()
    color = seen.pixelColor(QPoint(round(x), round(y)))
    assert color.red() > 200
    assert color.green() < 60
    assert np.allclose(canvas.pixel_at(QPointF(x, y)), (RED[0] + 0.5, RED[1] + 0.5))
    got: list[PhotoPointer] = []
    canvas.pointed.connect(got.append)
    qtbot.mouseClick(canvas, Qt.MouseButton.LeftButton, pos=QPoint(round(x), round(y)))
    assert [p.kind for p in got] == [Pointer.CLICK]
    assert (int(got[0].x), int(got[0].y)) == RED


def test_camera_pixels_are_scaled_to_a_resized_photo(tmp_path, images, qtbot) -> None:
    """The photos were halved after they had been aligned."""
    picture = read(images, stored(tmp_path, 6), qtbot)
    canvas = PhotoCanvas()
    qtbot.addWidget(canvas)
    canvas.resize(600, 600)
    canvas.show()
    canvas.set_photo(2 * WIDE, 2 * HIGH)
    canvas.set_picture(picture)
    x, y = canvas.to_widget([2 * RED[0] + 1.0, 2 * RED[1] + 1.0])[0]
    assert canvas.grab().toImage().pixelColor(QPoint(round(x), round(y))).red() > 200


# The reader of JPEG says on its own account what is wrong with the file.
@pytest.mark.qt_log_level_fail("CRITICAL")
def test_damaged_photo_is_reported(tmp_path, images, qtbot) -> None:
    path = tmp_path / "broken.jpg"
    path.write_bytes(b"\xff\xd8\xff\xe0 no picture")
    assert isinstance(read(images, path, qtbot), str)


def test_zooming_keeps_the_pixel_under_the_cursor(qtbot) -> None:
    canvas = PhotoCanvas()
    qtbot.addWidget(canvas)
    canvas.resize(300, 200)
    canvas.set_photo(3000, 2000)
    at = QPointF(70, 160)
    before = canvas.pixel_at(at)
    for factor in (1.7, 3.0, 0.8):
        canvas.zoom(factor, at)
        assert np.allclose(canvas.pixel_at(at), before)
    canvas.fit()
    assert np.allclose(canvas.pixel_at(QPointF(0, 0)), (0, 0))
    canvas.look_at(np.array([[1000.0, 900.0], [1040.0, 930.0]]))
    assert canvas.contains_pixels(np.array([[1000.0, 900.0], [1040.0, 930.0]]))


def test_features_are_clipped_to_the_photo(qtbot) -> None:
    canvas = PhotoCanvas()
    qtbot.addWidget(canvas)
    canvas.resize(600, 200)
    canvas.set_photo(300, 200)
    canvas.fit()
    empty = canvas.grab().toImage()
    across = np.column_stack([np.linspace(-200.0, 500.0, 80), np.full(80, 100.0)])
    is_seen = (across[:, 0] > 0.0) & (across[:, 0] < 300.0)
    canvas.set_features(
        [Drawn("a", across, is_seen, (1.0, 0.0, 0.0), "", None, False)], frozenset()
    )
    shown = canvas.grab().toImage()
    changed = {
        x
        for x in range(shown.width())
        for y in range(shown.height())
        if shown.pixelColor(x, y) != empty.pixelColor(x, y)
    }
    left, right = canvas.to_widget([[0.0, 0.0], [300.0, 0.0]])[:, 0]
    assert changed
    assert min(changed) >= left - 1.0
    assert max(changed) <= right + 1.0
