"""Faces and points chosen by hand in the window that people use."""

from __future__ import annotations

import math

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QMouseEvent, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tests import driver
from tests.driver import CTRL, LEFT, NONE, click, drag, key, look_at, move, open_outcrop, pixel, wait
from vomstudio.document.kinds.patch import Patch
from vomstudio.geometry.patches import ids_of
from vomstudio.tools.select import SelectTool
from vomstudio.ui.interpret.tool_panels.select import SelectPanel

SHIFT = Qt.KeyboardModifier.ShiftModifier


def patches(window) -> list[Patch]:
    return window.studio.session.of(Patch)


def draw(window, ring: list[QPoint], modifier=NONE, *, release: bool = True) -> None:
    """Hold the left button along a line."""
    viewport = window.viewport

    def send(kind, at, held):
        changed = Qt.MouseButton.NoButton if kind == QEvent.Type.MouseMove else LEFT
        where = QPointF(at)
        event = QMouseEvent(kind, where, QPointF(viewport.mapToGlobal(at)), changed, held, modifier)
        QApplication.sendEvent(viewport, event)

    send(QEvent.Type.MouseButtonPress, ring[0], LEFT)
    for start, end in zip(ring, ring[1:], strict=False):
        for step in range(1, 5):
            send(QEvent.Type.MouseMove, start + (end - start) * step / 4, LEFT)
        QApplication.processEvents()
    if release:
        send(QEvent.Type.MouseButtonRelease, ring[-1], Qt.MouseButton.NoButton)
    driver.pause(5)


def circle(at: QPoint, radius: float, count: int = 24) -> list[QPoint]:
    turns = [2.0 * math.pi * k / count for k in range(count + 1)]
    return [at + QPoint(round(radius * math.cos(t)), round(radius * math.sin(t))) for t in turns]


def ready(window, outcrop, picks) -> QPoint:
    """Before the middle of a bed, with the tool in hand; where that is on the view."""
    open_outcrop(window, outcrop)
    wait(
        lambda: all(m.surface._faces_of is not None for m in window.studio.models.values()),
        "the search structures",
    )
    look_at(window, picks["B04"], 0.0, 10.0)
    key(window, Qt.Key.Key_S)
    assert window.studio.tool_name == "select"
    return pixel(window, np.median(picks["B04"], axis=0))


def test_a_lasso_makes_a_patch_that_is_one_edit(own_folders, qtbot, outcrop, picks):
    window = driver.make_window()
    studio, viewport, tool = window.studio, window.viewport, window.studio.tool_of(SelectTool)
    at = ready(window, outcrop, picks)
    assert driver.tool_panel(window, SelectPanel).isVisible()
    camera = viewport.moves.camera_state()
    draw(window, circle(at, 60), release=False)
    assert tool.drawing
    assert viewport.preview.outline is not None
    driver.keep_picture(window, "select-1-drawing")
    key(window, Qt.Key.Key_Escape)
    assert not tool.open
    QTest.mouseRelease(viewport, LEFT, NONE, at)
    assert tool.count == 0
    draw(window, circle(at, 60))
    assert tool.count > 20
    assert viewport.moves.camera_state() == camera
    assert viewport.preview.area is not None
    assert driver.tool_panel(window, SelectPanel).fit_view.isVisible()
    driver.keep_picture(window, "select-2-chosen")

    # What is chosen are the faces whose centres lie inside, and which are seen.
    model = driver.model(window)
    mesh = studio.models[model.id].data
    chosen = tool.chosen.ids()
    centres = mesh.vertices[mesh.faces[chosen]].mean(axis=1)
    rows = np.array(model.to_world)
    pixels, seen = viewport.project(centres @ rows[:3, :3].T + rows[:3, 3])
    assert (np.hypot(*(pixels - [at.x(), at.y()]).T) < 62.0).all()
    assert seen.mean() > 0.95

    # One more place with Shift, one less with Ctrl, steps back with Ctrl+Z.
    first = tool.count
    draw(window, circle(at + QPoint(90, 0), 40), SHIFT)
    more = tool.count
    assert more > first
    draw(window, circle(at, 20), CTRL)
    less = tool.count
    assert less < more
    key(window, Qt.Key.Key_Z, CTRL)
    assert tool.count == more
    key(window, Qt.Key.Key_Return)
    (patch,) = patches(window)
    assert len(ids_of(patch.runs)) == more
    assert not tool.open
    assert studio.selection.ids == (patch.id,)
    assert viewport.features.drawings[patch.id].area is not None
    driver.keep_picture(window, "select-3-patch")
    key(window, Qt.Key.Key_Z, CTRL)
    assert patches(window) == []
    key(window, Qt.Key.Key_Y, CTRL)
    assert patches(window) == [patch]
    driver.dismiss(window)
