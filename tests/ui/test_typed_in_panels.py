"""What was typed in a panel is of the rock of one project, and another begins without it; what
stands along the axes of a drawing is read at every size."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtWidgets import QAbstractSpinBox, QDockWidget, QDoubleSpinBox, QLineEdit

from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_cliff
from vomstudio.ui.widgets.drawing_view import thin_ticks

DOCKS = (
    "section",
    "elevation",
    "bed_log",
    "fractures",
    "looked_at",
    "displacement",
    "three_points",
    "slopes",
)


def typed_fields(dock: QDockWidget) -> list[QLineEdit]:
    return [
        field
        for field in dock.findChildren(QLineEdit)
        if not isinstance(field.parentWidget(), QAbstractSpinBox) and field.objectName()
    ]


def number_fields(dock: QDockWidget) -> list[QDoubleSpinBox]:
    return [field for field in dock.findChildren(QDoubleSpinBox) if field.objectName()]


@pytest.mark.parametrize("dock", first_in_default_tier(DOCKS))
def test_new_project_starts_with_empty_fields(window, studio, dock, tmp_path) -> None:
    add_cliff(studio)
    window.docks.bring_forward(dock)
    fields = typed_fields(window.docks[dock])
    for field in fields:
        field.setText("12")
        field.setModified(True)
    numbers = number_fields(window.docks[dock])
    defaults = {number.objectName(): number.value() for number in numbers}
    for number in numbers:
        number.setValue(number.minimum() + 1)
    assert fields or numbers
    names = [field.objectName() for field in fields]
    studio.save_as(tmp_path / "one.vom")
    assert all(field.text() == "12" for field in fields), "saving takes nothing away"
    studio.new_project()
    window.docks.bring_forward(dock)
    again = typed_fields(window.docks[dock])
    assert [field.objectName() for field in again] == names
    assert [field.objectName() for field in again if field.text()] == []
    numbers = number_fields(window.docks[dock])
    assert {number.objectName(): number.value() for number in numbers} == defaults


def test_ticks_keep_a_minimum_distance() -> None:
    ticks = np.arange(-6, 7) * 2.0
    assert thin_ticks(ticks, 1.0) == ticks.tolist()
    thinned = thin_ticks(ticks, 4.5)
    assert thinned == [-12.0, -6.0, 0.0, 6.0, 12.0]
    assert np.diff(thinned).min() >= 4.5
    assert thin_ticks(ticks, 1000.0) == [0.0]
    assert thin_ticks(np.array([3.0]), 10.0) == [3.0]
