"""Keys, clicks, files and closing at moments at which nobody expects them: nothing is lost, nothing
is stuck, and each is said."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialog, QLineEdit, QMessageBox

from tests import driver
from tests.driver import click, drag, key, look_at, pixel, wait
from tests.journeys.conftest import bare_outcrop
from tests.journeys.recorded import on_screen
from vomstudio.core.paths import resource
from vomstudio.studio.tools.plane import PlaneTool
from vomstudio.studio.tools.trace import TraceTool

pytestmark = pytest.mark.full

TOOLS = {"T": "trace", "L": "line", "M": "measure"}
"""Those that pick one point after another."""
MOMENTS = (0, 15, 60, 250, 900)
LETTERS = "TPLMNFOBIHX[]12"


@pytest.fixture
def faced(window, outcrop, picks):
    """The outcrop with a bed, seen from the front."""
    driver.open_outcrop(window, outcrop)
    look_at(window, np.concatenate(list(picks.values())), 0.0, 10.0)
    key(window, Qt.Key.Key_T)
    driver.pick(window, picks["B04"][2:22:3])
    key(window, Qt.Key.Key_Return)
    key(window, Qt.Key.Key_N)
    return window


def said(window) -> str:
    """All that was said so far."""
    listed = [window.messages.item(i).text() for i in range(window.messages.count())]
    return "\n".join([*listed, window.message_bar.text, window.status_line.currentMessage()])


def shown_dialogs(window) -> list[QDialog]:
    return [d for d in window.findChildren(QDialog) if d.isVisible()]


def wheel(widget, at: QPoint) -> None:
    where = QPointF(at)
    event = QWheelEvent(
        where,
        QPointF(widget.mapToGlobal(at)),
        QPoint(),
        QPoint(0, 120),
        driver.Qt.MouseButton(0),
        driver.NONE,
        Qt.ScrollPhase.NoScrollPhase,
        False,
    )
    QApplication.sendEvent(widget, event)


def press_all(window) -> None:
    for letter in LETTERS:
        target = QApplication.focusWidget() or window
        QTest.keyClick(target, letter)
        driver.pause(2)


# --- keys and wheel while something else is open ----------------------------------------------
def test_letters_typed_in_a_text_field_trigger_no_shortcuts(faced):
    window = faced
    before, tool = on_screen(window.studio), window.studio.tool_name
    camera = window.viewport.moves.camera_state()
    field = window.tree.findChild(QLineEdit)
    field.setFocus()
    press_all(window)
    assert field.text() == LETTERS
    assert (window.studio.tool_name, on_screen(window.studio)) == (tool, before)
    assert window.viewport.moves.camera_state() == camera


def test_letters_in_a_dialog_never_reach_the_outcrop_behind_it(faced):
    window = faced
    before, camera = on_screen(window.studio), window.viewport.moves.camera_state()
    for action in ("orthophoto", "declare_frame"):
        window.actions_table.run(action)
        wait(lambda: shown_dialogs(window), "the dialog")
        (dialog,) = shown_dialogs(window)
        # Without a window manager nobody else gives it the keyboard.
        dialog.activateWindow()
        wait(lambda d=dialog: QApplication.activeWindow() is d, "the active dialog", 5.0)
        press_all(window)
        QTest.keyClick(dialog, Qt.Key.Key_Delete)
        assert window.studio.tool_name == "navigate"
        assert on_screen(window.studio) == before
        dialog.reject()
        driver.focus(window)
    assert window.viewport.moves.camera_state() == camera


def test_keys_wheel_and_undo_work_while_a_job_runs(faced, tmp_path):
    window = faced
    jobs = driver.begin_reading(window, tmp_path)
    before = window.viewport.camera.distance
    wheel(window.viewport, window.viewport.rect().center())
    assert window.viewport.camera.distance != before
    assert len(driver.traces(window)) == 1
    key(window, Qt.Key.Key_Z, driver.CTRL)
    assert driver.traces(window) == []
    assert jobs.visible(), "the job goes on"
    key(window, Qt.Key.Key_Z, driver.CTRL | Qt.KeyboardModifier.ShiftModifier)
    assert len(driver.traces(window)) == 1
    window.studio.loader.forget_all()
    wait(lambda: not jobs.visible(), "the end of the job")


# --- Esc, Enter, undo at every step -----------------------------------------------------------
def feature_discarded(window) -> None:
    """Nothing open, and nothing said, for the next round in the same window."""
    key(window, Qt.Key.Key_Escape)
    key(window, Qt.Key.Key_Escape)
    key(window, Qt.Key.Key_N)
    assert window.studio.open_tool is None
    window.messages.clear()
    window.message_bar._text.clear()
    window.status_line.clearMessage()
    assert not said(window).strip()


@pytest.mark.parametrize("letter", TOOLS)
def test_esc_at_every_step_closes_the_tool_and_undo_restores_it(faced, picks, letter):
    window, studio = faced, faced.studio
    tool = studio.tools[TOOLS[letter]]
    for count in (0, 1, 2, 4):
        feature_discarded(window)
        before = on_screen(studio)
        key(window, Qt.Key(ord(letter)))
        for point in picks["B03"][2:22:4][:count]:
            click(window.viewport, pixel(window, point))
            QTest.qWait(2)
        kept = len(tool.vertices)
        # A measurement of two points is finished by the second one.
        features = len(studio.session.features())
        key(window, Qt.Key.Key_Escape)
        key(window, Qt.Key.Key_Escape)
        assert studio.open_tool is None
        assert window.viewport.preview is None
        assert len(studio.session.features()) == features
        if tool.name == "trace":
            assert on_screen(studio) == before
        if kept:
            key(window, Qt.Key.Key_Z, driver.CTRL)
            assert len(tool.vertices) == kept


@pytest.mark.parametrize(("letter", "needed"), [("T", 3), ("L", 2), ("M", 2), ("P", 1)])
def test_enter_with_too_few_points_reports_it_and_keeps_the_points(faced, picks, letter, needed):
    window, studio = faced, faced.studio
    tool = studio.tools[{**TOOLS, "P": "plane"}[letter]]
    for count in range(needed):
        feature_discarded(window)
        key(window, Qt.Key(ord(letter)))
        for point in picks["B03"][2:22:4][:count]:
            click(window.viewport, pixel(window, point))
        before = len(studio.session.features())
        key(window, Qt.Key.Key_Return)
        assert len(studio.session.features()) == before
        assert studio.tool_name == tool.name
        if count:
            assert tool.is_open
            assert len(tool.vertices) == count
            words = said(window)
            assert "more" in words or "at least" in words or "needs" in words, words


def test_undo_during_a_vertex_drag_leaves_a_valid_trace(faced, picks):
    window, tool = faced, faced.studio.get_tool(TraceTool)
    key(window, Qt.Key.Key_T)
    points = picks["B03"][2:22:4]
    driver.pick(window, points)
    count = len(tool.vertices)
    start = pixel(window, points[2])
    drag(window.viewport, start, start + QPoint(25, 12), release=False)
    key(window, Qt.Key.Key_Z, driver.CTRL)
    key(window, Qt.Key.Key_Escape)
    QTest.mouseRelease(window.viewport, driver.LEFT, driver.NONE, start + QPoint(25, 12))
    assert not any(np.isnan(v).any() for v in tool.vertices)
    for _ in range(12):
        key(window, Qt.Key.Key_Z, driver.CTRL)
    assert driver.traces(window) == []
    for _ in range(14):
        key(window, Qt.Key.Key_Z, driver.CTRL | Qt.KeyboardModifier.ShiftModifier)
    assert len(driver.traces(window)) >= 1
    assert len(tool.vertices) <= count


def test_undo_and_tool_change_during_a_brush_stroke_end_the_stroke(faced, picks):
    window, studio = faced, faced.studio
    key(window, Qt.Key.Key_P)
    patch = studio.get_tool(PlaneTool)
    start = pixel(window, picks["B04"][10]) + QPoint(0, 25)
    drag(window.viewport, start, start + QPoint(30, 0), release=False)
    key(window, Qt.Key.Key_Z, driver.CTRL)
    key(window, Qt.Key.Key_T)
    key(window, Qt.Key.Key_Escape)
    QTest.mouseRelease(window.viewport, driver.LEFT, driver.NONE, start + QPoint(30, 0))
    key(window, Qt.Key.Key_Escape)
    assert not patch._is_pressed
    key(window, Qt.Key.Key_N)
    drag(window.viewport, start, start + QPoint(30, 5))
    assert studio.tool_name == "navigate"
    assert not patch._is_pressed


# --- clicks that come too fast ----------------------------------------------------------------
def test_third_click_after_double_click_does_not_start_a_second_trace(faced, picks):
    window, studio = faced, faced.studio
    key(window, Qt.Key.Key_T)
    places = [pixel(window, p) for p in picks["B03"][2:22:4]]
    for at in places:
        click(window.viewport, at)
        QTest.qWait(2)
    before = len(driver.traces(window))
    QTest.mouseClick(window.viewport, driver.LEFT, driver.NONE, places[-1])
    QTest.mouseDClick(window.viewport, driver.LEFT, driver.NONE, places[-1])
    assert len(driver.traces(window)) == before + 1
    assert studio.open_tool is None


# --- files ------------------------------------------------------------------------------------
def test_dropping_twenty_files_opens_valid_ones_and_reports_damaged_ones(window, tmp_path):
    paths = []
    for number in range(20):
        path = tmp_path / f"part{number:02d}.obj"
        x = 10.0 * number
        path.write_text(
            f"v {x} 0 0\nv {x + 5} 0 0\nv {x} 5 0\nv {x} 5 {number + 1}\nf 1 2 3\nf 1 2 4\n"
        )
        paths.append(path)
    damaged = [paths[3], paths[9], paths[19]]
    damaged[0].write_bytes(b"\0\1\2\3" * 500)
    damaged[1].write_text("v 1 2\nv nonsense\nf 1 2 3\n")
    damaged[2].write_text("")
    driver.drop(window, paths)
    wait(lambda: not window.studio.loader.busy, "the end of the reading", 90.0)
    names = {model.name for model in window.studio.session.of(driver.Model)}
    assert names == {path.stem for path in paths if path not in damaged}
    words = said(window)
    for path in damaged:
        assert path.name in words
    # Frames are asked for one after the other, and who stops answering is told how many are left.
    for number in (1, 2):
        driver.declare(window)
        wait(lambda: driver.dialog_of(window) is not None, "the next question")
        declared = [m for m in window.studio.session.of(driver.Model) if m.frame.crs == driver.CRS]
        assert len(declared) == number
    driver.dialog_of(window).reject()
    driver.pause(100)
    assert driver.dialog_of(window) is None
    assert "14 more models" in said(window)
    assert window.isEnabled()
    wait(lambda: len(window.viewport.scene.models) == 17, "the drawn models", 60.0)


# --- closing ----------------------------------------------------------------------------------
# Before anything was begun, in its midst, and when it is done; the moments between are slow tests.
@pytest.mark.parametrize(
    "moment_ms",
    [pytest.param(t, marks=[pytest.mark.slow] if t in (15, 250) else []) for t in MOMENTS],
)
@pytest.mark.parametrize("what", ["model", "sample", "layers", "photos"])
def test_the_window_can_be_closed_at_any_moment_of_a_job(
    own_folders, qtbot, tmp_path, what, moment_ms
):
    window = driver.make_window()
    outcrop = bare_outcrop(tmp_path / "models")
    if what == "layers":
        window.open_path(outcrop)
        driver.declare(window)
        driver.settled(window)
    if what == "model":
        window.open_path(outcrop)
    elif what == "sample":
        window.actions_table.run("open_sample")
    elif what == "photos":
        folder = tmp_path / "photos"
        folder.mkdir()
        for file in sorted(resource("sample").glob("face_*.jpg"))[:4]:
            shutil.copy(file, folder)
        window.open_path(folder)
    else:
        window.studio.save_as(tmp_path / "cliff.vom")
    driver.pause(moment_ms)
    processes = [w._process for w in window.studio.jobs.workers.values() if w._process]
    driver.close(window)
    wait(lambda: all(p.poll() is not None for p in processes), "the end of the workers", 10.0)


@pytest.mark.usefixtures("new_window")
def test_closing_with_an_open_trace_asks_and_cancel_loses_nothing(faced, picks):
    window, tool = faced, faced.studio.get_tool(TraceTool)
    key(window, Qt.Key.Key_T)
    driver.pick(window, picks["B03"][2:22:4])
    seen: list[str] = []
    driver.answer(QMessageBox.StandardButton.Cancel, seen)
    assert not window.close()
    assert seen
    assert len(tool.vertices) == 5
    # As a window manager does when a box has closed.
    driver.focus(window)
    key(window, Qt.Key.Key_Return)
    assert len(driver.traces(window)) == 2
