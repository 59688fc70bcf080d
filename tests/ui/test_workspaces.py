"""Six workspaces: their keys, their docks, what they remember, and small screens."""

from __future__ import annotations

import subprocess
import sys

import pytest
from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QApplication,
    QDockWidget,
    QLabel,
    QMainWindow,
    QTabBar,
    QToolBar,
    QWidget,
)

from tests import driver
from tests.studio.tools.fakes import event
from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.io.settings import read_settings
from vomstudio.studio.tools.registry import TOOLS
from vomstudio.ui.panels.tools.line import LinePanel
from vomstudio.ui.panels.tools.trace import TracePanel
from vomstudio.ui.shell import screens
from vomstudio.ui.shell.main_window import MainWindow
from vomstudio.ui.shell.workspace_table import HOMES, WORKSPACES

NAMES = [workspace.name for workspace in WORKSPACES]
SETTLED_MS = 700


def press(window, number: int) -> None:
    QTest.keyClick(window, Qt.Key(Qt.Key.Key_0 + number), driver.CTRL)
    driver.pause(50)


def there(window) -> set[str]:
    """Docks that are shown, be it behind another tab."""
    return {name for name, dock in window.docks.items() if not dock.isHidden()}


def in_front(window) -> dict[str, QRect]:
    """Docks that are seen, with their places in the window."""
    return {
        name: QRect(dock.mapTo(window, QPoint(0, 0)), dock.size())
        for name, dock in window.docks.items()
        if not dock.isHidden() and not dock.isFloating() and not dock.visibleRegion().isEmpty()
    }


def bars_of_tabs(window) -> int:
    return sum(bar.isVisible() for bar in window.findChildren(QTabBar) if bar.parent() is window)


def stacks(window) -> set[frozenset[QDockWidget]]:
    """The docks that share a place as tabs."""
    docked = [d for d in window.docks.values() if not d.isHidden() and not d.isFloating()]
    found = {frozenset({d, *window.tabifiedDockWidgets(d)}) for d in docked}
    return {stack for stack in found if len(stack) > 1}


def resize(window, width: int, height: int) -> None:
    window.resize(width, height)
    driver.pause(SETTLED_MS)


# --- the table ------------------------------------------------------------------------------
def test_the_workspaces_follow_the_day_and_every_dock_belongs_to_one(window):
    assert NAMES == ["photos", "model", "register", "interpret", "analyse", "views"]
    assert set(window.docks) == set(HOMES)
    listed = frozenset().union(*(workspace.docks for workspace in WORKSPACES))
    assert listed == set(window.docks)
    for workspace in WORKSPACES:
        stacks = [s for stacks in workspace.places.values() for s in stacks]
        names = [name for stack in stacks for name in stack]
        assert len(names) == len(set(names)), "a dock can stand in one place only"
        assert len(names) <= 10
        assert max(len(stack) for stack in stacks) <= 5
        assert workspace.purpose.endswith(".")
        assert "\n" not in workspace.purpose


# --- keys and strip -------------------------------------------------------------------------
def test_each_key_shows_the_docks_of_its_workspace_and_nothing_else(window):
    resize(window, 1400, 900)
    for number in (1, 2, 3, 4, 5, 6, 2, 4):
        press(window, number)
        assert there(window) == WORKSPACES[number - 1].docks
        pressed = [n for n in NAMES if window.actions_table.all[f"workspace_{n}"].isChecked()]
        assert pressed == [NAMES[number - 1]]


def test_a_key_works_while_a_text_is_edited_and_the_text_stays(window, studio):
    add_cliff(studio)
    add_bed(studio)
    field = window.table._filter
    field.setFocus()
    QTest.keyClicks(field, "dip")
    QTest.keyClick(field, Qt.Key.Key_6, driver.CTRL)
    driver.pause(50)
    assert window.workspaces.shown.name == "views"
    assert field.text() == "dip"


