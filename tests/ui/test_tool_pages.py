"""A tool page shows at most six controls; the others are folded under "More"."""

from __future__ import annotations

import pytest
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSpinBox,
    QComboBox,
    QLineEdit,
    QWidget,
)

from tests import driver
from tests.geometry.test_brush import grid
from tests.ui.conftest import add_bed, add_open_cliff
from vomstudio.studio.tools.known_line import KnownLineTool
from vomstudio.studio.tools.measure import MeasureTool
from vomstudio.studio.tools.registry import TOOLS
from vomstudio.studio.tools.select import SelectTool
from vomstudio.ui.panels.tools.common import MAX_CONTROLS
from vomstudio.ui.widgets.more_section import ModeBar, MoreSection

CONTROLS = (QAbstractButton, QComboBox, QLineEdit, QAbstractSpinBox)


def is_part(widget: QWidget, page: QWidget) -> bool:
    """Whether a widget is a part of another control, of a table or of the verdict."""
    above = widget.parentWidget()
    while above is not None and above is not page:
        if isinstance(above, (*CONTROLS, ModeBar, QAbstractItemView)):
            return True
        above = above.parentWidget()
    return False


def controls(page: QWidget) -> list[str]:
    """The visible controls of a page; the buttons of one setting are one control."""
    found = [w for w in page.findChildren(QWidget) if w.isVisible() and not is_part(w, page)]
    return [
        f"{type(w).__name__} {w.objectName()}"
        for w in found
        if isinstance(w, (*CONTROLS, ModeBar)) and w.objectName() != "more"
    ]


def page_of(window) -> QWidget:
    window.docks.bring_forward("tool")
    driver.pause(30)
    return window.tool_panel.currentWidget()


@pytest.fixture
def cliff(window, studio):
    add_open_cliff(studio, grid(11, 4.0))
    add_bed(studio)
    return studio


def test_every_tool_page_has_few_controls(window, cliff):
    for entry in TOOLS:
        cliff.activate(entry.name)
        page = page_of(window)
        assert page.isVisible(), entry.name
        assert 0 < len(controls(page)) <= MAX_CONTROLS, (entry.name, controls(page))


@pytest.mark.full
def test_page_states_with_the_most_controls_stay_within_the_limit(window, cliff):
    cliff.activate("select")
    cliff.get_tool(SelectTool).set_target("surface")
    assert len(controls(page_of(window))) <= MAX_CONTROLS, controls(page_of(window))
    cliff.activate("measure")
    cliff.get_tool(MeasureTool).choose(kind="thickness")
    assert len(controls(page_of(window))) <= MAX_CONTROLS, controls(page_of(window))
    cliff.get_tool(KnownLineTool).choose("plane")
    cliff.activate("known_line")
    assert len(controls(page_of(window))) <= MAX_CONTROLS, controls(page_of(window))
    cliff.activate("navigate")
    assert controls(page_of(window)) == []


def test_more_unfolds_the_other_settings(window, cliff):
    cliff.activate("plane")
    page = page_of(window)
    before = controls(page)
    more = page.findChild(MoreSection)
    more.toggle.click()
    driver.pause(30)
    names = {name.partition(" ")[2] for name in controls(page)}
    assert {"brush_radius", "grow_angle", "grow_distance"} <= names
    more.toggle.click()
    assert controls(page) == before
