"""An edit of many features: one change per view, and no work for what is out of sight."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication

from tests import driver
from tests.samples import bed
from tests.ui.conftest import add_cliff
from vomstudio.project import edits
from vomstudio.project.edit import change
from vomstudio.ui.base.actions import Actions
from vomstudio.ui.panels.features import table_panel
from vomstudio.ui.panels.features.project_tree import ProjectTree
from vomstudio.ui.panels.features.sorted_rows import SortedRows
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
    return [table.model.id_at(table._sorted_rows.mapToSource(row).row()) for row in rows]


def test_the_table_keeps_selection_and_order(window, studio, ids):
    table = window.table
    studio.selection.set(ids[::2])
    resets: list[int] = []
    table._sorted_rows.modelReset.connect(lambda: resets.append(1))
    studio.attempt(edits.set_attributes, ids[::2], set_name="J1")
    assert not resets
    assert sorted(selected_rows(table)) == sorted(ids[::2])
    assert [table.model.row(i).set_name for i in range(4)] == ["J1", "", "J1", ""]
    assert studio.selection.ids == tuple(ids[::2])


def recorded_rows(window, monkeypatch) -> tuple[list[int], list[tuple[int, int]]]:
    """Rows that the table evaluates from now on, and the ranges that it reports as changed."""
    evaluated: list[int] = []
    evaluate = SortedRows._key
    monkeypatch.setattr(
        SortedRows, "_key", lambda self, row: evaluated.append(row) or evaluate(self, row)
    )
    ranges: list[tuple[int, int]] = []
    window.table._sorted_rows.dataChanged.connect(lambda a, b: ranges.append((a.row(), b.row())))
    return evaluated, ranges


@pytest.mark.parametrize("rows", [[7], [3, 4, 5, 90, 91], list(range(40, 70)), [1, 60, 119]])
def test_table_reports_exactly_the_edited_row_ranges(window, studio, ids, rows, monkeypatch):
    evaluated, ranges = recorded_rows(window, monkeypatch)
    studio.attempt(edits.set_attributes, [ids[row] for row in rows], set_name="J1")
    assert sorted(evaluated) == rows
    assert [row for first, last in ranges for row in range(first, last + 1)] == rows
    assert len(ranges) == 1 + sum(b > a + 1 for a, b in pairwise(rows))


def test_scattered_rows_are_evaluated_once_each_and_reported_as_one_range(
    window, studio, ids, monkeypatch
):
    evaluated, ranges = recorded_rows(window, monkeypatch)
    studio.attempt(edits.set_attributes, ids[::2], set_name="J1")
    assert sorted(evaluated) == list(range(0, COUNT, 2))
    assert ranges == [(0, COUNT - 2)]


@pytest.mark.parametrize("step", [1, 2, 7])
def test_selection_has_the_minimum_number_of_full_row_ranges(window, studio, ids, step):
    studio.selection.set(ids[1:3])
    studio.selection.set(ids[::step])
    table, tree = window.table, window.tree.tree
    assert set(selected_rows(table)) == set(ids[::step])
    assert {item.id for item in tree.selectedItems()} == set(ids[::step])
    for view, columns in ((table.view, table.model.columnCount()), (tree, tree.columnCount())):
        ranges = view.selectionModel().selection()
        assert len(ranges) == (1 if step == 1 else len(ids[::step]))
        assert all(part.width() == columns for part in ranges)


def test_many_changed_rows_are_updated_between_events(window, studio, ids, monkeypatch):
    monkeypatch.setattr(table_panel, "MAX_IMMEDIATE_FEATURES", 20)
    monkeypatch.setattr(table_panel, "STEP_FEATURES", 30)
    model = window.table.model
    studio.attempt(edits.set_attributes, ids[:100], set_name="J1")
    assert not any(model.row(i).set_name for i in range(COUNT))
    # A later edit is not overtaken.
    studio.attempt(edits.set_attributes, ids[:1], set_name="J2")
    assert [model.row(i).set_name for i in (0, 1, 99, 100)] == ["J2", "J1", "J1", ""]
    studio.attempt(edits.set_attributes, ids[:100], set_name="")
    driver.wait(lambda: not any(model.row(i).set_name for i in range(COUNT)), "the rows")
    studio.attempt(edits.delete, ids[:60])
    assert model.rowCount() == window.table._sorted_rows.rowCount() == COUNT - 60
    studio.undo()
    driver.wait(lambda: model.rowCount() == COUNT, "the rows")


def test_filtered_tree_items_stay_hidden_after_a_bulk_delete(window, studio, ids):
    window.tree.filter.setText("B11")
    assert window.tree._hidden_ids == set(ids[:110])
    studio.attempt(edits.delete, ids[50:105])
    items = window.tree._items
    assert {id_ for id_ in ids if id_ in items} == {*ids[:50], *ids[105:]}
    assert {id_ for id_ in ids if id_ in items and items[id_].isHidden()} == {
        *ids[:50],
        *ids[105:110],
    }
    assert [items[id_].parent().indexOfChild(items[id_]) for id_ in (*ids[:2], ids[105])] == [
        0,
        1,
        50,
    ]


def test_name_column_width_follows_the_longest_name(window, studio, ids):
    tree = window.tree.tree
    widths = [tree._name_width()]
    long_name = "B" * 40
    for edit, names in (
        (edits.set_attributes, {"name": long_name}),
        (edits.set_attributes, {"name": "B5"}),
        (edits.set_attributes, {"name": long_name}),
        (edits.delete, {}),
    ):
        assert studio.attempt(edit, ids[5:6], **names)
        widths.append(tree._name_width())
    assert widths[0] == widths[2] == widths[4]
    assert widths[1] == widths[3] > widths[0]


def test_moving_camera_refreshes_only_view_commands(window, monkeypatch):
    table = window.actions_table
    asked: list[str] = []
    disabled_reason = Actions.disabled_reason
    monkeypatch.setattr(
        Actions,
        "disabled_reason",
        lambda self, name: asked.append(name) or disabled_reason(self, name),
    )
    table.refresh_camera()
    assert set(asked) == {"view_back", "view_forward", "orthographic"}


@pytest.mark.full
def test_sorting_many_rows_keeps_the_selection(window, studio, ids, monkeypatch):
    from vomstudio.ui.panels.features import sorted_rows

    monkeypatch.setattr(sorted_rows, "MAX_SINGLE_UPDATES", 20)
    studio.selection.set(ids[:30])
    window.table.view.sortByColumn(0, Qt.SortOrder.DescendingOrder)
    assert selected_rows(window.table)
    assert set(selected_rows(window.table)) == set(ids[:30])
    assert studio.selection.ids == tuple(ids[:30])


@pytest.mark.full
def test_tree_computes_only_visible_rows(window, studio, ids, monkeypatch):
    window.resize(1000, 500)
    QApplication.processEvents()
    rows: set[str] = set()
    compute = ProjectTree._cached_row
    monkeypatch.setattr(
        ProjectTree, "_cached_row", lambda self, f: rows.add(f.id) or compute(self, f)
    )
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


def test_tree_visibility_boxes_follow_the_studio(window, studio, ids):
    studio.set_visible(ids[::2], False)
    states = [window.tree._items[id_].checkState(NAME) for id_ in ids[:2]]
    assert states == [Qt.CheckState.Unchecked, Qt.CheckState.Checked]
    window.tree._items[ids[0]].setCheckState(NAME, Qt.CheckState.Checked)
    assert studio.visible(ids[0])


def test_fold_planes_are_cached_until_an_edit(studio, ids):
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
