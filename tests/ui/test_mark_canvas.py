"""Drawing and marking in photos that are stored in any of the eight orientations."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from PySide6.QtCore import QPoint, QPointF, Qt

from tests.driver import drag
from vomstudio.io.photos.pixels import rotate_pixels_upright
from vomstudio.studio.tools.interaction_types import Pointer
from vomstudio.ui.base.photo_images import PhotoImages, PhotoPyramid
from vomstudio.ui.panels.photos.mark_canvas import BRUSH, MARK, POLYGON, MarkCanvas, ShownMark
from vomstudio.ui.widgets.photo_canvas import PhotoPointer

WIDE, HIGH = 60, 40
RED = (52, 7)
"""Column and row of the only red pixel of the stored photo."""
MIDDLE = (RED[0] + 0.5, RED[1] + 0.5)

orientations = pytest.mark.parametrize("orientation", range(1, 9))


@pytest.fixture
def shown(tmp_path: Path, qtbot):
    """Makes a canvas with a small photo of an orientation."""
    images = PhotoImages()

    def make(orientation: int) -> MarkCanvas:
        pixels = np.full((HIGH, WIDE, 3), 90, np.uint8)
        pixels[RED[1], RED[0]] = (255, 0, 0)
        exif = Image.Exif()
        exif[0x0112] = orientation
        path = tmp_path / f"{orientation}.tif"
        Image.fromarray(pixels).save(path, exif=exif)
        with qtbot.waitSignal(images.picture_loaded, timeout=10_000) as got:
            assert images.picture(path) is None
        assert isinstance(got.args[1], PhotoPyramid)
        canvas = MarkCanvas()
        qtbot.addWidget(canvas)
        canvas.resize(600, 600)
        canvas.show()
        canvas.set_photo(WIDE, HIGH)
        canvas.set_picture(got.args[1])
        return canvas

    yield make
    images.close()


def at(canvas: MarkCanvas, pixel: tuple[float, float]) -> QPoint:
    x, y = canvas.to_widget(pixel)[0]
    return QPoint(round(float(x)), round(float(y)))


@orientations
def test_mark_is_stored_in_file_pixels_for_any_orientation(orientation, shown, qtbot) -> None:
    canvas = shown(orientation)
    canvas.set_tool(MARK)
    place = at(canvas, MIDDLE)
    color = canvas.grab().toImage().pixelColor(place)
    assert color.red() > 200
    assert color.green() < 60
    got: list[PhotoPointer] = []
    canvas.pointed.connect(got.append)
    qtbot.mouseClick(canvas, Qt.MouseButton.LeftButton, pos=place)
    assert got[0].kind is Pointer.CLICK
    assert (got[0].x, got[0].y) == pytest.approx(MIDDLE, abs=0.1)
    # Upright by EXIF's own table, and not by Qt's.
    turned = rotate_pixels_upright([MIDDLE, (0.5, 0.5)], orientation, WIDE, HIGH)
    on = canvas.to_widget([MIDDLE, (0.5, 0.5)])
    scale = canvas._scale
    assert (on[0] - on[1]) / scale == pytest.approx(turned[0] - turned[1])


@orientations
def test_arrow_key_moves_a_mark_in_its_screen_direction(orientation, shown, qtbot) -> None:
    canvas = shown(orientation)
    canvas.set_tool(MARK)
    got: list[tuple[float, float]] = []
    canvas.nudged.connect(lambda dx, dy: got.append((dx, dy)))
    ways = {
        Qt.Key.Key_Left: (-1, 0),
        Qt.Key.Key_Right: (1, 0),
        Qt.Key.Key_Up: (0, -1),
        Qt.Key.Key_Down: (0, 1),
    }
    for key, way in ways.items():
        qtbot.keyClick(canvas, key)
        moved = np.add(MIDDLE, got[-1])
        step = canvas.to_widget(moved)[0] - canvas.to_widget(MIDDLE)[0]
        assert step / canvas._scale == pytest.approx(np.multiply(way, 0.1), abs=1e-9)
        qtbot.keyClick(canvas, key, Qt.KeyboardModifier.ShiftModifier)
        assert np.hypot(*got[-1]) == pytest.approx(1.0)


@orientations
def test_mask_is_tinted_at_its_file_pixels_for_any_orientation(orientation, shown) -> None:
    canvas = shown(orientation)
    used = np.ones((HIGH, WIDE), bool)
    used[20:30, 5:15] = False
    canvas.set_used(used)
    image = canvas.grab().toImage()
    hidden, free = (image.pixelColor(at(canvas, p)) for p in ((10.0, 25.0), (40.0, 25.0)))
    assert hidden.red() > hidden.green() + 30
    assert free.red() == free.green()
    # To the pixel.
    for x, y, masked in (
        (5.3, 22.0, True),
        (4.7, 22.0, False),
        (9.0, 29.7, True),
        (9, 30.3, False),
    ):
        color = image.pixelColor(at(canvas, (x, y)))
        assert (color.red() > color.green() + 30) == masked
    used[:] = True
    canvas.update_mask()
    color = canvas.grab().toImage().pixelColor(at(canvas, (10.0, 25.0)))
    assert color.red() == color.green()


@orientations
def test_magnifier_shows_the_pixels_under_the_cursor(orientation, shown, qtbot) -> None:
    canvas = shown(orientation)
    canvas.set_tool(MARK)
    canvas.resize(1000, 800)
    canvas.fit()
    canvas.zoom(0.5)
    place = at(canvas, MIDDLE)
    qtbot.mouseMove(canvas, place)
    canvas._cursor = QPointF(place)
    canvas.underMouse = lambda: True  # type: ignore[method-assign]
    image = canvas.grab().toImage()
    # Its pixels are larger than those of the photo, and red in the middle, beside the cross.
    gap = 84.0 + 34.0
    right = place.x() + gap + 84.0 < canvas.width()
    above = place.y() - gap - 84.0 > 0
    middle = QPoint(
        round(place.x() + (gap if right else -gap)), round(place.y() + (-gap if above else gap))
    )
    color = image.pixelColor(middle)
    assert color.red() > color.green() + 80


def test_shift_slows_down_a_dragged_mark(shown, qtbot) -> None:
    canvas = shown(1)
    canvas.set_tool(MARK)
    canvas.set_marks([ShownMark("A", "tie", MIDDLE, True)])
    got: list[tuple[float, float]] = []
    canvas.pointed.connect(
        lambda e: (
            got.append(canvas.dragged_pixel((e.x, e.y)))
            if e.kind in (Pointer.DRAG_MOVE, Pointer.DRAG_END)
            else None
        )
    )
    start = at(canvas, MIDDLE) + QPoint(3, 0)
    drag(canvas, start, start - QPoint(200, 0), modifier=Qt.KeyboardModifier.ShiftModifier)
    assert got[-1][0] == pytest.approx(MIDDLE[0] - 200 / canvas._scale / 10, abs=0.05)
    got.clear()
    drag(canvas, start, start - QPoint(200, 0))
    assert got[-1][0] == pytest.approx(MIDDLE[0] - 200 / canvas._scale, abs=0.05), (
        "it keeps its distance from the cursor"
    )


@pytest.mark.parametrize("tool", [POLYGON, BRUSH, MARK])
def test_wheel_keeps_the_pixel_under_the_cursor_with_every_tool(tool, shown) -> None:
    canvas = shown(6)
    canvas.set_tool(tool)
    here = QPointF(200, 410)
    before = canvas.pixel_at(here)
    canvas.zoom(2.0, here)
    assert canvas.pixel_at(here) == pytest.approx(before)


def test_zoom_to_pixel_centres_the_pixel(shown) -> None:
    canvas = shown(8)
    canvas.zoom_to_pixel((50.0, 10.0))
    assert at(canvas, (50.0, 10.0)) == QPoint(300, 300)
