"""Thousands of features come into the tree between the events of the window."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QObject
from PySide6.QtWidgets import QApplication

from tests.ui.conftest import save_beds
from vomstudio.project import edits
from vomstudio.ui.base.qt_owner import IncrementalWork
from vomstudio.ui.panels.features import project_tree

COUNT = 12


@pytest.fixture
def stored(studio, tmp_path, monkeypatch):
    """A saved project with more features than come at once; another one is open."""
    monkeypatch.setattr(project_tree, "_PORTION", 5)
    return save_beds(studio, tmp_path / "many.vom", COUNT)


def rows_of(tree) -> list[str]:
    group = tree._items["bedding"]
    return [group.child(i).text(0) for i in range(group.childCount())]


def names(studio) -> list[str]:
    return [f.name for f in studio.session.features()]


@pytest.mark.full
def test_tree_rows_are_added_in_portions(window, studio, stored):
    window.open_path(stored)
    # Not in the moment in which every panel begins with the project.
    assert rows_of(window.tree) == []
    seen = set()
    for _ in range(1000):
        QApplication.processEvents()
        seen.add(len(rows_of(window.tree)))
    assert seen >= {5, 10, COUNT}
    assert window.table.model.rowCount() == COUNT
    # In the order of their numbers, as names of one feature after the other are.
    assert rows_of(window.tree) == names(studio)
    assert f"({COUNT})" in window.tree._items["bedding"].text(0)


@pytest.mark.full
def test_edit_during_loading_completes_the_tree_first(window, studio, stored):
    window.open_path(stored)
    first, *_, last = studio.session.features()
    studio.attempt(edits.set_attributes, [last.id], name="A1")
    assert rows_of(window.tree) == ["A1", *names(studio)[:-1]]
    studio.selection.set([first.id])
    studio.workspace.delete_selected()
    assert first.name not in rows_of(window.tree)


@pytest.mark.full
def test_filter_selection_and_visibility_apply_to_rows_added_later(window, studio, stored, qtbot):
    window.open_path(stored)
    features = studio.session.features()
    window.tree.filter.setText(features[-1].name)
    studio.selection.set([features[-1].id])
    studio.set_visible([features[-1].id], False)
    qtbot.waitUntil(lambda: len(rows_of(window.tree)) == COUNT)
    items = [window.tree._items[f.id] for f in features]
    assert [item.isHidden() for item in items] == [True] * (COUNT - 1) + [False]
    assert items[-1].isSelected()
    assert items[-1].checkState(0).value == 0


def test_pending_rows_are_not_added_to_the_next_project(window, studio, stored):
    window.open_path(stored)
    studio.workspace.projects.new()
    for _ in range(20):
        QApplication.processEvents()
    assert rows_of(window.tree) == []


def test_portions_run_once_each_in_order(qtbot):
    parent, done = QObject(), []
    portions = IncrementalWork(parent)

    def work(name: str, count: int):
        for i in range(count):
            done.append(f"{name}{i}")
            yield

    portions.start(work("a", 3))
    assert done == ["a0"]
    portions.start(work("b", 3))
    assert done == ["a0", "b0"]
    qtbot.waitUntil(lambda: not portions.is_running)
    assert done == ["a0", "b0", "b1", "b2"]
    portions.start(work("c", 3))
    portions.finish()
    portions.finish()
    assert done[4:] == ["c0", "c1", "c2"]
    portions.start(work("d", 3))
    portions.cancel()
    assert not portions.is_running
    QApplication.processEvents()
    assert done[7:] == ["d0"]


def test_a_failure_is_raised_once():
    parent, tried = QObject(), []
    failure = ValueError("no more")

    def work():
        yield
        tried.append(1)
        raise failure

    portions = IncrementalWork(parent)
    portions.start(work())
    with pytest.raises(ValueError) as raised:  # noqa: PT011 - compared below
        portions.finish()
    assert raised.value is failure
    portions.finish()
    assert tried == [1]
    assert not portions.is_running
