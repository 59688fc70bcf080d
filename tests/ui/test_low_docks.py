"""On a small screen docks are low: what does not fit is scrolled to, and nothing lies over anything
else."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import pytest
from PySide6.QtCore import QEvent, QObject
from PySide6.QtWidgets import QApplication, QBoxLayout, QLabel, QTableWidget, QWidget

from tests import driver
from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.ui.base.controls import CompactTable
from vomstudio.ui.shell.layout import INSPECTOR_TABS, WORKSPACES

pytestmark = pytest.mark.full


def wrong(top: QWidget) -> Iterator[str]:
    """Rows of columns that overlap, and words of several lines that have too little height."""
    for widget in (top, *top.findChildren(QWidget)):
        column = widget.layout()
        if not isinstance(column, QBoxLayout) or not widget.isVisibleTo(top):
            continue
        if column.direction() != QBoxLayout.Direction.TopToBottom:
            continue
        rows = [column.itemAt(i).widget() for i in range(column.count())]
        shown = [row for row in rows if row is not None and row.isVisibleTo(widget)]
        for above, below in pairwise(shown):
            if above.geometry().bottom() >= below.geometry().top():
                yield f"{above.objectName() or above} lies over {below.objectName() or below}"
    for label in top.findChildren(QLabel):
        if label.isVisibleTo(top) and label.wordWrap() and label.text():
            least = label.heightForWidth(label.width())
            if label.height() < least:
                yield f"{label.height()} of {least}: {label.text()[:60]}"


@pytest.mark.parametrize("height", first_in_default_tier([720, 520], 1))
def test_widgets_in_low_docks_do_not_overlap(window, studio, height) -> None:
    add_cliff(studio)
    for number in range(4):
        add_bed(studio, f"b{number}", dip=0.1 * number)
    studio.selection.set(["b1"])
    window.resize(1280, height)
    found = {}
    for workspace in WORKSPACES:
        window.workspaces.switch(workspace.name)
        for name in (*INSPECTOR_TABS, *workspace.inspector, *workspace.drawer):
            window.docks.bring_forward(name)
            QApplication.processEvents()
            driver.pause(30)
            if list(wrong(window.docks[name])):
                # On a busy machine the layout comes to rest later.
                driver.pause(500)
            if said := list(wrong(window.docks[name])):
                found[f"{workspace.name} {name}"] = said
    assert found == {}


class Painted(QObject):
    """Keeps which words were drawn in less height than they need."""

    def __init__(self, top: QWidget) -> None:
        super().__init__(top)
        self.cut: list[str] = []
        self.count = 0
        for label in top.findChildren(QLabel):
            label.installEventFilter(self)

    def eventFilter(self, label: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() == QEvent.Type.Paint and isinstance(label, QLabel) and label.text():
            self.count += 1
            wraps = label.hasHeightForWidth()
            least = label.heightForWidth(label.width()) if wraps else label.sizeHint().height()
            if label.height() < least:
                self.cut.append(f"{label.height()} of {least}: {label.text()[:60]}")
        return False


def test_no_truncated_text_is_painted_when_the_selection_changes(window, studio) -> None:
    add_cliff(studio)
    few = ((0.0, 0.0, 0.0), (3.0, 0.01, 0.0), (6.0, 0.0, 0.01))
    add_bed(studio, "b1", vertices=few)
    many = (*few[:2], (6.0, 0.0, 0.4), (5.0, 1.0, 2.0), (4.0, 3.0, 1.0))
    add_bed(studio, "b2", vertices=many)
    window.resize(1280, 720)
    studio.selection.set(["b1"])
    window.docks.bring_forward("properties")
    driver.pause(100)
    painted = Painted(window.docks["properties"])
    for name in ("b2", "b1") * 4:
        studio.selection.set([name])
        driver.pause(40)
    assert painted.count > 40
    assert painted.cut == []


def test_compact_table_hints_its_minimum_height(qtbot) -> None:
    low, usual = CompactTable(0, 3), QTableWidget(0, 3)
    for table in (low, usual):
        qtbot.addWidget(table)
        table.setMinimumHeight(90)
    assert low.sizeHint().height() == 90 < usual.sizeHint().height()
