"""A panel that is made when it is first seen is there once its tab was clicked."""

from __future__ import annotations

from functools import partial

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QScrollArea, QTabBar, QWidget

from tests.tiers import first_in_default_tier
from vomstudio.ui.base.controls import LazyScrollArea


def tab_bars(window) -> list[QTabBar]:
    direct = Qt.FindChildOption.FindDirectChildrenOnly
    return [b for b in window.findChildren(QTabBar, options=direct) if b.isVisible()]


def made(place: LazyScrollArea) -> bool:
    # Its `widget` would make it.
    return bool(QScrollArea.widget(place).findChildren(QWidget))


@pytest.mark.parametrize("size", first_in_default_tier([(1400, 900), (1000, 560)]))
@pytest.mark.parametrize(
    "name", first_in_default_tier(["register", "interpret", "analyse", "views"])
)
def test_no_panel_is_empty_whose_tab_is_clicked(window, qtbot, name, size) -> None:
    window.resize(*size)
    window.workspaces.switch(name)
    qtbot.wait(100)
    clicked = 0
    for bar in tab_bars(window):
        for place in range(bar.count()):
            title = bar.tabText(place).replace("&", "")
            bar.setCurrentIndex(max(place - 1, 0))
            QTest.mouseClick(bar, Qt.MouseButton.LeftButton, pos=bar.tabRect(place).center())
            dock = next(d for d in window.docks.values() if d.windowTitle() == title)

            if not isinstance(dock.widget(), LazyScrollArea):
                continue
            qtbot.waitUntil(partial(made, dock.widget()), timeout=3000)
            clicked += 1
    assert clicked
