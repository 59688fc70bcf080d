"""Boxes that are longer than the screen scroll, and none is larger than it."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, QTimer
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import (
    QApplication,
    QDialog,
    QLabel,
    QPushButton,
    QScrollArea,
    QTextBrowser,
    QVBoxLayout,
    QWidget,
)

from tests import driver
from vomstudio.ui.base.open_dialogs import OpenDialogs
from vomstudio.ui.base.window_fitting import fit_to_screen


class Long(QDialog):
    """So many lines, and a button below them."""

    def __init__(self, lines: int) -> None:
        super().__init__()
        self.button = QPushButton("Do it")
        column = QVBoxLayout(self)
        for number in range(lines):
            column.addWidget(QLabel(f"Line {number}"))
        column.addWidget(self.button)
        self.resize(3000, 100)


def on_screen(widget) -> bool:
    screen = QGuiApplication.primaryScreen().availableGeometry()
    return widget.width() <= screen.width() and widget.height() <= screen.height()


@pytest.mark.parametrize("lines", [3, 200])
def test_long_dialog_fits_the_screen_and_scrolls_to_its_last_button(qtbot, lines):
    dialog = OpenDialogs().show(Long, lambda: Long(lines))
    qtbot.addWidget(dialog)
    driver.pause(50)
    assert on_screen(dialog)
    pressed = []
    dialog.button.clicked.connect(lambda: pressed.append(True))
    areas = dialog.findChildren(QScrollArea)
    assert bool(areas) == (lines > 100), "what is short does not scroll"
    for area in areas:
        area.verticalScrollBar().setValue(area.verticalScrollBar().maximum())
    driver.pause(50)
    place = dialog.button.mapTo(dialog, QPoint(10, 10))
    assert dialog.rect().contains(place)
    driver.click(dialog.button, QPoint(10, 10))
    assert pressed == [True]


def test_scrolling_dialog_is_wide_enough_for_its_contents(qtbot):
    dialog = Long(200)
    qtbot.addWidget(dialog)
    dialog.resize(100, 100)
    fit_to_screen(dialog)
    dialog.show()
    driver.pause(50)
    (area,) = dialog.findChildren(QScrollArea)
    assert area.viewport().width() >= dialog.button.minimumSizeHint().width()


def test_scrolling_dialog_uses_the_full_screen_height(qtbot):
    """One with an owner tells a height of 30 pixels until it is shown, and stayed a slit."""
    owner = QWidget()
    qtbot.addWidget(owner)
    dialog = QDialog(owner)
    column = QVBoxLayout(dialog)
    column.addWidget(lines := QLabel("\n".join(map(str, range(300)))))
    column.addWidget(QPushButton("Do it"))
    lines.setMinimumSize(lines.sizeHint())
    fit_to_screen(dialog)
    dialog.show()
    driver.pause(50)
    assert on_screen(dialog)
    assert dialog.height() > 0.9 * QGuiApplication.primaryScreen().availableGeometry().height()


def test_the_list_of_shortcuts_fits_the_screen(window):
    seen = {}

    def look() -> None:
        dialog = QApplication.activeModalWidget()
        seen["fits"] = on_screen(dialog)
        seen["text"] = dialog.findChild(QTextBrowser).toPlainText()
        dialog.close()

    QTimer.singleShot(300, look)
    window.actions_table.run("shortcuts")
    assert seen["fits"]
    for keys in ("Ctrl+1", "Ctrl+3", "Ctrl+Shift+P", "F9"):
        assert keys in seen["text"]
