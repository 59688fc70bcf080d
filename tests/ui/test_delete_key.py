"""Delete acts on what has the focus: rows in tree and table, letters in an editor."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from tests.ui.conftest import add_bed, add_cliff
from vomstudio.document.kinds.trace import Trace


@pytest.mark.parametrize("where", ["tree", "table"])
def test_delete_removes_the_selected_planes_and_can_be_undone(window, studio, where):
    add_cliff(studio)
    for i in range(3):
        add_bed(studio, f"t{i}", f"B{i}")
    studio.selection.set(["t0", "t2"])
    view = window.tree.tree if where == "tree" else window.table.view
    view.setFocus()
    QTest.keyClick(view, Qt.Key.Key_Delete)
    assert [t.id for t in studio.session.of(Trace)] == ["t1"]
    studio.undo()
    assert len(studio.session.of(Trace)) == 3


def test_delete_in_the_filter_deletes_letters_only(window, studio):
    add_cliff(studio)
    add_bed(studio)
    studio.selection.set(["t1"])
    window.table._filter.setFocus()
    window.table._filter.setText("")
    QTest.keyClicks(window.table._filter, "xb")
    window.table._filter.setCursorPosition(0)
    QTest.keyClick(window.table._filter, Qt.Key.Key_Delete)
    assert window.table._filter.text() == "b"
    assert studio.session.of(Trace)
