"""An edit of many features: one change per view, and no work for what is out of sight."""

from __future__ import annotations

from dataclasses import replace

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication

from tests.samples import bed
from tests.ui.conftest import add_cliff
from vomstudio.project import edits
from vomstudio.project.edit import change
from vomstudio.ui.panels.features.project_tree import ProjectTree
from vomstudio.ui.panels.features.tree_view import NAME, ORIENTATION, SET

COUNT = 120


@pytest.fixture
def ids(window, studio) -> list[str]:
    add_cliff(studio)
    made = {f"t{i}": replace(bed(f"t{i}", shift=0.01 * i), name=f"B{i:03d}") for i in range(COUNT)}
    assert studio.attempt(lambda records: change(records, "Add beds", made))
    QApplication.processEvents()
    return list(made)


def selected_rows(table) -> list[str]:
    rows = table.view.selectionModel().selectedRows()
    return [table.model.id_at(table._sorted.mapToSource(row).row()) for row in rows]


def test_the_table_reports_one_range_and_keeps_selection_and_order(window, studio, ids):
    table = window.table
    studio.selection.set(ids[::2])
    changes: list[tuple[int, int]] = []
    resets: list[int] = []
    table.model.dataChanged.connect(lambda a, b: changes.append((a.row(), b.row())))
    table._sorted.modelReset.connect(lambda: resets.append(1))
    studio.attempt(edits.set_attributes, ids[::2], set_name="J1")
    assert changes == [(0, COUNT - 2)]
    assert not resets
    assert sorted(selected_rows(table)) == sorted(ids[::2])
    assert [table.model.row(i).set_name for i in range(4)] == ["J1", "", "J1", ""]
    assert studio.selection.ids == tuple(ids[::2])


@pytest.mark.full
def test_a_new_order_of_many_rows_keeps_the_selection(window, studio, ids, monkeypatch):
    from vomstudio.ui.panels.features import sorted_rows

    monkeypatch.setattr(sorted_rows, "MAX_SINGLE_UPDATES", 20)
    studio.selection.set(ids[:30])
    window.table.view.sortByColumn(0, Qt.SortOrder.DescendingOrder)
    assert selected_rows(window.table)
    assert set(selected_rows(window.table)) == set(ids[:30])
    assert studio.selection.ids == tuple(ids[:30])


@pytest.mark.full
def test_the_tree_computes_only_the_rows_in_sight(window, studio, ids, monkeypatch):
    window.resize(1000, 500)
    QApplication.processEvents()
    rows: set[str] = set()
    compute = ProjectTree._row_of
    monkeypatch.setattr(ProjectTree, "_row_of", lambda self, f: rows.add(f.id) or compute(self, f))
    tree = window.tree
    studio.selection.set(ids[::2])
    studio.attempt(edits.set_attributes, ids[::2], set_name="J1", notes="wet")
    QApplication.processEvents()
    assert len(rows) < COUNT / 2
    items = [tree._items[id_] for id_ in ids]
    assert [item.text(SET) for item in items] == ["J1", ""] * (COUNT // 2)
    assert all(item.text(ORIENTATION) for item in items)
    assert "wet" in items[0].toolTip(NAME)
    assert [item.isSelected() for item in items] == [True, False] * (COUNT // 2)
    studio.undo()
    assert not any(item.text(SET) for item in items)


def test_an_eye_in_the_tree_follows_the_studio(window, studio, ids):
    studio.set_visible(ids[::2], False)
    states = [window.tree._items[id_].checkState(NAME) for id_ in ids[:2]]
    assert states == [Qt.CheckState.Unchecked, Qt.CheckState.Checked]
    window.tree._items[ids[0]].setCheckState(NAME, Qt.CheckState.Checked)
    assert studio.visible(ids[0])


def test_planes_of_the_fold_are_selected_once_per_revision(studio, ids):
    fold = studio.fold
    planes = fold.planes()
    assert len(planes) == COUNT
    assert fold.planes() is planes
    studio.attempt(edits.delete, ids[:1])
    assert len(fold.planes()) == COUNT - 1
    fold.choose(fold.fold_filter, is_selected=True)
    studio.selection.set(ids[1:4])
    assert [f.id for f in fold.planes().features] == ids[1:4]
    studio.selection.set(ids[4:6])
    assert [f.id for f in fold.planes().features] == ids[4:6]
    assert [f.id for f in fold.features()] == ids[4:6]
