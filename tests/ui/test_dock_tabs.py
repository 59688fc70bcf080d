"""Names of panels that share a place are read whole, in a narrow window and in large letters."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QTabBar

from tests.tiers import first_in_default_tier


@pytest.fixture
def large_letters(qapp):
    before = qapp.font()
    large = qapp.font()
    large.setPointSizeF(before.pointSizeF() * 1.5)
    qapp.setFont(large)
    yield
    qapp.setFont(before)


@pytest.mark.parametrize(
    "name", first_in_default_tier(["register", "interpret", "analyse", "views"], 1)
)
def test_no_tab_is_cut(large_letters, window, qtbot, name) -> None:
    window.resize(1100, 700)
    window.workspaces.switch(name)
    qtbot.wait(100)
    direct = window.findChildren(QTabBar, options=Qt.FindChildOption.FindDirectChildrenOnly)
    bars = [b for b in direct if b.isVisible() and b.count() > 1]
    assert bars
    for bar in bars:
        for place in range(bar.count()):
            text = bar.tabText(place).replace("&", "")
            needed = bar.fontMetrics().horizontalAdvance(text)
            assert bar.tabRect(place).width() >= needed, text
