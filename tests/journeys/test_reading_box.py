"""While something is picked, the live reading covers neither it nor the cursor; and a project that
is opened again shows nothing of what was going on before."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from shapely.geometry import LineString, Point, box

from tests import driver
from tests.driver import click, key, look_at, move
from vomstudio.studio.tools.line import LineTool
from vomstudio.studio.tools.trace import TraceTool

pytestmark = pytest.mark.full


def reading(window):
    """Where the reading is drawn."""
    window.viewport.repaint()
    x, y, wide, high = window.viewport.reading_position.box
    return box(x, y, x + wide, y + high)


def covers_nothing(window, at: QPoint) -> None:
    tool = window.studio.tools[window.studio.tool_name]
    shown = reading(window)
    line = window.viewport.preview.line
    pixels = window.viewport.camera.project(line, window.viewport.extent())[0]
    drawn = LineString([*pixels, (at.x(), at.y())]) if len(pixels) else Point(at.x(), at.y())
    assert not shown.intersects(drawn), (tool.name, at, shown.bounds)
    assert not any(shown.contains(Point(*p)) for p in pixels)
    whole = box(0, 0, window.viewport.width(), window.viewport.height())
    assert whole.contains(shown)


@pytest.mark.usefixtures("new_window")
@pytest.mark.parametrize("size", [(1280, 720), (1600, 1000)])
@pytest.mark.parametrize(("letter", "kind"), [("T", TraceTool), ("L", LineTool)])
def test_live_reading_never_covers_picked_points_or_the_cursor(
    window, outcrop, picks, letter, kind, size
):
    window.resize(*size)
    driver.open_outcrop(window, outcrop)
    window.docks.close_page("stereonet")
    points = np.concatenate([picks["B04"][2:22:3], picks["B03"][4:20:5][::-1]])
    look_at(window, points, 0.0, 10.0)
    key(window, Qt.Key(ord(letter)))
    boxes = []
    last = None
    for number, point in enumerate(points):
        at = driver.pixel(window, point)
        if last is not None:
            for share in (0.3, 0.6, 1.0):
                way = last + (at - last) * share
                move(window.viewport, way)
                covers_nothing(window, way)
        click(window.viewport, at)
        covers_nothing(window, at)
        boxes.append(reading(window).bounds)
        QTest.qWait(2)
        last = at
        if number == 5:
            driver.keep_picture(window, f"reading-{letter}-{size[0]}")
    assert window.studio.get_tool(kind).is_open
    # Over the whole view, where the cursor happens to pass.
    rect = window.viewport.rect().adjusted(6, 6, -6, -6)
    for x in np.linspace(rect.left(), rect.right(), 9):
        for y in np.linspace(rect.top(), rect.bottom(), 7):
            at = QPoint(int(x), int(y))
            move(window.viewport, at)
            covers_nothing(window, at)


def test_fitted_plane_disc_keeps_the_picked_line_visible(window, outcrop, picks):
    """Its disc is drawn under the line and lets the rock through."""
    driver.open_outcrop(window, outcrop)
    points = picks["B07"][:: max(1, len(picks["B07"]) // 12)]
    look_at(window, points, 0.0, 10.0)
    key(window, Qt.Key.Key_T)
    before = window.viewport.grab().toImage()
    driver.pick(window, points)
    assert window.viewport.preview.patch is not None
    driver.keep_picture(window, "reading-disc")
    window.viewport.gestures.leave()
    after = window.viewport.grab().toImage()
    preview = window.viewport.preview
    corners = window.viewport.camera.project(preview.patch, window.viewport.extent())[0]
    line = window.viewport.camera.project(preview.line, window.viewport.extent())[0]
    color = np.array(preview.color) * 255
    ring, drawn = box(*_bounds(corners)), LineString(line)
    middle = np.array(ring.centroid.coords[0])
    tint, shades = [], []
    for x in range(int(middle[0]) - 60, int(middle[0]) + 60, 5):
        for y in range(int(middle[1]) - 20, int(middle[1]) + 20, 5):
            if drawn.distance(Point(x, y)) < 12 or not _in_ring(corners, x, y):
                continue
            a, b = before.pixelColor(x, y), after.pixelColor(x, y)
            shades.append(a.lightnessF())
            tint.append(b.lightnessF())
    assert len(shades) > 20
    # What differs in the rock still differs under the disc: by more than half.
    assert np.std(tint) > 0.5 * np.std(shades)
    for (x, y), seen in zip(line, window.viewport.project(preview.line)[1], strict=True):
        if seen:
            found = after.pixelColor(round(x), round(y))
            assert np.abs(np.array(found.getRgb()[:3]) - color).max() < 90


def _bounds(pixels: np.ndarray) -> tuple[float, float, float, float]:
    (a, b), (c, d) = pixels.min(axis=0), pixels.max(axis=0)
    return float(a), float(b), float(c), float(d)


def _in_ring(pixels: np.ndarray, x: float, y: float) -> bool:
    from shapely.geometry import Polygon

    return Polygon(pixels).buffer(-3).contains(Point(x, y))


@pytest.mark.usefixtures("new_window")
@pytest.mark.parametrize("letter", ["T", "P", "L", "M"])
def test_reopened_project_looks_like_in_a_new_window(
    window, qtbot, outcrop, picks, tmp_path, letter
):
    """With a tool in the hand, a feature just made and the cursor on the outcrop."""
    window.resize(1280, 800)
    driver.open_outcrop(window, outcrop)
    points = picks["B04"][2:22:3]
    look_at(window, points, 0.0, 10.0)
    key(window, Qt.Key.Key_T)
    driver.pick(window, points)
    key(window, Qt.Key.Key_Return)
    key(window, Qt.Key(ord(letter)))
    move(window.viewport, driver.pixel(window, points[3]))
    window.view.save_camera()
    folder = tmp_path / "cliff.vom"
    window.studio.save_as(folder)
    window.studio.new_project()
    assert window.viewport.preview is None
    window.open_path(folder)
    driver.settled(window)
    driver.pause(300)
    assert window.studio.tool_name == "navigate"
    assert window.viewport.preview is None
    shape = window.viewport.cursor().shape()
    window.viewport.gestures.leave()
    again = at_rest(window.viewport)
    driver.keep_picture(window, f"reopened-{letter}")
    driver.dismiss(window)
    fresh = driver.make_window([folder])
    try:
        fresh.resize(1280, 800)
        driver.settled(fresh)
        driver.pause(300)
        fresh.viewport.gestures.leave()
        assert shape == fresh.viewport.cursor().shape() == Qt.CursorShape.ArrowCursor
        anew = at_rest(fresh.viewport)
        driver.keep_picture(fresh, f"anew-{letter}")
        assert differing(again, anew) < 0.001
    finally:
        driver.dismiss(fresh)


def at_rest(viewport):
    """The picture, once nothing of it changes: a busy machine is late with what was asked for."""
    pictures = [viewport.grab().toImage()]

    def same() -> bool:
        driver.pause(200)
        pictures.append(viewport.grab().toImage())
        return viewport.is_still and differing(*pictures[-2:]) == 0

    driver.wait(same, "the picture's rest")
    return pictures[-1]


def differing(a, b) -> float:
    """Share of the pixels that differ by more than a few shades."""
    assert a.size() == b.size()
    kind = a.Format.Format_RGB888
    one, other = (
        np.frombuffer(i.convertToFormat(kind).constBits(), np.uint8).astype(int) for i in (a, b)
    )
    return float((np.abs(one - other) > 12).mean())