def test_a_button_of_the_strip_shows_its_workspace(window):
    strip = window.findChild(QToolBar, "workspaces")
    for name in ("analyse", "photos", "interpret"):
        button = strip.widgetForAction(window.actions_table.all[f"workspace_{name}"])
        QTest.mouseClick(button, driver.LEFT)
        assert window.workspaces.shown.name == name
        assert button.isChecked()


def test_switching_changes_neither_records_nor_selection_nor_undo(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1")
    add_bed(studio, "t2")
    studio.selection.set(["t1", "t2"])
    before = dict(studio.records), studio.selection.ids, studio.undo_label, studio.redo_label
    for number in range(1, 7):
        press(window, number)
    assert (
        dict(studio.records),
        studio.selection.ids,
        studio.undo_label,
        studio.redo_label,
    ) == before


# --- what is opened -------------------------------------------------------------------------
def test_photos_are_shown_among_photos_and_take_the_middle(window, tmp_path):
    (tmp_path / "photos").mkdir()
    window.open_path(tmp_path / "photos")
    driver.pause(100)
    assert window.workspaces.shown.name == "photos"
    place = in_front(window)["photos"]
    assert place.width() >= 0.9 * window.width()
    assert place.height() >= 0.7 * window.height()


def test_a_message_is_read_although_photos_have_the_middle(window, studio, tmp_path):
    press(window, 1)
    message = "The disk is full."
    studio.warn(message, "error")
    driver.pause(50)
    bar = window.message_bar
    assert bar.text == message
    assert bar.visibleRegion().boundingRect().height() >= bar.sizeHint().height()


def test_the_outcrop_keeps_its_place_among_photos_while_a_model_is_open(window, studio):
    add_cliff(studio)
    press(window, 1)
    assert window.centralWidget().height() > 100
    assert not window.docks["photos"].isHidden()


def test_photos_that_are_floated_or_closed_leave_the_middle_to_the_outcrop(window):
    press(window, 1)
    assert window.centralWidget().height() < 100
    window.docks["photos"].setFloating(True)
    driver.pause(100)
    assert window.centralWidget().height() > 100
    window.docks["photos"].setFloating(False)
    driver.pause(100)
    assert window.centralWidget().height() < 100
    window.docks["photos"].close()
    driver.pause(100)
    assert window.centralWidget().height() > 100


def test_opening_a_model_leaves_photos_and_nothing_else(window, studio, tmp_path):
    for number, then in ((1, "interpret"), (2, "model"), (5, "analyse")):
        press(window, number)
        window.open_path(tmp_path / "missing.obj")
        assert window.workspaces.shown.name == then


def test_a_workspace_says_what_it_is_for_until_it_has_something_to_show(window, studio):
    def said() -> str:
        label = window.findChild(QLabel, "workspace_purpose")
        return "" if label.isHidden() else label.text()

    for number, workspace in enumerate(WORKSPACES, start=1):
        press(window, number)
        assert said() == workspace.purpose
    add_cliff(studio)
    empty = []
    for number in range(1, 7):
        press(window, number)
        empty += [NAMES[number - 1]] if said() else []
    assert empty == ["photos", "analyse"]
    add_bed(studio)
    press(window, 5)
    assert said() == ""


# --- remembering ----------------------------------------------------------------------------
def test_each_workspace_keeps_its_own_arrangement(window):
    resize(window, 1400, 900)
    press(window, 4)
    window.docks["properties"].close()
    window.docks["jobs"].toggleViewAction().trigger()
    window.resizeDocks([window.docks["project"]], [370], Qt.Orientation.Horizontal)
    driver.pause(50)
    width = window.docks["project"].width()
    assert width > 340
    press(window, 5)
    assert there(window) == WORKSPACES[4].docks
    press(window, 2)
    assert window.docks["project"].width() < 340
    press(window, 4)
    assert there(window) == (WORKSPACES[3].docks - {"properties"}) | {"jobs"}
    assert window.docks["project"].width() == width


def test_panels_are_reset_in_the_workspace_that_is_shown(window):
    resize(window, 1400, 900)
    press(window, 6)
    window.docks["view"].close()
    press(window, 4)
    first = in_front(window)
    window.docks["stereonet"].setFloating(True)
    window.docks["table"].close()
    window.resizeDocks([window.docks["project"]], [400], Qt.Orientation.Horizontal)
    driver.pause(50)
    window.actions_table.run("reset_panels")
    driver.pause(100)
    assert in_front(window) == first
    press(window, 6)
    assert "view" not in there(window), "other workspaces stay as they are"


def test_all_panels_are_hidden_and_come_back_with_a_key_of_a_workspace_too(window):
    QTest.keyClick(window, Qt.Key.Key_F9)
    assert there(window) == set()
    press(window, 4)
    assert there(window) == WORKSPACES[3].docks
    QTest.keyClick(window, Qt.Key.Key_F9)
    press(window, 6)
    assert there(window) == WORKSPACES[5].docks
    press(window, 4)
    assert there(window) == WORKSPACES[3].docks


@pytest.mark.full
def test_every_dock_can_be_shown_in_every_workspace(window):
    resize(window, 1400, 900)
    for number in range(1, 7):
        press(window, number)
        for name in window.docks:
            window.docks.bring_forward(name)
            driver.pause(30)
            assert name in in_front(window), (NAMES[number - 1], name)
        assert bars_of_tabs(window) == len(stacks(window))
        window.actions_table.run("reset_panels")


def test_what_was_arranged_is_there_after_a_crash(window):
    """The first window is not closed: what the second finds was kept before."""
    resize(window, 1300, 850)
    press(window, 5)
    window.docks["properties"].close()
    driver.pause(SETTLED_MS)
    driver.wait(lambda: read_settings()[0].window.get("workspace") == "analyse", "the settings")
    second = MainWindow(read_settings()[0])
    second.show()
    second._fill()
    second.studio.jobs.close()
    driver.pause(100)
    assert (second.width(), second.height()) == (1300, 850)
    assert second.workspaces.shown.name == "analyse"
    assert there(second) == WORKSPACES[4].docks - {"properties"}
    second.activateWindow()
    driver.wait(lambda: QApplication.activeWindow() is second, "the second window")
    press(second, 4)
    assert there(second) == WORKSPACES[3].docks
    driver.dismiss(second)


@pytest.mark.parametrize("text", ["", "AAAA", "not base64 \N{SNOWMAN}", "////"])
def test_damaged_arrangements_are_left_out(own_folders, qtbot, text):
    settings = read_settings()[0]
    settings.window = {"geometry": text, "docks interpret": text, "workspace": text}
    window = MainWindow(settings)
    window.show()
    window._fill()
    window.studio.jobs.close()
    driver.pause(50)
    assert window.workspaces.shown.name == "interpret"
    assert "tool" in there(window)
    driver.dismiss(window)


# --- screens --------------------------------------------------------------------------------
def test_a_window_comes_back_from_a_screen_that_is_gone(qtbot):
    there_once = QMainWindow()
    qtbot.addWidget(there_once)
    there_once.show()
    there_once.setGeometry(9000, 7000, 1200, 800)
    driver.pause(50)
    kept = screens.to_text(there_once.saveGeometry())
    window = QMainWindow()
    qtbot.addWidget(window)
    screens.restore_geometry(window, kept)
    window.show()
    driver.pause(50)
    screen = QGuiApplication.primaryScreen().availableGeometry()
    assert screen.contains(window.geometry().center())
    assert screen.intersected(window.frameGeometry()).height() > 400


def test_a_window_fits_a_screen_that_has_shrunk(window):
    screen = QGuiApplication.primaryScreen()
    area = screen.availableVirtualGeometry()
    window.resize(area.width() + 500, area.height() + 300)
    driver.pause(50)
    screen.availableGeometryChanged.emit(area)
    driver.wait(lambda: area.contains(window.frameGeometry()), "the smaller window", 5.0)
    # What fits stays as it is.
    window.resize(1000, 600)
    driver.pause(50)
    before = window.geometry()
    screen.availableGeometryChanged.emit(area)
    driver.pause(50)
    assert window.geometry() == before


def test_a_floating_dock_comes_back_from_a_screen_that_is_gone(window):
    dock = window.docks["stereonet"]
    dock.setFloating(True)
    dock.move(9000, 7000)
    driver.pause(50)
    press(window, 2)
    press(window, 4)
    assert dock.isFloating()
    screen = QGuiApplication.primaryScreen().availableGeometry()
    assert screen.contains(dock.geometry().topLeft() + QPoint(60, 10))


@pytest.mark.parametrize(
    ("width", "height"),
    first_in_default_tier([(960, 508), (1100, 620), (1280, 688), (1920, 1040)], 1),
)
def test_nothing_is_cut_off_and_the_outcrop_has_room_in_any_window(window, studio, width, height):
    add_cliff(studio)
    add_bed(studio)
    window.setMinimumSize(1, 1)
    resize(window, width, height)
    for workspace in WORKSPACES:
        window.workspaces.switch(workspace.name)
        driver.pause(100)
        needed = window.minimumSizeHint()
        assert needed.width() <= 960, workspace.name
        assert needed.height() <= height, workspace.name
        assert bars_of_tabs(window) == len(stacks(window)), workspace.name
        inside = QRect(QPoint(0, 0), window.size())
        places = in_front(window)
        assert places
        for name, place in places.items():
            assert inside.contains(place), (workspace.name, name)
            wanted = window.docks[name].minimumSizeHint()
            assert place.width() >= wanted.width(), (workspace.name, name)
        assert window.centralWidget().width() >= 0.4 * width, workspace.name
        assert window.centralWidget().height() >= 120, workspace.name


def test_docks_fold_in_a_small_window_and_unfold_again(window):
    resize(window, 1400, 900)
    press(window, 4)
    window.docks["properties"].close()
    driver.pause(SETTLED_MS)
    large = in_front(window)
    resize(window, 980, 600)
    small = in_front(window)
    assert len(small) == 2, "one stack at each side"
    assert window.docks["table"] in window.tabifiedDockWidgets(window.docks["project"])
    resize(window, 1400, 900)
    assert in_front(window) == large
    resize(window, 980, 600)
    assert in_front(window) == small


_FIRST_START = """
from PySide6.QtWidgets import QApplication
application = QApplication([])
from vomstudio.io.settings import read_settings
from vomstudio.ui.shell.main_window import MainWindow
window = MainWindow(read_settings()[0])
window.show()
window.begin([])
for _ in range(30): application.processEvents()
area = window.screen().availableGeometry()
print(area.width(), area.height(), window.width(), window.height())
for name in ("photos", "model", "register", "interpret", "analyse", "views"):
    window.workspaces.switch(name)
    for _ in range(30): application.processEvents()
    print(window.minimumSizeHint().width(), window.minimumSizeHint().height())
window.studio.jobs.close()
import os, sys; sys.stdout.flush(); os._exit(0)
"""


@pytest.mark.parametrize("logical_width", first_in_default_tier([1600, 1280, 960], 1))
def test_a_first_start_fits_the_screen_at_any_scale(own_folders, monkeypatch, logical_width):
    """A screen of few logical pixels is a large one at 125 or 167 %."""
    wide = QGuiApplication.primaryScreen().geometry().width()
    monkeypatch.setenv("QT_SCALE_FACTOR", str(wide / logical_width))
    said = subprocess.run(
        [sys.executable, "-c", _FIRST_START],
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    ).stdout
    first, *needed = [[int(number) for number in line.split()] for line in said.splitlines()]
    screen_width, screen_height, width, height = first
    assert abs(screen_width - logical_width) <= 2
    assert width <= screen_width
    assert height < screen_height, "the title has room above"
    assert width >= min(960, screen_width - 10)
    assert len(needed) == 6
    for least_width, least_height in needed:
        assert least_width <= width
        assert least_height <= height


# --- the panel of the active tool -----------------------------------------------------------
def test_one_dock_follows_the_tool(window, studio):
    add_cliff(studio)
    dock, panel = window.docks["tool"], window.tool_panel
    assert not {entry.name for entry in TOOLS} & set(window.docks)
    assert dock.windowTitle() == "Tool"
    shown = {}
    for entry in TOOLS:
        studio.activate(entry.name)
        assert dock.windowTitle() == entry.title
        shown[entry.name] = panel.currentWidget()
        assert panel.currentWidget() is panel.panels[entry.name]
    # Known lines place a model together with control points, and stand in their panel.
    assert shown.pop("known_line") is shown["control"]
    assert len({id(widget) for widget in shown.values()}) == len(TOOLS) - 1
    studio.activate("navigate")
    assert dock.windowTitle() == "Tool"
    assert panel.currentWidget() not in panel.panels.values()


def test_an_open_line_keeps_its_panel_while_navigating(window, studio):
    add_cliff(studio)
    studio.activate("line")
    for point in ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)):
        studio.pointer(event(at=point))
    studio.activate("navigate")
    panel, dock = driver.tool_panel(window, LinePanel), window.docks["tool"]
    assert panel.isVisible()
    assert dock.windowTitle() == "Line"
    studio.cancel_tool()
    assert not panel.isVisible()
    assert dock.windowTitle() == "Tool"


