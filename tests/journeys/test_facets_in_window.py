"""Facets proposed on the sample, tried on a part, looked at, accepted, rejected, taken back."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from tests import driver
from vomstudio.document.kinds.patch import Patch
from vomstudio.paths import resource
from vomstudio.ui.interpret.facets_panel import FacetsPanel


@pytest.fixture
def panel(window) -> FacetsPanel:
    window.open_path(resource("sample", "sample.obj"))
    driver.settled(window)
    window.actions_table.run("propose_facets")
    made = window.findChild(FacetsPanel)
    driver.wait(made.isVisible, "the panel")
    driver.settled(window)
    return made


def scale(window):
    return window.viewport.display.scale_of(next(iter(window.studio.models)))


def find(window, panel) -> None:
    driver.click(panel.start, panel.start.rect().center())
    assert panel.start.text() == "Stop"
    driver.wait(lambda: panel._facets.found is not None, "the facets", 120.0)
    driver.wait(lambda: scale(window) is not None, "the colours", 60.0)
    driver.settled(window)


def test_facets(window, panel) -> None:
    find(window, panel)
    driver.keep_picture(window, "facets-all")
    for row in range(panel.colours.count()):
        panel.colours.setCurrentIndex(row)
        panel.colours.activated.emit(row)
        driver.pause(500)
        driver.settled(window)
        driver.keep_picture(window, f"facets-{panel.colours.currentData()}")
    panel.table.setFocus()
    panel.table.selectRow(panel.table.numbers.rowCount() - 1)
    driver.pause(300)
    driver.keep_picture(window, "facets-chosen")
    before = len(panel._facets.open)
    QTest.keyClick(panel.table, Qt.Key.Key_Return)
    assert len(window.studio.session.of(Patch)) == 1
    assert len(panel._facets.open) == before - 1
    QTest.keyClick(panel.table, Qt.Key.Key_Delete)
    assert len(panel._facets.open) == before - 2
    driver.settled(window)
    driver.keep_picture(window, "facets-accepted")
    print(panel.said.text())
