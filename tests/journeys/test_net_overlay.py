"""The net over the outcrop hides no label, and labels are switched with a key."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QRect, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWidget

from tests import appearance, driver
from tests.driver import key, look_at, wait
from tests.journeys.conftest import SCREENS
from tests.tiers import first_in_default_tier
from vomstudio.project import edits
from vomstudio.project.kinds.trace import Trace

SHIFT = Qt.KeyboardModifier.ShiftModifier
SIZES = first_in_default_tier([(1280, 720), (1600, 1000), (960, 540)], 1)


@pytest.fixture
def interpreted(window, outcrop, picks):
    """The outcrop with its traces as beds, seen from the front."""
    model_id = driver.open_outcrop(window, outcrop)
    model = window.studio.records[model_id]
    for name, points in picks.items():
        vertices = tuple(tuple(p) for p in points.tolist())
        trace = Trace(name, name, "bedding", model_id, model.content_hash, vertices)
        assert window.studio.attempt(edits.add_trace, trace)
    return window


def face(window, picks) -> None:
    look_at(window, np.concatenate(list(picks.values())), 0.0, 10.0)
    wait(lambda: labels(window), "the labels", 5.0)


def labels(window) -> dict[str, QRect]:
    """Labels in the picture of the outcrop, with their places in the window."""
    viewport = window.viewport
    viewport.repaint()
    return {
        name: box.toRect().translated(viewport.mapTo(window, QPoint(0, 0)))
        for name, box in viewport.overlays.annotations.label_boxes
    }


def covered(window) -> QRect:
    net = window.net_overlay
    return QRect(net.mapTo(window, QPoint(0, 0)), net.size()) if net.isVisible() else QRect()


def drag_net(window, offset: QPoint) -> None:
    net, start = window.net_overlay, QPoint(4, 4)
    QTest.mousePress(net, driver.LEFT, pos=start)
    QTest.mouseMove(net, start + offset)
    QTest.mouseRelease(net, driver.LEFT, pos=start + offset)


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_labels_are_never_placed_under_the_net(interpreted, picks, width, height) -> None:
    window = interpreted
    window.resize(width, height)
    driver.pause(100)
    face(window, picks)
    assert not any(box.intersects(covered(window)) for box in labels(window).values())
    before = covered(window)
    drag_net(window, QPoint(-window.viewport.width() // 2, 40))
    assert covered(window) != before
    assert not any(box.intersects(covered(window)) for box in labels(window).values())
    window.docks.close_page("stereonet")
    driver.pause(50)
    shown = labels(window)
    assert any(box.intersects(before) for box in shown.values()) or len(shown) == len(picks)


def test_label_key_cycles_through_all_selected_and_none(interpreted, picks) -> None:
    window = interpreted
    face(window, picks)
    window.studio.selection.set(["B04"])
    seen = set()
    for _ in range(4):
        key(window, Qt.Key.Key_L, SHIFT)
        driver.pause(20)
        seen.add(frozenset(labels(window)))
    assert frozenset() in seen
    assert frozenset({"B04"}) in seen
    assert max(map(len, seen)) > 4


@pytest.mark.full
@pytest.mark.parametrize(("width", "height"), SIZES)
def test_net_buttons_do_not_shrink_the_net(interpreted, width, height) -> None:
    """They come under the cursor, below the net, and each can be read."""
    window = interpreted
    window.resize(width, height)
    driver.pause(100)
    overlay = window.net_overlay
    side = overlay.width()
    assert window.net.canvas.width() == side
    overlay._show_tools(True)
    driver.pause(100)
    assert window.net.tools.isVisible()
    assert window.net.canvas.width() == side
    assert window.net.canvas.height() >= side
    assert window.viewport.rect().contains(overlay.geometry())
    assert appearance.violations(window.net.tools) == []
    overlay._show_tools(False)


@pytest.mark.full
@pytest.mark.parametrize("screen", SCREENS, indirect=True)
def test_outcrop_beside_round_net_is_clickable(screen, interpreted) -> None:
    window = interpreted
    overlay, net = window.net_overlay, window.net
    wait(lambda: net.is_up_to_date and net.artists is not None, "the net")
    driver.pause(100)
    driver.keep_picture(window, f"round-net-{screen}")

    def above(place: QPoint) -> QWidget:
        return window.childAt(overlay.mapTo(window, place))

    corner = QPoint(3, 3)
    assert above(corner) is window.viewport
    centre = net.canvas.mapTo(overlay, net.canvas.rect().center())
    assert above(centre) is net.canvas
    window.studio.selection.set(["B04"])
    driver.pause(100)
    label = net._corner_label
    assert above(label.mapTo(overlay, QPoint(6, label.height() // 2))) is net.canvas
    # The buttons need the corner.
    QApplication.sendEvent(overlay, QEvent(QEvent.Type.Enter))
    assert above(corner) is not window.viewport
    overlay._hide_buttons()
    wait(lambda: above(corner) is window.viewport, "the free corner", 5.0)
    for action in ("net_in_middle", "net_in_middle"):
        window.actions_table.run(action)
        driver.pause(300)
    wait(lambda: above(corner) is window.viewport, "the overlay again", 5.0)
