"""Fields of the outcrop, asked for with mouse and keys, painted on it, and there again later."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from tests import driver
from vomstudio.ui.interpret.fields_panel import FieldsPanel


@pytest.fixture
def panel(window, outcrop) -> FieldsPanel:
    driver.open_outcrop(window, outcrop)
    window.actions_table.run("surface_fields")
    made = window.findChild(FieldsPanel)
    driver.wait(made.isVisible, "the panel")
    driver.settled(window)
    return made


def choose(panel: FieldsPanel, kind: str) -> None:
    """As with the arrow keys in the list."""
    panel.kind.setFocus()
    step = (
        Qt.Key.Key_Down if panel.kind.findData(kind) > panel.kind.currentIndex() else Qt.Key.Key_Up
    )
    while panel.kind.currentData() != kind:
        QTest.keyClick(panel.kind, step)


def shown(window):
    """The scale that the colours have."""
    id_ = next(iter(window.studio.models))
    return window.viewport.display.scale_of(id_)


def show(window, panel, kind: str) -> None:
    choose(panel, kind)
    if shown(window) is None or panel._fields.name_of(panel._model.id, panel._wanted()) is None:
        pass
    driver.click(panel.start, panel.start.rect().center())
    name = panel._fields.name_of(panel._model.id, panel._wanted())
    from vomstudio.rendering.view.scalars import title_of

    driver.wait(
        lambda: (s := shown(window)) is not None and s.title == title_of(name), f"{kind}", 60.0
    )


def test_fields(window, panel) -> None:
    for kind in ("dip", "dip_direction", "steepness", "curvature", "roughness", "coplanarity"):
        show(window, panel, kind)
        driver.settled(window)
        driver.keep_picture(window, f"fields-{kind}")
