"""Whatever is typed into whichever field: no error reaches the user, no question is asked, and no
measurement changes."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import shiboken6
from PySide6.QtCore import QAbstractItemModel, QAbstractListModel, QModelIndex, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractItemView,
    QAbstractSpinBox,
    QApplication,
    QDialog,
    QLineEdit,
    QPlainTextEdit,
    QWidget,
)

from tests import driver
from vomstudio.project import edits
from vomstudio.project.kinds.control_point import ControlPoint
from vomstudio.project.kinds.trace import Trace
from vomstudio.studio.tools.registry import TOOLS
from vomstudio.ui.base.controls import FoldButton
from vomstudio.ui.shell.layout import REGIONS
from vomstudio.ui.widgets.more_section import MoreSection

pytestmark = pytest.mark.full

TYPED = ("qwertz $%&/()=?", "-1e999", "nan", "1,5", "1.5", "30 cm", "")
PASTED = ("400/95 ± ∞", "first line\nsecond line", "9" * 5000)
DIALOGS = (
    "verdict_profile",
    "orthophoto",
    "feature_types",
    "figure_style",
    "plan_survey",
    "fit_model",
    "extend_plane",
)
ROWS = 2
"""Rows of a table whose cells are edited."""


@pytest.fixture
def interpreted(window, outcrop, picks):
    """The outcrop with its traces as beds and two control points."""
    window.resize(1600, 1000)
    model_id = driver.open_outcrop(window, outcrop)
    model = window.studio.records[model_id]
    for name, points in picks.items():
        vertices = tuple(tuple(p) for p in points.tolist())
        trace = Trace(name, name, "bedding", model_id, model.content_hash, vertices)
        assert window.studio.attempt(edits.add_trace, trace)
    for number in (1, 2):
        point = ControlPoint(f"c{number}", f"C{number}", model_id, model.content_hash)
        assert window.studio.attempt(edits.add_features, [point])
    window.studio.selection.set(["B04"])
    return window


def unfold(page: QWidget) -> None:
    for section in page.findChildren(MoreSection):
        section.set_open(True)
    for button in page.findChildren(FoldButton):
        if button.isEnabled() and not button.isChecked():
            button.click()
    driver.pause(20)


def fields(page: QWidget) -> Iterator[QLineEdit | QPlainTextEdit]:
    """Yield what can be typed in; what was typed before may have removed a field."""
    for kind in (QLineEdit, QPlainTextEdit):
        for field in page.findChildren(kind):
            if shiboken6.isValid(field) and can_be_typed_in(field):
                yield field


def can_be_typed_in(field: QLineEdit | QPlainTextEdit) -> bool:
    return field.isVisible() and field.isEnabled() and not field.isReadOnly()


def enter(field: QLineEdit | QPlainTextEdit, text: str, end: Qt.Key) -> None:
    """Replace the text of a field as a user does, and leave it."""
    field.setFocus()
    field.selectAll()
    QTest.keyClick(field, Qt.Key.Key_Delete)
    if text in PASTED:
        QApplication.clipboard().setText(text)
        field.paste()
    else:
        QTest.keyClicks(field, text)
    QTest.keyClick(field, end)
    driver.pause(2)


def column_count(model: QAbstractItemModel, parent: QModelIndex) -> int:
    """The columns; of a list model, which hides the method, its one."""
    return 1 if isinstance(model, QAbstractListModel) else model.columnCount(parent)


def assert_quiet(window, field: QWidget, place: tuple[str, ...]) -> None:
    modal = QApplication.activeModalWidget()
    assert modal in (None, field.window()), (place, modal.windowTitle())
    assert window.isEnabled()
    owner = field.parent() if shiboken6.isValid(field) else None
    if isinstance(owner, QAbstractSpinBox):
        assert owner.hasAcceptableInput(), place


def type_in_fields(window, page: QWidget, name: str, end: Qt.Key = Qt.Key.Key_Return) -> int:
    """Type every text into every field; the number of fields."""
    unfold(page)
    count = 0
    for field in fields(page):
        count += 1
        title = field.objectName() or type(field.parent()).__name__
        for text in (*TYPED, *PASTED):
            if not shiboken6.isValid(field) or not can_be_typed_in(field):
                break
            enter(field, text, end)
            assert_quiet(window, field, (name, title, text[:20]))
    return count


def editable_cells(page: QWidget) -> Iterator[tuple[QAbstractItemView, QModelIndex]]:
    views = page.findChildren(QAbstractItemView)
    views += [page] if isinstance(page, QAbstractItemView) else []
    for view in views:
        model = view.model()
        if not view.isVisible() or model is None or isinstance(view.parent(), QLineEdit):
            continue
        # The rows of a tree are below its groups.
        for parent in (QModelIndex(), *(model.index(row, 0) for row in range(model.rowCount()))):
            for row in range(min(ROWS, model.rowCount(parent))):
                for column in range(column_count(model, parent)):
                    index = model.index(row, column, parent)
                    if model.flags(index) & Qt.ItemFlag.ItemIsEditable:
                        yield view, index


def type_in_cells(window, page: QWidget, name: str) -> int:
    """Type every text into the cells of all tables; the number of cells."""
    count = 0
    for view, cell in list(editable_cells(page)):
        row, column, parent = cell.row(), cell.column(), cell.parent()
        for text in (*TYPED, *PASTED):
            if not shiboken6.isValid(view):
                break
            index = view.model().index(row, column, parent)
            before = set(view.findChildren(QLineEdit))
            view.setCurrentIndex(index)
            if not index.isValid() or not view.edit(index, view.EditTrigger.AllEditTriggers, None):
                break
            editors = [e for e in view.findChildren(QLineEdit) if e not in before]
            if not editors:
                break
            enter(editors[0], text, Qt.Key.Key_Return)
            assert_quiet(window, view, (name, f"cell {row}, {column}", text[:20]))
        count += 1
    return count


def vertices(window) -> dict[str, object]:
    """What was measured, without names, sets and notes, which may be any text."""
    return {trace.id: trace.vertices for trace in driver.traces(window)}


def names(window) -> list[str]:
    return [feature.name for feature in window.studio.session.features()]


def undo_all(window, label: str | None) -> None:
    """Undo every step that was made while typing."""
    studio = window.studio
    for _ in range(1000):
        if studio.undo_label == label:
            return
        before = studio.undo_label
        studio.undo()
        assert studio.undo_label != before or studio.session.dirty
    raise AssertionError(f"cannot undo: {studio.undo_label}")


def check(window, before: dict[str, object], records: dict[str, object], label) -> None:
    assert vertices(window) == before
    assert all("\n" not in name for name in names(window))
    undo_all(window, label)
    assert dict(window.studio.records) == records


# The key that ends an edit deletes its editor, for which Qt then receives a second commit.
@pytest.mark.qt_log_ignore("commitData called with an editor", extend=True)
def test_every_page_rejects_nonsense_input_without_changes(interpreted) -> None:
    window, studio = interpreted, interpreted.studio
    before, records, label = vertices(window), dict(studio.records), studio.undo_label
    count = cells = 0
    for name in REGIONS.keys() - {"second_view", "stereonet"}:
        window.docks.bring_forward(name)
        driver.pause(100)
        page = driver.page(window, name)
        count += type_in_fields(window, page, name)
        cells += type_in_cells(window, page, name)
        studio.selection.set(["B04"])
    assert count > 20
    assert cells > 10
    check(window, before, records, label)


def test_every_tool_panel_rejects_nonsense_input_without_changes(interpreted) -> None:
    window, studio = interpreted, interpreted.studio
    before, records, label = vertices(window), dict(studio.records), studio.undo_label
    count = cells = 0
    for entry in TOOLS:
        window.actions_table.run(entry.name)
        driver.pause(50)
        page = window.tool_panel.currentWidget()
        count += type_in_fields(window, page, entry.name)
        cells += type_in_cells(window, page, entry.name)
        studio.cancel_tool()
    window.actions_table.run("navigate")
    assert count > 10
    assert cells > 2
    check(window, before, records, label)


def test_dialogs_reject_nonsense_input_without_changes(interpreted) -> None:
    window, studio = interpreted, interpreted.studio
    before, records, label = vertices(window), dict(studio.records), studio.undo_label
    count = 0
    for action in DIALOGS:
        window.actions_table.run(action)
        driver.wait(lambda: dialogs(window), action)
        (dialog,) = dialogs(window)
        # Without a window manager nobody else gives it the keyboard.
        dialog.activateWindow()
        driver.wait(lambda d=dialog: QApplication.activeWindow() is d, "the active dialog")
        driver.pause(100)
        # Enter would use the default button, which may be the one that is wanted.
        count += type_in_fields(window, dialog, action, Qt.Key.Key_Tab)
        count += type_in_cells(window, dialog, action)
        dialog.reject()
        driver.pause(10)
        driver.focus(window)
    assert count > 20
    check(window, before, records, label)


def dialogs(window) -> list[QDialog]:
    return [d for d in window.findChildren(QDialog) if d.isVisible()]
