"""Whatever cannot be used says why, in every panel and in every state that it is in."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QLineEdit,
    QWidget,
)

from tests import driver
from tests.messages import shown_codes
from tests.samples import ZIGZAG
from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.core.findings import Finding
from vomstudio.project import edits
from vomstudio.project.kinds.dimension import Dimension
from vomstudio.project.kinds.station import Station
from vomstudio.studio.tools.measure import MeasureTool
from vomstudio.studio.tools.station import StationTool
from vomstudio.ui.base.controls import set_enabled

CONTROLS = (QAbstractButton, QComboBox, QLineEdit, QAbstractSpinBox)


def silent(top: QWidget) -> Iterator[str]:
    """What in a panel is disabled and has no tooltip, nor stands in something that has one."""
    for control in top.findChildren(QWidget):
        if not isinstance(control, CONTROLS) or control.isEnabled():
            continue
        if not control.isVisibleTo(top) or isinstance(control.parentWidget(), QAbstractSpinBox):
            continue
        above: QWidget | None = control
        while above is not None and above is not top and not above.toolTip():
            above = above.parentWidget()
        if above is None or above is top:
            text = getattr(control, "text", lambda: "")()
            yield f"{type(control).__name__} {control.objectName()} {text!r}"


def all_panels(window) -> dict[str, list[str]]:
    found = {}
    for name in window.docks:
        window.docks[name].show()
        window.docks.bring_forward(name)
        QApplication.processEvents()
        driver.pause(20)
        if said := list(silent(window.docks[name])):
            found[name] = said
    return found


@pytest.mark.full
def test_disabled_controls_without_a_model_state_a_reason(window) -> None:
    assert all_panels(window) == {}


@pytest.mark.parametrize(
    "tool", first_in_default_tier(["trace", "plane", "line", "measure", "station", "lithology"])
)
def test_disabled_controls_with_a_project_state_a_reason(window, studio, tool) -> None:
    add_cliff(studio)
    add_bed(studio)
    studio.selection.set(["t1"])
    studio.activate(tool)
    assert all_panels(window) == {}


def test_controls_disabled_while_continuing_a_feature_state_a_reason(window, studio) -> None:
    add_cliff(studio)
    length = Dimension("d1", "D01", "distance", "m1", "0" * 64, ZIGZAG[:2])
    place = Station("s1", "S1", "m1", "0" * 64, ZIGZAG[:1])
    assert studio.attempt(edits.add_features, [length, place])
    for kind, id_ in ((MeasureTool, "d1"), (StationTool, "s1")):
        tool = studio.get_tool(kind)
        studio.activate(tool.name)
        tool.continue_feature(id_)
        assert list(silent(window.docks["tool"])) == []
        tool.cancel()


def test_disabled_controls_for_every_fracture_region_state_a_reason(window) -> None:
    window.docks.bring_forward("fractures")
    panel = window.docks["fractures"].widget().widget()
    for row in range(panel.region_box.count()):
        panel.region_box.setCurrentIndex(row)
        assert list(silent(panel)) == []


def test_enabling_a_control_restores_its_own_tooltip(qtbot) -> None:
    field = QLineEdit()
    qtbot.addWidget(field)
    field.setToolTip("A length.")
    for reason in (Finding("action.no-model"), Finding("job.stopped")):
        set_enabled(field, reason)
        assert not field.isEnabled()
        assert shown_codes(field.toolTip()) == {reason.code}
    set_enabled(field, None)
    assert field.isEnabled()
    assert field.toolTip() == "A length."
    field.setToolTip("Another length.")
    set_enabled(field, Finding("job.stopped"))
    set_enabled(field, None)
    assert field.toolTip() == "Another length."
