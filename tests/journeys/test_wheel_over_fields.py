"""The wheel over a panel scrolls it, and changes no value that happens to lie under the cursor."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import (
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QDockWidget,
    QSlider,
    QWidget,
)

from tests import driver

pytestmark = pytest.mark.full

FIELDS = (QAbstractSpinBox, QComboBox, QSlider)


def wheel(widget: QWidget, turns: int = -1) -> None:
    middle = QPointF(widget.rect().center())
    event = QWheelEvent(
        middle,
        QPointF(widget.mapToGlobal(middle.toPoint())),
        QPoint(),
        QPoint(0, 120 * turns),
        Qt.MouseButton.NoButton,
        Qt.KeyboardModifier.NoModifier,
        Qt.ScrollPhase.NoScrollPhase,
        False,
    )
    QApplication.sendEvent(widget, event)


def value(field: QWidget) -> object:
    if isinstance(field, QComboBox):
        return field.currentIndex()
    return field.value() if isinstance(field, QSlider) else field.text()


def fields(above: QWidget) -> list[QWidget]:
    return [f for f in above.findChildren(QWidget) if isinstance(f, FIELDS)]


def turned(above: QWidget) -> list[str]:
    """Names of the fields that the wheel changes, or gives the keyboard to."""
    changed = []
    for field in fields(above):
        before = value(field)
        for turns in (-1, 1, 1):
            wheel(field, turns)
            takes_focus = field.focusPolicy() == Qt.FocusPolicy.WheelFocus
            if value(field) != before or takes_focus:
                changed.append(f"{type(field).__name__} {field.objectName()} {before}")
                break
    return changed


def test_wheel_over_panel_fields_changes_no_value(window, outcrop):
    driver.open_outcrop(window, outcrop)
    for dock in window.findChildren(QDockWidget):
        window.docks.bring_forward(dock.objectName())
        driver.pause(5)
    for tool in ("trace", "plane", "select", "line", "measure"):
        window.actions_table.run(tool)
        driver.pause(5)
    assert len(fields(window)) > 40
    assert turned(window) == []


def test_no_field_uses_a_plain_qt_class_that_reacts_to_the_wheel():
    """Dialogs, too."""
    folder = Path(__file__).resolve().parents[2] / "vomstudio"
    plain = re.compile(r"(?<!\w)Q(?:DoubleSpinBox|SpinBox|ComboBox|Slider|DateEdit|Dial)\(")
    made = [
        f"{path.name}: {found}"
        for path in sorted(folder.rglob("*.py"))
        for found in plain.findall(path.read_text(encoding="utf-8"))
    ]
    assert made == []
