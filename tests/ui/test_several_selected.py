"""Several features selected: they say so, and fields show what they share."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLabel

from tests.messages import shown_values
from tests.ui.conftest import add_bed, add_cliff

SEVERAL = "(several)"


@pytest.fixture
def beds(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1", "B01", set_name="upper", notes="wet")
    add_bed(studio, "t2", "B02", set_name="upper", notes="dry", overturned=True)
    add_bed(studio, "t3", "F01", set_name="upper", type_id="fault")
    return window.properties.fields


def said(window) -> str:
    label = window.findChild(QLabel, "several_selected")
    return "" if label.isHidden() else label.text()


@pytest.mark.full
def test_panel_states_the_selection_count_and_the_feature_shown(window, studio, beds):
    studio.selection.set(["t1"])
    assert said(window) == ""
    studio.selection.set(["t1", "t3", "t2"])
    values = shown_values(said(window), "features.several-selected")
    assert values == {"n": "3", "name": "B02"}
    studio.selection.set(["t3"])
    assert said(window) == ""


def test_fields_show_common_values_and_mark_differing_ones(window, studio, beds):
    studio.selection.set(["t1", "t2", "t3"])
    assert beds["set_name"].text() == "upper"
    assert (beds["notes"].text(), beds["notes"].placeholderText()) == ("", SEVERAL)
    assert (beds["type_id"].currentIndex(), beds["type_id"].placeholderText()) == (-1, SEVERAL)
    assert beds["overturned"].checkState() == Qt.CheckState.PartiallyChecked
    assert (beds["name"].text(), beds["name"].isEnabled()) == ("", False)
    studio.selection.set(["t1", "t2"])
    assert beds["type_id"].currentData() == "bedding"
    studio.selection.set(["t1"])
    assert beds["notes"].text() == "wet"
    assert beds["notes"].placeholderText() == ""
    assert beds["overturned"].checkState() == Qt.CheckState.Unchecked
    assert beds["name"].isEnabled()


def test_change_applies_to_all_selected_in_one_undo_step(window, studio, beds):
    studio.selection.set(["t1", "t2", "t3"])
    beds["notes"].setFocus()
    QTest.keyClicks(beds["notes"], "checked")
    QTest.keyClick(beds["notes"], Qt.Key.Key_Return, Qt.KeyboardModifier.ControlModifier)
    assert {studio.records[i].notes for i in ("t1", "t2", "t3")} == {"checked"}
    assert beds["notes"].text() == "checked"
    box = beds["type_id"]
    box.setCurrentIndex(box.findData("joint"))
    box.activated.emit(box.currentIndex())
    assert {studio.records[i].type_id for i in ("t1", "t2", "t3")} == {"joint"}
    studio.undo()
    assert [studio.records[i].type_id for i in ("t1", "t2", "t3")] == [
        "bedding",
        "bedding",
        "fault",
    ]
    assert box.currentIndex() == -1
    studio.undo()
    assert [studio.records[i].notes for i in ("t1", "t2", "t3")] == ["wet", "dry", ""]


@pytest.mark.full
def test_leaving_a_mixed_field_changes_nothing(window, studio, beds):
    studio.selection.set(["t1", "t2"])
    label = studio.undo_label
    beds["notes"].setFocus()
    QTest.keyClick(beds["notes"], Qt.Key.Key_Return)
    studio.selection.set(["t3"])
    assert studio.undo_label == label
    assert [studio.records[i].notes for i in ("t1", "t2")] == ["wet", "dry"]


@pytest.mark.full
def test_click_on_a_mixed_flag_sets_it_for_all(window, studio, beds):
    studio.selection.set(["t1", "t2"])
    beds["overturned"].click()
    assert all(studio.records[i].overturned for i in ("t1", "t2"))
    beds["overturned"].click()
    assert not any(studio.records[i].overturned for i in ("t1", "t2"))
