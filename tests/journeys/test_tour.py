"""The first tour, done as it says, left at any time, and never in the way."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QRect, QSize, Qt
from PySide6.QtGui import QCursor
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QToolButton

from tests import driver
from tests.driver import click, drag, key, wait
from vomstudio.io.settings import read_settings
from vomstudio.project.kinds.trace import Trace
from vomstudio.ui.base.number_formatting import orientation_text
from vomstudio.ui.dialogs.orthophoto_dialog import OrthoDialog
from vomstudio.ui.shell.tour import Tour
from vomstudio.ui.shell.tour_card import TourCard, place_card


def tour_of(window) -> Tour:
    return window.findChild(Tour)


def button_of_start_page(window, name: str) -> QToolButton:
    return next(
        b
        for b in window.start_page.findChildren(QToolButton)
        if b.defaultAction() is window.actions_table.all[name]
    )


@pytest.fixture
def touring(window):
    """A small window, and the tour as a new user finds it."""
    window.resize(1280, 720)
    driver.pause(50)
    button = button_of_start_page(window, "first_tour")
    assert button.isVisible()
    QTest.mouseClick(button, driver.LEFT, driver.NONE, button.rect().center())
    assert tour_of(window).step == 0
    return window


def card_of(window) -> TourCard:
    return tour_of(window)._card


def at_step(window, number: int) -> None:
    wait(lambda: tour_of(window).step == number, f"step {number + 1}", 20.0)
    card = tour_of(window)._card
    assert window.rect().contains(card.geometry())
    net = window.net_overlay
    place = QRect(net.mapTo(window, QPoint(0, 0)), net.size())
    assert not (net.isVisible() and place.intersects(card.geometry())), "the card is over the net"
    driver.keep_picture(window, f"tour-{number + 1}")


def rest_on(widget) -> None:
    QCursor.setPos(widget.mapToGlobal(widget.rect().center()))
    QTest.mouseMove(widget, widget.rect().center())


def test_every_tour_step_works_as_described_at_1280_x_720(touring, tmp_path):
    window = touring
    sample = button_of_start_page(window, "open_sample")
    QTest.mouseClick(sample, driver.LEFT, driver.NONE, sample.rect().center())
    driver.settled(window)
    at_step(window, 1)
    view = window.viewport
    middle = view.rect().center()
    drag(view, middle, middle + QPoint(60, 10))
    at_step(window, 2)
    driver.focus(window)
    key(window, Qt.Key.Key_T)
    at_step(window, 3)
    for k in range(5):
        click(view, middle + QPoint(-120 + 50 * k, 15 * (-1) ** k))
        QTest.qWait(450)
    at_step(window, 4)
    key(window, Qt.Key.Key_Return)
    at_step(window, 5)
    (trace,) = window.studio.session.of(Trace)
    assert orientation_text(window.studio.measure(trace), "dipdir/dip") in card_of(window).text
    assert len(window.studio.session.of(Trace)) == 1
    window.docks.bring_forward("properties")
    rest_on(window.properties)
    at_step(window, 6)
    rest_on(window.net)
    at_step(window, 7)
    driver.focus(window)
    key(window, Qt.Key.Key_P, driver.CTRL)
    wait(lambda: window.findChildren(OrthoDialog), "the dialog")
    dialog = window.findChildren(OrthoDialog)[0]
    driver.pause(400)
    assert tour_of(window).step == 7, "an open dialog is no orthophoto"
    driver.wait(lambda: dialog.gsd.text(), "the proposal")
    dialog.gsd.setText("0.1")
    dialog.target.setText(str(tmp_path / "ortho.tif"))
    dialog.accept()
    wait(lambda: tour_of(window).step == 8, "the orthophoto", 60.0)
    assert "ortho" in card_of(window).text
    at_step(window, 8)
    window.studio.save_as(tmp_path / "first.vom")
    at_step(window, 9)
    card = tour_of(window)._card
    QTest.mouseClick(card.next_button, driver.LEFT, driver.NONE, card.next_button.rect().center())
    assert tour_of(window).step is None
    assert not [w for w in window.findChildren(type(card)) if w.isVisible()]


@pytest.mark.full
def test_tour_is_offered_once_and_stays_in_the_menu(touring, qtbot):
    window = touring
    tour_of(window).end()
    assert not button_of_start_page(window, "first_tour").isVisible()
    assert read_settings()[0].offer_tour is False
    window.actions_table.run("first_tour")
    assert tour_of(window).step == 0


@pytest.mark.full
def test_esc_discards_the_open_feature_first_and_then_ends_the_tour(touring):
    window = touring
    window.actions_table.run("open_sample")
    driver.settled(window)
    driver.focus(window)
    key(window, Qt.Key.Key_T)
    middle = window.viewport.rect().center()
    for k in range(2):
        click(window.viewport, middle + QPoint(40 * k, 0))
        QTest.qWait(450)
    assert window.studio.open_tool is not None
    key(window, Qt.Key.Key_Escape)
    assert window.studio.open_tool is None
    assert tour_of(window).step is not None
    key(window, Qt.Key.Key_Escape)
    assert tour_of(window).step is None
    # And is the outcrop's again.
    click(window.viewport, middle)
    key(window, Qt.Key.Key_Escape)
    assert window.studio.open_tool is None


@pytest.mark.full
def test_all_tour_steps_can_be_skipped(touring):
    window = touring
    card = tour_of(window)._card
    for number in range(1, 10):
        QTest.mouseClick(
            card.next_button, driver.LEFT, driver.NONE, card.next_button.rect().center()
        )
        assert tour_of(window).step == number
    QTest.mouseClick(card.next_button, driver.LEFT, driver.NONE, card.next_button.rect().center())
    assert tour_of(window).step is None
    assert QApplication.activeModalWidget() is None


@pytest.mark.full
def test_closing_the_window_during_the_tour_raises_nothing(own_folders, qtbot):
    window = driver.make_window()
    window.actions_table.run("first_tour")
    driver.pause(200)
    driver.close(window)
    driver.pause(400)


@pytest.mark.full
@pytest.mark.parametrize("size", [(960, 600), (1280, 720), (1920, 1080)])
def test_tour_card_is_fully_visible_beside_its_target(size):
    """Over its target only where no side has room for it."""
    rng = np.random.default_rng(3)
    window, card = QSize(*size), QSize(264, 150)
    for _ in range(500):
        wide, high = rng.integers(20, size[0]), rng.integers(20, size[1])
        x, y = rng.integers(0, size[0] - wide + 1), rng.integers(0, size[1] - high + 1)
        target = QRect(int(x), int(y), int(wide), int(high))
        place = QRect(place_card(target, card, window), card)
        assert QRect(0, 0, *size).contains(place)
        gaps = (target.left(), size[0] - target.right(), target.top(), size[1] - target.bottom())
        needed = (card.width(), card.width(), card.height(), card.height())
        if any(gap >= need + 13 for gap, need in zip(gaps, needed, strict=True)):
            assert not place.intersects(target)
