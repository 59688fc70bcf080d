"""A page that is created when it is first shown is there once its button was clicked."""

from __future__ import annotations

from functools import partial

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QScrollArea, QWidget

from tests.tiers import first_in_default_tier
from vomstudio.ui.base.controls import LazyScrollArea


def created(place: LazyScrollArea) -> bool:
    # Its `widget` would create it.
    return bool(QScrollArea.widget(place).findChildren(QWidget))


@pytest.mark.parametrize(
    "size", first_in_default_tier(map(pytest.param, [(1400, 900), (1000, 560)]))
)
@pytest.mark.parametrize("name", first_in_default_tier(["interpret", "results"], 1))
def test_clicking_a_page_button_creates_its_page(window, qtbot, name, size) -> None:
    window.resize(*size)
    window.workspaces.switch(name)
    qtbot.wait(100)
    clicked = 0
    for page, button in window.drawer_bar.buttons.items():
        if not button.isVisible():
            continue
        QTest.mouseClick(button, Qt.MouseButton.LeftButton)
        place = window.docks[page].widget()
        if isinstance(place, LazyScrollArea):
            qtbot.waitUntil(partial(created, place), timeout=3000)
            clicked += 1
    assert clicked
