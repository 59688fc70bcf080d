"""Messages stand over the viewport without moving it; hints go by themselves."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QPushButton

from tests import driver
from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.project.folder import ProjectFolder
from vomstudio.ui.base.controls import ComboBox
from vomstudio.ui.panels.tools.trace import TracePanel

HINT, WARNING = "click on the outcrop", "the disk is full"


@pytest.mark.full
def test_message_does_not_move_the_view(window, studio):
    centre = window.centralWidget()
    before = [centre.layout().itemAt(i).geometry() for i in range(centre.layout().count())]
    studio.warn("something to be read " * 30)
    QApplication.processEvents()
    assert window.message_bar.isVisible()
    assert window.message_bar.width() == centre.width()
    after = [centre.layout().itemAt(i).geometry() for i in range(centre.layout().count())]
    assert after == before


def test_hint_disappears_and_does_not_replace_a_warning(window, studio):
    studio.hint(HINT)
    assert window.message_bar.text == HINT
    studio.tool_changed()
    assert not window.message_bar.isVisible()
    studio.warn(WARNING)
    studio.hint(HINT)
    assert window.message_bar.text == WARNING
    studio.tool_changed()
    assert window.message_bar.isVisible()


def test_unread_messages_are_counted_and_shown_on_click(window, studio):
    bar = window.message_bar
    earlier = bar._earlier_button

    studio.hint(HINT)
    studio.warn(WARNING)
    studio.warn(WARNING)
    assert not earlier.isVisible()
    studio.warn("a photo is damaged")
    assert earlier.isVisible()
    assert earlier.text() == "1 earlier message"
    studio.warn("another photo is damaged")
    assert earlier.text() == "2 earlier messages"

    assert not window.docks["messages"].isVisible()
    QTest.mouseClick(earlier, Qt.MouseButton.LeftButton)
    QApplication.processEvents()
    assert window.docks["messages"].isVisible()
    said = [window.messages.item(i).text() for i in range(window.messages.count())]
    assert sum(WARNING in text for text in said) == 2

    bar.hide()
    studio.warn("the model is gone")
    assert not earlier.isVisible()


@pytest.mark.parametrize("box", first_in_default_tier(["trace", "type_id", "method"]))
def test_wheel_over_a_combo_box_changes_nothing(window, studio, box):
    add_cliff(studio)
    add_bed(studio)
    studio.selection.set(["t1"])
    choice = (
        driver.tool_panel(window, TracePanel).type_box
        if box == "trace"
        else window.properties.fields[box]
    )
    assert isinstance(choice, ComboBox)
    before = choice.currentIndex(), studio.records["t1"]
    at = QPointF(choice.rect().center())
    wheel = QWheelEvent(
        at,
        choice.mapToGlobal(at),
        QPoint(0, -120),
        QPoint(0, -120),
        Qt.MouseButton.NoButton,
        Qt.KeyboardModifier.NoModifier,
        Qt.ScrollPhase.NoScrollPhase,
        False,
    )
    QApplication.sendEvent(choice, wheel)
    assert (choice.currentIndex(), studio.records["t1"]) == before


def shown_buttons(bar) -> list[str]:
    QApplication.processEvents()
    return [b.text() for b in bar.findChildren(QPushButton) if b.isVisible()]


def test_restore_offer_does_not_replace_a_warning(window, studio, tmp_path):
    folder = tmp_path / "other.vom"
    ProjectFolder.create(folder).close()
    studio.warn(WARNING)
    studio.recovery_found.emit([folder])
    bar = window.message_bar
    assert bar.text == WARNING
    assert shown_buttons(bar) == ["Restore unsaved work"]
    bar.clear()
    studio.hint(HINT)
    studio.recovery_found.emit([folder])
    assert bar.notice.level == "warning"
    assert shown_buttons(bar) == ["Restore"]