def test_choosing_a_tool_brings_its_dock_in_any_workspace(window, studio):
    add_cliff(studio)
    for number in (2, 5, 6):
        press(window, number)
        studio.activate("navigate")
        studio.activate("trace")
        driver.pause(50)
        assert window.workspaces.shown.name == NAMES[number - 1]
        assert "tool" in in_front(window)
        assert driver.tool_panel(window, TracePanel).isVisible()


def test_a_tool_that_is_chosen_among_photos_goes_to_the_outcrop(window, studio):
    press(window, 1)
    studio.activate("trace")
    driver.pause(50)
    assert window.workspaces.shown.name == "interpret"
    assert QApplication.activeWindow() is window


def test_keys_of_workspaces_work_in_a_floating_panel(window):
    dock = window.docks["table"]
    dock.setFloating(True)
    dock.activateWindow()
    driver.wait(lambda: QApplication.activeWindow() is dock, "the floating panel", 5.0)
    window.table._filter.setFocus()
    QTest.keyClick(window.table._filter, Qt.Key.Key_6, driver.CTRL)
    driver.pause(50)
    assert window.workspaces.shown.name == "views"


def test_an_arrangement_without_a_panel_that_came_since_gives_way(qtbot):
    """Kept by a version with fewer panels, it would hide the new one for good."""
    from vomstudio.ui.shell.docks import WindowDocks

    def docks(*names: str) -> WindowDocks:
        window = QMainWindow()
        qtbot.addWidget(window)
        made = WindowDocks(window)
        for name in names:
            made.add(name, name, QLabel(name))
        return made

    state = docks("project", "view").state()
    assert docks("view", "project").restore(state)
    assert not docks("project", "view", "table").restore(state)


@pytest.mark.parametrize("width", [1280, 1100, 960])
def test_no_button_of_the_bars_goes_behind_an_arrow_when_the_window_becomes_narrower(
    window, width
) -> None:
    resize(window, 1600, 900)
    resize(window, width, 720)
    bars = [bar for bar in window.findChildren(QToolBar) if bar.isVisible()]
    assert len(bars) == 2
    for bar in bars:
        arrow = bar.findChild(QWidget, "qt_toolbar_ext_button")
        driver.wait(lambda a=arrow: not a.isVisible(), f"room for all of {bar.objectName()}")
