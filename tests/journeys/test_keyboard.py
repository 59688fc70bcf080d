"""The keyboard goes where the eye is: real keys and a real mouse, in the window that people use."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QEnterEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QLineEdit,
    QPushButton,
    QWidget,
)

from tests import driver
from tests.driver import click, key, look_at, wait
from vomstudio.project.kinds.control_point import ControlPoint
from vomstudio.studio.tools.line import LineTool
from vomstudio.studio.tools.trace import TraceTool
from vomstudio.ui.panels.tools.control import ControlPanel
from vomstudio.ui.panels.tools.line import LinePanel
from vomstudio.ui.panels.tools.plane import PlanePanel
from vomstudio.ui.panels.tools.trace import TracePanel
from vomstudio.ui.widgets.more_section import MoreSection
from vomstudio.ui.widgets.vertex_table import VertexTable


@pytest.fixture
def opened(window, outcrop, picks):
    """The outcrop, looked at, with the keyboard where opening it has put it."""
    # Not where the fixture put it: on what Qt would choose.
    window.docks.bring_forward("table")
    window.table._filter.setFocus()
    window.open_path(outcrop)
    driver.wait(lambda: driver.dialog_of(window) is not None, "the frame dialog")
    dialog = driver.dialog_of(window)
    dialog._crs_button.click()
    dialog._crs.setFocus()
    QTest.keyClicks(dialog._crs, driver.CRS)
    QTest.keyClick(dialog._crs, Qt.Key.Key_Return)
    wait(lambda: driver.dialog_of(window) is None, "the end of the dialog")
    window.activateWindow()
    wait(window.isActiveWindow, "the window")
    driver.settled(window)
    look_at(window, picks["B01"], 0.0, 10.0)
    return window


def press(widget: QWidget) -> None:
    """As a person goes to a field: with the mouse."""
    QTest.mouseClick(widget, driver.LEFT, driver.NONE, QPoint(12, widget.height() // 2))
    wait(widget.hasFocus, f"the focus of {widget.objectName() or widget}", 5.0)


def one_plane(window) -> None:
    """A bed across the middle of the view, so that tree and table have something to show."""
    key(window, Qt.Key.Key_T)
    middle = window.viewport.rect().center()
    for dx, dy in ((-80, 10), (-30, -35), (20, 30), (75, -10)):
        click(window.viewport, middle + QPoint(dx, dy))
    key(window, Qt.Key.Key_Return)
    key(window, Qt.Key.Key_N)
    assert len(window.studio.session.features()) == 1


def enter(window) -> None:
    """The mouse comes over the outcrop."""
    at = QPointF(window.viewport.rect().center())
    there = QPointF(window.viewport.mapToGlobal(at.toPoint()))
    QApplication.sendEvent(window.viewport, QEnterEvent(at, at, there))


def turn_wheel(window) -> None:
    from PySide6.QtGui import QWheelEvent

    at = QPointF(window.viewport.rect().center())
    there = QPointF(window.viewport.mapToGlobal(at.toPoint()))
    QApplication.sendEvent(
        window.viewport,
        QWheelEvent(
            at,
            there,
            QPoint(),
            QPoint(0, 120),
            Qt.MouseButton.NoButton,
            driver.NONE,
            Qt.ScrollPhase.NoScrollPhase,
            False,
        ),
    )


def on_outcrop(window) -> bool:
    return QApplication.focusWidget() is window.viewport


def line_panel(window) -> LinePanel:
    """The panel of the line tool, with two points picked."""
    key(window, Qt.Key.Key_L)
    assert window.studio.tool_name == "line"
    middle = window.viewport.rect().center()
    for dx in (-60, 60):
        click(window.viewport, middle + QPoint(dx, 0))
    assert len(window.studio.get_tool(LineTool).vertices) == 2
    return driver.tool_panel(window, LinePanel)


def choose(combo: QComboBox, row: int) -> None:
    """Open the list and click a row."""
    QTest.mouseClick(combo, driver.LEFT, driver.NONE, combo.rect().center())
    view = combo.view()
    wait(view.isVisible, "the list", 5.0)
    at = view.visualRect(view.model().index(row, 0)).center()
    driver.pause(QApplication.doubleClickInterval() + 50)
    QTest.mouseMove(view.viewport(), at)
    QTest.mouseClick(view.viewport(), driver.LEFT, driver.NONE, at)
    wait(lambda: not view.isVisible(), "the end of the list", 5.0)


# --- opening ---------------------------------------------------------------------------------
def test_after_opening_a_model_keys_act_on_the_outcrop(opened):
    assert on_outcrop(opened)
    key(opened, Qt.Key.Key_T)
    assert opened.studio.tool_name == "trace"
    assert opened.table._filter.text() == ""


@pytest.mark.full
def test_opening_photos_or_a_project_moves_focus_from_the_filter(window, photos, tmp_path):
    window.docks.bring_forward("table")
    window.table._filter.setFocus()
    window.open_path(photos)
    assert QApplication.focusWidget() is window.photos_panel.table, "photos have the middle"
    assert not window.start_page.isVisible()
    window.studio.save_as(tmp_path / "a.vom")
    window.studio.new_project()
    window.docks.bring_forward("table")
    window.table._filter.setFocus()
    window.open_path(tmp_path / "a.vom")
    assert on_outcrop(window)


@pytest.mark.full
def test_loading_a_model_does_not_interrupt_typing(window, outcrop):
    window.docks.bring_forward("table")
    press(window.table._filter)
    QTest.keyClicks(window.table._filter, "dip")
    window.studio.model_loaded.emit("")
    QTest.keyClicks(QApplication.focusWidget(), ">3")
    assert window.table._filter.text() == "dip>3"


@pytest.mark.full
def test_focus_moves_to_the_outcrop_when_a_page_is_hidden(window, outcrop):
    button = next(b for b in window.start_page.findChildren(QWidget) if b.focusPolicy())
    button.setFocus(Qt.FocusReason.TabFocusReason)
    assert button.hasFocus()
    window.start_page.hide()
    assert on_outcrop(window)


# --- combo boxes -----------------------------------------------------------------------------
def test_combo_box_choice_returns_focus_and_enter_finishes_the_line(opened):
    panel = line_panel(opened)
    choose(panel.type_box, 1)
    chosen = panel.type_box.currentData()
    assert opened.studio.get_tool(LineTool).attributes.type_id == chosen
    assert on_outcrop(opened)
    key(opened, Qt.Key.Key_Return)
    (line,) = opened.studio.session.features()
    assert line.type_id == chosen


@pytest.mark.full
def test_enter_in_a_combo_box_finishes_and_is_not_swallowed(opened):
    panel = line_panel(opened)
    panel.type_box.setFocus()
    key(opened, Qt.Key.Key_Return)
    assert len(opened.studio.session.features()) == 1


@pytest.mark.full
def test_letters_in_a_combo_box_act_on_the_outcrop_and_change_no_type(opened):
    panel = driver.tool_panel(opened, TracePanel)
    opened.studio.activate("trace")
    before = panel.type_box.currentText()
    for letter, tool in (("l", "line"), ("p", "plane"), ("t", "trace"), ("n", "navigate")):
        opened.studio.activate("trace")
        panel.type_box.setFocus()
        assert panel.type_box.hasFocus()
        QTest.keyClicks(panel.type_box, letter)
        assert opened.studio.tool_name == tool
        assert on_outcrop(opened)
    panel.type_box.setFocus()
    QTest.keyClicks(panel.type_box, "qxyzj")
    assert panel.type_box.currentText() == before


@pytest.mark.full
def test_arrows_open_a_combo_box_instead_of_changing_it_unseen(opened):
    panel = driver.tool_panel(opened, TracePanel)
    opened.studio.activate("trace")
    before = panel.type_box.currentText()
    panel.type_box.setFocus()
    QTest.keyClick(panel.type_box, Qt.Key.Key_Down)
    wait(panel.type_box.view().isVisible, "the list", 5.0)
    assert panel.type_box.currentText() == before
    QTest.keyClick(panel.type_box.view(), Qt.Key.Key_Down)
    QTest.keyClick(panel.type_box.view(), Qt.Key.Key_Return)
    wait(lambda: on_outcrop(opened), "the outcrop's focus", 5.0)
    assert panel.type_box.currentText() != before
    assert opened.studio.next_type_id == panel.type_box.currentData()


@pytest.mark.full
def test_no_combo_box_of_any_panel_is_changed_by_a_letter(opened):
    """Whatever panel it stands in, also those that come later."""
    boxes = [
        box
        for name in opened.docks
        for box in driver.page(opened, name).findChildren(QComboBox)
        if not box.isEditable()
    ]
    assert len(boxes) >= 8
    tried = 0
    for name in opened.docks:
        opened.docks.bring_forward(name)
        QApplication.processEvents()
        for box in driver.page(opened, name).findChildren(QComboBox):
            if not box.isVisible() or not box.isEnabled() or box.isEditable():
                continue
            for letter in {text[:1] for i in range(box.count()) if (text := box.itemText(i))}:
                before = box.currentIndex()
                box.setFocus()
                QTest.keyClicks(box, letter.lower())
                if opened.studio.open_tool is not None:
                    opened.studio.cancel_tool()
                assert box.currentIndex() == before, (name, letter)
                opened.docks.bring_forward(name)
                tried += 1
    assert tried > 10


# --- fields ----------------------------------------------------------------------------------
@pytest.mark.full
def test_enter_stores_the_set_name_and_returns_focus_to_the_outcrop(opened):
    key(opened, Qt.Key.Key_P)
    panel = driver.tool_panel(opened, PlanePanel)
    radius = panel.radius.value()
    press(panel.set_name_edit)
    for letter in "J1":
        QTest.keyClicks(QApplication.focusWidget(), letter)
    key(opened, Qt.Key.Key_Return)
    assert on_outcrop(opened)
    QTest.keyClicks(QApplication.focusWidget(), "]")
    assert opened.studio.next_set == "J1"
    assert panel.radius.value() > radius


@pytest.mark.full
def test_enter_in_a_text_field_does_not_finish_the_line(opened):
    panel = line_panel(opened)
    press(panel.set_name_edit)
    QTest.keyClicks(panel.set_name_edit, "S2")
    key(opened, Qt.Key.Key_Return)
    tool = opened.studio.get_tool(LineTool)
    assert tool.is_open
    assert tool.attributes.set_name == "S2"
    key(opened, Qt.Key.Key_Return)
    assert not tool.is_open


@pytest.mark.full
def test_esc_in_a_text_field_restores_its_text_and_keeps_the_line(opened):
    panel = line_panel(opened)
    press(panel.set_name_edit)
    QTest.keyClicks(panel.set_name_edit, "oops")
    key(opened, Qt.Key.Key_Escape)
    assert on_outcrop(opened)
    assert panel.set_name_edit.text() == ""
    tool = opened.studio.get_tool(LineTool)
    assert tool.is_open, "Esc ended the field, not the line"
    assert tool.attributes.set_name == ""
    key(opened, Qt.Key.Key_Escape)
    assert not tool.is_open
    key(opened, Qt.Key.Key_Z, driver.CTRL)
    assert len(tool.vertices) == 2


@pytest.mark.full
def test_spin_box_accepts_digits_and_passes_letters_to_the_outcrop(opened):
    key(opened, Qt.Key.Key_P)
    panel = driver.tool_panel(opened, PlanePanel)
    click(panel.findChild(MoreSection).toggle, QPoint(12, 8))
    radius = panel.radius
    press(radius)
    radius.selectAll()
    QTest.keyClicks(radius, "0.25")
    key(opened, Qt.Key.Key_Return)
    assert radius.value() == pytest.approx(0.25)
    assert on_outcrop(opened)
    radius.setFocus()
    radius.selectAll()
    QTest.keyClicks(radius, "30 cm")
    key(opened, Qt.Key.Key_Return)
    assert radius.value() == pytest.approx(0.3)
    assert on_outcrop(opened)
    radius.setFocus()
    QTest.keyClicks(radius, "]")
    assert on_outcrop(opened)
    assert radius.value() > 0.3


@pytest.mark.full
def test_every_field_of_every_panel_returns_focus_to_the_outcrop(opened):
    tried = 0
    for name in opened.docks:
        opened.docks.bring_forward(name)
        QApplication.processEvents()
        panel = driver.page(opened, name)
        for field in (*panel.findChildren(QLineEdit), *panel.findChildren(QAbstractSpinBox)):
            if isinstance(field.parent(), QAbstractSpinBox | QComboBox) or not field.isVisible():
                continue
            if not field.isEnabled() or field.isReadOnly():
                continue
            for code in (Qt.Key.Key_Escape, Qt.Key.Key_Return):
                field.setFocus()
                assert field.hasFocus()
                QTest.keyClick(field, code)
                assert on_outcrop(opened), (name, field.objectName(), code)
                tried += 1
    assert tried >= 8


# --- tables that are filled in by hand ---------------------------------------------------------
def press_cell(table, row: int, column: int) -> None:
    """Scroll to a cell, and click it."""
    table.scrollTo(table.model().index(row, column))
    at = table.visualRect(table.model().index(row, column)).center()
    QTest.mouseClick(table.viewport(), driver.LEFT, driver.NONE, at)
    wait(table.hasFocus, "the table's focus", 5.0)


def type_keys(text: str) -> None:
    """Each key for whatever has the focus when it is pressed."""
    for letter in text:
        QTest.keyClicks(QApplication.focusWidget(), letter)
        QApplication.processEvents()


@pytest.mark.full
def test_typing_edits_the_selected_cell_and_enter_returns_focus(opened):
    key(opened, Qt.Key.Key_C)
    panel = driver.tool_panel(opened, ControlPanel)
    click(opened.viewport, opened.viewport.rect().center())
    camera = opened.viewport.moves.camera_state()
    for column, text in ((1, "PCT1"), (2, "372415.5"), (3, "4709817"), (4, "-12")):
        opened.docks.bring_forward("tool")
        press_cell(panel.table, 0, column)
        type_keys(text)
        key(opened, Qt.Key.Key_Return)
        assert on_outcrop(opened)
        assert opened.studio.tool_name == "control"
    (point,) = opened.studio.session.of(ControlPoint)
    assert point.name == "PCT1"
    assert point.position == pytest.approx((372415.5, 4709817.0, -12.0))
    assert opened.viewport.moves.camera_state() == camera
    # A letter is no number: it is the outcrop's.
    press_cell(panel.table, 0, 2)
    type_keys("n")
    assert opened.studio.tool_name == "navigate"


@pytest.mark.full
def test_a_vertex_is_typed_and_deleted_in_its_row(opened):
    key(opened, Qt.Key.Key_T)
    middle = opened.viewport.rect().center()
    for dx, dy in ((-80, 10), (-30, -35), (20, 30), (75, -10)):
        click(opened.viewport, middle + QPoint(dx, dy))
    tool = opened.studio.get_tool(TraceTool)
    panel = driver.tool_panel(opened, TracePanel)
    click(panel.findChild(MoreSection).toggle, QPoint(12, 8))
    table = panel.findChild(VertexTable)
    wait(table.isVisible, "the vertices")
    before, camera = tool.vertices, opened.viewport.moves.camera_state()
    height = float(table.item(1, 2).text()) + 0.125
    press_cell(table, 1, 2)
    type_keys(f"{height:.3f}")
    key(opened, Qt.Key.Key_Return)
    assert on_outcrop(opened)
    assert tool.vertices[1][2] - before[1][2] == pytest.approx(0.125, abs=1e-3)
    assert opened.viewport.moves.camera_state() == camera
    press_cell(table, 2, 0)
    QTest.keyClick(table, Qt.Key.Key_Delete)
    assert tool.vertices == (*before[:1], tool.vertices[1], before[3])
    assert tool.is_open


@pytest.mark.full
def test_letters_on_the_orientation_table_do_not_start_editing(opened):
    one_plane(opened)
    press_cell(opened.table.view, 0, 0)
    type_keys("t")
    assert opened.studio.tool_name == "trace"
    assert on_outcrop(opened)


# --- mouse and wheel -------------------------------------------------------------------------
@pytest.mark.full
@pytest.mark.parametrize("come", [enter, turn_wheel])
def test_pointer_entering_outcrop_takes_focus_unless_editing_text(opened, come):
    one_plane(opened)
    opened.docks.bring_forward("project")
    field = opened.table._filter
    for other in (opened.table.view, opened.tree.tree, field):
        other.setFocus()
        assert other.hasFocus()
        come(opened)
        assert on_outcrop(opened), other
    press(field)
    QTest.keyClicks(field, "di")
    come(opened)
    QTest.keyClicks(QApplication.focusWidget(), "p")
    assert field.text() == "dip"
    key(opened, Qt.Key.Key_Return)
    come(opened)
    key(opened, Qt.Key.Key_T)
    assert opened.studio.tool_name == "trace"
    assert field.text() == "dip"


def test_field_keeps_focus_while_the_pointer_is_still(opened):
    """A hint or a list over the outcrop that closes is no movement of the mouse."""
    middle = opened.viewport.rect().center()
    driver.move(opened.viewport, middle + QPoint(40, 0))
    driver.move(opened.viewport, middle)
    field = opened.table._filter
    field.setFocus()
    enter(opened)
    assert field.hasFocus()
    driver.focus(opened)
    driver.move(opened.viewport, middle + QPoint(40, 0))
    field.setFocus()
    enter(opened)
    assert on_outcrop(opened)


@pytest.mark.full
def test_clicking_the_outcrop_takes_focus_from_edited_text(opened):
    press(opened.table._filter)
    QTest.keyClicks(opened.table._filter, "dip")
    click(opened.viewport, opened.viewport.rect().center())
    assert on_outcrop(opened)


@pytest.mark.full
def test_letters_on_buttons_and_lists_act_on_the_outcrop(opened):
    one_plane(opened)
    buttons = [b for b in opened.docks["view"].widget().findChildren(QPushButton) if b.isEnabled()]
    opened.docks.bring_forward("view")
    QApplication.processEvents()
    for widget in (opened.tree.tree, opened.table.view, buttons[0]):
        for letter, tool in (("t", "trace"), ("n", "navigate")):
            widget.setFocus()
            assert widget.hasFocus()
            QTest.keyClicks(widget, letter)
            assert opened.studio.tool_name == tool
            opened.docks.bring_forward("view")


@pytest.mark.full
@pytest.mark.usefixtures("new_window")
def test_closed_window_does_not_affect_focus_in_another_window(window):
    """The watcher is told of every change of the focus in the program: it goes with its window."""
    other = driver.make_window()
    press(other.table._filter)
    QTest.keyClicks(other.table._filter, "di")
    driver.dismiss(other)
    driver.focus(window)
    press(window.table._filter)
    enter(window)
    assert on_outcrop(window)
