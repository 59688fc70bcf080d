"""Delete acts on what has the focus: rows in tree and table, letters in an editor."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.core.findings import Finding
from vomstudio.project.kinds.trace import Trace


@pytest.mark.parametrize("where", first_in_default_tier(["tree", "table"], 1))
def test_delete_removes_the_selected_planes_and_can_be_undone(window, studio, where):
    add_cliff(studio)
    for i in range(3):
        add_bed(studio, f"t{i}", f"B{i}")
    studio.selection.set(["t0", "t2"])
    view = window.tree.tree if where == "tree" else window.table.view
    window.docks.bring_forward("project" if where == "tree" else "table")
    view.setFocus()
    QTest.keyClick(view, Qt.Key.Key_Delete)
    assert [t.id for t in studio.session.of(Trace)] == ["t1"]
    studio.undo()
    assert len(studio.session.of(Trace)) == 3


def test_delete_in_the_filter_deletes_letters_only(window, studio):
    add_cliff(studio)
    add_bed(studio)
    studio.selection.set(["t1"])
    window.docks.bring_forward("table")
    window.table._filter.setFocus()
    window.table._filter.setText("")
    QTest.keyClicks(window.table._filter, "xb")
    window.table._filter.setCursorPosition(0)
    QTest.keyClick(window.table._filter, Qt.Key.Key_Delete)
    assert window.table._filter.text() == "b"
    assert studio.session.of(Trace)


@pytest.mark.parametrize("where", first_in_default_tier(["tree", "table"]))
def test_delete_in_a_filtered_list_keeps_hidden_features(window, studio, where):
    add_cliff(studio)
    for i in range(4):
        add_bed(studio, f"t{i}", f"B{i}" if i < 3 else "X3")
    panel = window.tree if where == "tree" else window.table
    line = window.tree.filter if where == "tree" else window.table._filter
    view = window.tree.tree if where == "tree" else window.table.view
    # Select all means all of the project.
    window.actions_table.run("select_all")
    window.docks.bring_forward("project" if where == "tree" else "table")
    line.setText("X3")
    view.setFocus()
    QTest.keyClick(view, Qt.Key.Key_Delete)
    assert sorted(t.id for t in studio.session.of(Trace)) == ["t0", "t1", "t2"]
    assert studio.notices[-1].message == Finding("delete.hidden-left", count=3)
    # All of what is selected is hidden now.
    line.setText("X")
    view.setFocus()
    window.actions_table.run("delete")
    assert len(studio.session.of(Trace)) == 3
    line.setText("")
    view.setFocus()
    QTest.keyClick(view, Qt.Key.Key_Delete)
    assert not studio.session.of(Trace)
    assert panel.isVisible()


def test_delete_outside_lists_removes_all_selected_and_reports_hidden_ones(window, studio):
    add_cliff(studio)
    for i in range(3):
        add_bed(studio, f"t{i}", f"B{i}")
    window.table._filter.setText("B1")
    window.actions_table.run("select_all")
    window.setFocus()
    window.actions_table.run("delete")
    assert not studio.session.of(Trace)
    assert studio.notices[-1].message == Finding("delete.hidden-deleted", count=2)
    studio.undo()
    assert len(studio.session.of(Trace)) == 3
