"""Names of pages are read whole, in a narrow window and in large letters."""

from __future__ import annotations

import pytest
from PySide6.QtWidgets import QToolButton

from tests.tiers import first_in_default_tier


@pytest.fixture
def large_letters(qapp):
    before = qapp.font()
    large = qapp.font()
    large.setPointSizeF(before.pointSizeF() * 1.5)
    qapp.setFont(large)
    yield
    qapp.setFont(before)


@pytest.mark.parametrize("name", first_in_default_tier(["model", "interpret", "results"], 1))
def test_no_tab_is_truncated(large_letters, window, qtbot, name) -> None:
    window.resize(1100, 700)
    window.workspaces.switch(name)
    qtbot.wait(100)
    title = window.docks[window.docks.page("inspector")].titleBarWidget()
    buttons = [button for button in title.findChildren(QToolButton) if button.text()]
    assert len([button for button in buttons if button.isVisible()]) == 3
    for button in buttons:
        needed = button.fontMetrics().horizontalAdvance(button.text())
        assert button.width() >= needed, button.text()
        assert button.visibleRegion().boundingRect().size() == button.size(), button.text()
