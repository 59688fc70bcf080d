"""Three workspaces, the regions of the window, what they remember, and small screens."""

from __future__ import annotations

import subprocess
import sys

import pytest
from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtGui import QCursor, QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QMainWindow, QToolButton

from tests import driver
from tests.studio.tools.fakes import event
from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.io.settings import read_settings
from vomstudio.studio.tools.registry import TOOLS
from vomstudio.ui.panels.tools.line import LinePanel
from vomstudio.ui.panels.tools.trace import TracePanel
from vomstudio.ui.shell import screens
from vomstudio.ui.shell.layout import (
    GENERAL_TOOLS,
    INSPECTOR_TABS,
    PAGE_TOOLS,
    REGIONS,
    WORKSPACES,
)
from vomstudio.ui.shell.main_window import MainWindow

NAMES = [workspace.name for workspace in WORKSPACES]
SETTLE_MS = 700


def press(window, number: int) -> None:
    QTest.keyClick(window, Qt.Key(Qt.Key.Key_0 + number), driver.CTRL)
    driver.pause(50)


def docked(window) -> dict[str, QRect]:
    """Visible docks of the window, with their places in it."""
    return {
        name: QRect(dock.mapTo(window, QPoint(0, 0)), dock.size())
        for name, dock in window.docks.items()
        if not dock.isHidden() and not dock.isFloating() and not dock.visibleRegion().isEmpty()
    }


def resize(window, width: int, height: int) -> None:
    window.resize(width, height)
    driver.pause(SETTLE_MS)


def share_of_outcrop(window) -> float:
    area = window.centralWidget().available_area
    return area.width() * area.height() / (window.width() * window.height())


def move_cursor(window) -> None:
    """Put the cursor over the outcrop, and the focus into it."""
    QCursor.setPos(window.centralWidget().mapToGlobal(QPoint(50, 300)))
    window.centralWidget().setFocus()


def offered_tools(window) -> set[str]:
    return {n for n, b in window.tool_rail.buttons.items() if b.isVisible()} - {"navigate"}


# --- the tables -----------------------------------------------------------------------------
def test_every_page_has_a_region_and_a_workspace_that_offers_it(window):
    assert set(window.docks) == set(REGIONS)
    offered = {name for each in WORKSPACES for name in (*each.inspector, *each.drawer)}
    assert offered | set(INSPECTOR_TABS) | {"stereonet", "second_view"} == set(REGIONS)
    for workspace in WORKSPACES:
        assert {REGIONS[name] for name in workspace.inspector} <= {"inspector"}
        assert {REGIONS[name] for name in workspace.drawer} <= {"drawer"}
        assert workspace.purpose.endswith(".")
        assert len(workspace.purpose.split()) <= 25


def test_every_tool_is_in_the_rail_in_some_task():
    tasks = {name for each in WORKSPACES for name in each.tools}
    tasks |= {name for names in PAGE_TOOLS.values() for name in names}
    assert tasks | set(GENERAL_TOOLS) == {entry.name for entry in TOOLS}
    assert not tasks & set(GENERAL_TOOLS)


# --- the outcrop first ----------------------------------------------------------------------
@pytest.mark.parametrize(
    ("width", "height", "least"),
    first_in_default_tier([(1600, 1000, 0.70), (1280, 720, 0.60), (960, 540, 0.55)], 1),
)
def test_the_outcrop_has_most_of_the_window(window, studio, width, height, least):
    add_cliff(studio)
    add_bed(studio)
    resize(window, width, height)
    window.actions_table.run("reset_panels")
    driver.pause(100)
    assert list(docked(window)) == ["project"]
    assert window.net_overlay.isVisible()
    assert share_of_outcrop(window) >= least


# --- keys and buttons -----------------------------------------------------------------------
def test_each_key_shows_its_workspace(window):
    for number in (1, 2, 3, 2):
        press(window, number)
        assert window.workspaces.current_workspace is WORKSPACES[number - 1]
        pressed = [n for n in NAMES if window.actions_table.all[f"workspace_{n}"].isChecked()]
        assert pressed == [NAMES[number - 1]]


def test_workspace_key_works_while_editing_text(window, studio):
    add_cliff(studio)
    add_bed(studio)
    window.docks.bring_forward("table")
    field = window.table._filter
    field.setFocus()
    QTest.keyClicks(field, "dip")
    QTest.keyClick(field, Qt.Key.Key_3, driver.CTRL)
    driver.pause(50)
    assert window.workspaces.current_workspace.name == "results"
    assert field.text() == "dip"


def test_a_button_of_the_bar_shows_its_workspace(window):
    for name in ("results", "model", "interpret"):
        button = window.top_bar.workspaces[name]
        QTest.mouseClick(button, driver.LEFT)
        assert window.workspaces.current_workspace.name == name
        assert button.isChecked()


def test_switching_keeps_records_selection_and_undo_history(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1")
    add_bed(studio, "t2")
    studio.selection.set(["t1", "t2"])
    before = dict(studio.records), studio.selection.ids, studio.undo_label, studio.redo_label
    for number in range(1, 4):
        press(window, number)
    assert (
        dict(studio.records),
        studio.selection.ids,
        studio.undo_label,
        studio.redo_label,
    ) == before


# --- tools ----------------------------------------------------------------------------------
def test_task_tools_are_in_the_rail_only_during_their_task(window, studio):
    add_cliff(studio)
    press(window, 2)
    assert offered_tools(window) == set(GENERAL_TOOLS)
    press(window, 1)
    assert offered_tools(window) == {*GENERAL_TOOLS, "control", "known_line"}
    press(window, 2)
    window.docks.bring_forward("looked_at")
    driver.pause(30)
    assert offered_tools(window) == {*GENERAL_TOOLS, "cells"}
    window.docks.bring_forward("bed_log")
    driver.pause(30)
    assert offered_tools(window) == {*GENERAL_TOOLS, "contact", "lithology"}
    window.docks.close_page("bed_log")
    studio.activate("cells")
    driver.pause(30)
    assert offered_tools(window) == {*GENERAL_TOOLS, "cells"}, "the active tool is always there"
    studio.activate("navigate")
    driver.pause(30)
    assert offered_tools(window) == set(GENERAL_TOOLS)


@pytest.mark.parametrize("height", [540, 720])
def test_the_rail_shows_all_tools_of_a_task_in_a_low_window(window, studio, height):
    add_cliff(studio)
    press(window, 1)
    buttons = window.tool_rail.buttons.values()
    resize(window, 960, 1000)
    (below_icon,) = {button.height() - button.iconSize().height() for button in buttons}
    resize(window, 960, height)
    assert offered_tools(window) == {*GENERAL_TOOLS, "control", "known_line"}
    for button in buttons:
        if button.isVisible():
            assert button.visibleRegion().boundingRect().size() == button.size()
            # The text has as much room as in a high window.
            assert button.height() - button.iconSize().height() >= below_icon


# --- inspector ------------------------------------------------------------------------------
def test_inspector_follows_the_tool_and_the_selection(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1")
    move_cursor(window)
    page = window.docks.page
    assert page("inspector") == "project"
    studio.selection.set(["t1"])
    assert page("inspector") == "properties"
    studio.activate("trace")
    assert page("inspector") == "tool"
    studio.selection.set([])
    assert page("inspector") == "tool", "a tool keeps its settings in sight"
    studio.activate("navigate")
    assert page("inspector") == "project"
    studio.selection.set(["t1"])
    studio.selection.set([])
    assert page("inspector") == "project"


def test_inspector_does_not_switch_while_the_user_works_in_it(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1")
    QCursor.setPos(window.docks["project"].mapToGlobal(QPoint(40, 200)))
    studio.selection.set(["t1"])
    assert window.docks.page("inspector") == "project"
    window.docks.bring_forward("display")
    move_cursor(window)
    studio.selection.set([])
    assert window.docks.page("inspector") == "display", "the user has opened it"


def test_a_tab_of_the_inspector_shows_its_page(window):
    for name in ("properties", "tool", "project"):
        title = window.docks[window.docks.page("inspector")].titleBarWidget()
        QTest.mouseClick(title.findChild(QToolButton, f"tab_{name}"), driver.LEFT)
        assert window.docks.page("inspector") == name
        assert len(docked(window)) == 1


# --- drawer ---------------------------------------------------------------------------------
def test_the_drawer_shows_one_page_at_a_time_and_closes(window):
    for name in ("table", "statistics"):
        QTest.mouseClick(window.drawer_bar.buttons[name], driver.LEFT)
        driver.pause(50)
        assert window.docks.page("drawer") == name
        assert {n for n in docked(window) if REGIONS[n] == "drawer"} == {name}
    pressed = [n for n, b in window.drawer_bar.buttons.items() if b.isChecked()]
    assert pressed == ["statistics"]
    QTest.mouseClick(window.drawer_bar.buttons["statistics"], driver.LEFT)
    driver.pause(50)
    assert window.docks.page("drawer") == ""
    assert not window.drawer_bar.buttons["statistics"].isChecked()


def test_page_from_another_workspace_has_a_button_while_open(window):
    press(window, 2)
    assert not window.drawer_bar.buttons["jobs"].isVisible()
    window.docks.bring_forward("jobs")
    driver.pause(30)
    assert window.drawer_bar.buttons["jobs"].isVisible()
    window.docks.close_page("jobs")
    driver.pause(30)
    assert not window.drawer_bar.buttons["jobs"].isVisible()


@pytest.mark.full
def test_every_page_can_be_shown_in_every_workspace(window, studio):
    add_cliff(studio)
    resize(window, 1400, 900)
    for number in range(1, 4):
        press(window, number)
        for name in window.docks:
            window.docks.bring_forward(name)
            driver.pause(30)
            assert window.docks.is_shown(name), (NAMES[number - 1], name)
            regions = [REGIONS[page] for page in docked(window)]
            assert len(regions) == len(set(regions))


# --- the centre -----------------------------------------------------------------------------
@pytest.mark.parametrize("name", ["table", "stereonet", "properties"])
def test_page_can_be_moved_to_the_centre_and_back(window, studio, name):
    add_cliff(studio)
    window.docks.bring_forward(name)
    driver.pause(100)
    page = window.docks[name].widget() or window.net_overlay._widget
    before, size = docked(window), page.size()
    window.docks.toggle_center(name)
    driver.pause(100)
    assert window.docks.center_page == name
    assert not window.centralWidget().shows_outcrop
    assert page.isVisible()
    assert page.width() > 0.5 * window.width()
    assert page.height() > 0.4 * window.height()
    QTest.keyClick(window, Qt.Key.Key_F12)
    driver.pause(100)
    assert window.docks.center_page == ""
    assert window.centralWidget().shows_outcrop
    assert docked(window) == before
    assert page.isVisible()
    assert page.size() == size


def test_f12_enlarges_the_focused_page(window, studio):
    add_cliff(studio)
    window.docks.bring_forward("table")
    window.table._filter.setFocus()
    QTest.keyClick(window.table._filter, Qt.Key.Key_F12)
    assert window.docks.center_page == "table"
    QTest.keyClick(window, Qt.Key.Key_F12)
    window.docks.close_page("table")
    move_cursor(window)
    QTest.keyClick(window, Qt.Key.Key_F12)
    assert window.docks.center_page == "stereonet"


def test_net_can_be_docked_and_undocked(window, studio):
    add_cliff(studio)
    run = window.actions_table.run
    run("dock_net")
    driver.pause(100)
    assert window.net_overlay.isHidden()
    assert "stereonet" in docked(window)
    assert "project" in docked(window), "the inspector stays"
    run("dock_net")
    driver.pause(100)
    assert window.net_overlay.isVisible()
    assert "stereonet" not in docked(window)


def test_the_net_keeps_its_corner_when_the_window_is_resized(window, studio):
    add_cliff(studio)
    overlay, room = window.net_overlay, window.centralWidget()
    for size in ((1400, 900), (1000, 600), (1500, 950)):
        resize(window, *size)
        box = overlay.geometry()
        assert room.rect().contains(box)
        assert room.width() - box.right() - 1 == 10
        assert box.y() == 56
    start = QPoint(overlay.width() // 2, 3)
    QTest.mousePress(overlay, driver.LEFT, pos=start)
    QTest.mouseMove(overlay, start + QPoint(-600, 300))
    QTest.mouseRelease(overlay, driver.LEFT, pos=start + QPoint(-600, 300))
    place, text = overlay.geometry(), overlay.state()
    assert room.rect().contains(place)
    assert place.x() < 900
    overlay.reset()
    assert overlay.geometry() != place
    overlay.restore(text)
    assert overlay.geometry() == place
    for damaged in ("", "tr", "tr 1 2", "xx 1 2 3", "tr a b c", "tr -1 2 3"):
        overlay.restore(damaged)
        assert overlay.geometry() == place


# --- what is opened -------------------------------------------------------------------------
def test_photos_take_the_centre_while_no_model_is_open(window, tmp_path):
    (tmp_path / "photos").mkdir()
    window.open_path(tmp_path / "photos")
    driver.pause(100)
    assert window.workspaces.current_workspace.name == "model"
    assert window.docks.center_page == "photos"
    assert window.photos_panel.width() >= 0.6 * window.width()
    assert window.photos_panel.height() >= 0.7 * window.height()


def test_message_is_visible_while_photos_are_in_the_centre(window, studio, tmp_path):
    (tmp_path / "photos").mkdir()
    window.open_path(tmp_path / "photos")
    message = "The disk is full."
    studio.warn(message, "error")
    driver.pause(50)
    bar = window.message_bar
    assert bar.text == message
    assert bar.visibleRegion().boundingRect().height() >= bar.sizeHint().height()


def test_message_and_net_do_not_overlap(window, studio):
    add_cliff(studio)
    net, bar = window.net_overlay, window.message_bar
    resize(window, 1280, 720)
    place = net.geometry()
    studio.warn("The disk is full.", "error")
    driver.pause(50)
    assert bar.isVisible()
    assert not net.geometry().intersects(bar.geometry())
    assert net.geometry() == place, "the net does not jump"


def test_photos_open_in_the_drawer_while_a_model_is_open(window, studio, tmp_path):
    add_cliff(studio)
    (tmp_path / "photos").mkdir()
    window.open_path(tmp_path / "photos")
    driver.pause(100)
    assert window.docks.page("drawer") == "photos"
    assert window.centralWidget().shows_outcrop
    assert window.centralWidget().height() > 0.4 * window.height()


def test_opening_a_model_switches_workspace_only_from_photos(window, tmp_path):
    (tmp_path / "photos").mkdir()
    window.open_path(tmp_path / "photos")
    window.open_path(tmp_path / "missing.obj")
    assert window.workspaces.current_workspace.name == "interpret"
    assert window.docks.center_page == ""
    press(window, 3)
    window.open_path(tmp_path / "missing.obj")
    assert window.workspaces.current_workspace.name == "results"


def test_a_workspace_states_its_purpose_until_it_has_something_to_show(window, studio):
    def purpose() -> str:
        label = window.findChild(QLabel, "workspace_purpose")
        return "" if label.isHidden() else label.text()

    for number, workspace in enumerate(WORKSPACES, start=1):
        press(window, number)
        assert purpose() == workspace.purpose
    add_cliff(studio)
    assert purpose() == WORKSPACES[2].purpose, "features are needed there"
    label, net = window.findChild(QLabel, "workspace_purpose"), window.net_overlay
    assert net.isVisible()
    assert net.mapToGlobal(QPoint()).y() > label.mapToGlobal(label.rect().bottomLeft()).y()
    press(window, 2)
    assert purpose() == ""
    add_bed(studio)
    press(window, 3)
    assert purpose() == ""


# --- remembering ----------------------------------------------------------------------------
def test_workspaces_keep_their_pages_and_share_sizes(window):
    resize(window, 1400, 900)
    press(window, 2)
    window.docks.bring_forward("table")
    window.docks.bring_forward("display")
    window.resizeDocks([window.docks["display"]], [370], Qt.Orientation.Horizontal)
    driver.pause(50)
    width = window.docks["display"].width()
    assert width > 340
    press(window, 3)
    assert list(docked(window)) == ["project"]
    assert window.docks["project"].width() == width
    window.docks.bring_forward("statistics")
    press(window, 2)
    assert set(docked(window)) == {"table", "display"}
    press(window, 3)
    assert set(docked(window)) == {"statistics", "project"}


def test_reset_restores_the_default_layout(window):
    resize(window, 1400, 900)
    press(window, 2)
    first = docked(window)
    window.docks.bring_forward("table")
    window.docks["properties"].show()
    window.docks["properties"].setFloating(True)
    window.docks.close_page("stereonet")
    window.resizeDocks([window.docks["project"]], [400], Qt.Orientation.Horizontal)
    driver.pause(50)
    window.actions_table.run("reset_panels")
    driver.pause(100)
    assert docked(window) == first
    assert not window.docks["properties"].isFloating()
    assert window.docks.is_shown("stereonet")


def test_hidden_panels_reappear_with_a_workspace_key(window):
    window.docks.bring_forward("table")
    before = set(docked(window))
    QTest.keyClick(window, Qt.Key.Key_F9)
    assert docked(window) == {}
    assert not window.docks.is_shown("stereonet")
    press(window, 2)
    driver.pause(50)
    assert set(docked(window)) == before
    assert window.docks.is_shown("stereonet")
    QTest.keyClick(window, Qt.Key.Key_F9)
    press(window, 3)
    assert list(docked(window)) == ["project"]


def test_layout_is_restored_after_a_crash(window):
    """The first window is not closed: the second finds what was stored before."""
    resize(window, 1300, 850)
    press(window, 3)
    window.docks.bring_forward("sets")
    window.docks.close_page("stereonet")
    driver.pause(SETTLE_MS)
    driver.wait(lambda: read_settings()[0].window.get("workspace") == "results", "the settings")
    second = MainWindow(read_settings()[0])
    second.show()
    second._fill()
    second.studio.jobs.close()
    driver.pause(100)
    assert (second.width(), second.height()) == (1300, 850)
    assert second.workspaces.current_workspace.name == "results"
    assert set(docked(second)) == {"project", "sets"}
    assert not second.docks.is_shown("stereonet")
    second.activateWindow()
    driver.wait(lambda: QApplication.activeWindow() is second, "the second window")
    press(second, 2)
    assert list(docked(second)) == ["project"]
    driver.dismiss(second)


@pytest.mark.parametrize(
    "text", first_in_default_tier(["", "AAAA", "not base64 \N{SNOWMAN}", "////"])
)
def test_damaged_layouts_are_ignored(own_folders, qtbot, text):
    settings = read_settings()[0]
    keys = ("geometry", "docks", "pages interpret", "workspace", "net", "net place")
    settings.window = dict.fromkeys(keys, text)
    window = MainWindow(settings)
    window.show()
    window._fill()
    window.studio.jobs.close()
    driver.pause(50)
    assert window.workspaces.current_workspace.name == "interpret"
    assert window.docks.page("inspector") == "project"
    driver.dismiss(window)


# --- screens --------------------------------------------------------------------------------
def test_window_returns_from_a_disconnected_screen(qtbot):
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


def test_window_is_shrunk_to_fit_a_smaller_screen(window):
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


def test_floating_dock_returns_from_a_disconnected_screen(window):
    dock = window.docks["display"]
    dock.show()
    dock.setFloating(True)
    dock.move(9000, 7000)
    driver.pause(50)
    press(window, 1)
    press(window, 2)
    assert dock.isFloating()
    screen = QGuiApplication.primaryScreen().availableGeometry()
    assert screen.contains(dock.geometry().topLeft() + QPoint(60, 10))


@pytest.mark.parametrize(
    ("width", "height"),
    first_in_default_tier([(960, 508), (1100, 620), (1280, 688), (1920, 1040)], 1),
)
def test_pages_are_complete_and_the_outcrop_is_large_in_any_window(window, studio, width, height):
    add_cliff(studio)
    add_bed(studio)
    window.setMinimumSize(1, 1)
    resize(window, width, height)
    for workspace in WORKSPACES:
        window.workspaces.switch(workspace.name)
        for name in (*INSPECTOR_TABS, *workspace.inspector, *workspace.drawer):
            window.docks.bring_forward(name)
            driver.pause(30)
            needed = window.minimumSizeHint()
            assert needed.width() <= 960, (workspace.name, name)
            assert needed.height() <= height, (workspace.name, name)
            inside = QRect(QPoint(0, 0), window.size())
            for page, place in docked(window).items():
                assert inside.contains(place), (workspace.name, page)
                least = window.docks[page].minimumSizeHint()
                assert place.width() >= least.width(), (workspace.name, page)
            assert window.centralWidget().width() >= 0.55 * width, (workspace.name, name)
            assert window.centralWidget().height() >= 150, (workspace.name, name)


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
for name in ("model", "interpret", "results"):
    window.workspaces.switch(name)
    for _ in range(30): application.processEvents()
    print(window.minimumSizeHint().width(), window.minimumSizeHint().height())
window.studio.jobs.close()
import os, sys; sys.stdout.flush(); os._exit(0)
"""


@pytest.mark.full
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
    assert len(needed) == 3
    for least_width, least_height in needed:
        assert least_width <= width
        assert least_height <= height


# --- the panel of the active tool -----------------------------------------------------------
def test_tool_dock_follows_the_active_tool(window, studio):
    add_cliff(studio)
    dock, panel = window.docks["tool"], window.tool_panel
    assert not {entry.name for entry in TOOLS} & set(window.docks)
    assert dock.windowTitle() == "Tool"
    widgets = {}
    for entry in TOOLS:
        studio.activate(entry.name)
        assert dock.windowTitle() == entry.title
        widgets[entry.name] = panel.currentWidget()
        assert panel.currentWidget() is panel.panels[entry.name]
    # Known lines place a model together with control points, and stand in their panel.
    assert widgets.pop("known_line") is widgets["control"]
    assert len({id(widget) for widget in widgets.values()}) == len(TOOLS) - 1
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


def test_selecting_a_tool_shows_its_settings_in_any_workspace(window, studio):
    add_cliff(studio)
    for number in (1, 2, 3):
        press(window, number)
        studio.activate("navigate")
        studio.activate("trace")
        driver.pause(50)
        assert window.workspaces.current_workspace.name == NAMES[number - 1]
        assert window.docks.page("inspector") == "tool"
        assert driver.tool_panel(window, TracePanel).isVisible()


def test_selecting_a_tool_returns_the_centre_to_the_outcrop(window, studio):
    add_cliff(studio)
    window.docks.move_to_center("table")
    studio.activate("trace")
    driver.pause(50)
    assert window.centralWidget().shows_outcrop


def test_workspace_keys_work_in_a_floating_page(window):
    dock = window.docks["table"]
    dock.show()
    dock.setFloating(True)
    dock.activateWindow()
    driver.wait(lambda: QApplication.activeWindow() is dock, "the floating page", 5.0)
    window.table._filter.setFocus()
    QTest.keyClick(window.table._filter, Qt.Key.Key_3, driver.CTRL)
    driver.pause(50)
    assert window.workspaces.current_workspace.name == "results"
    assert dock.isFloating(), "what the user arranged stays"


def test_layout_that_lacks_a_new_panel_is_not_restored(qtbot):
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


@pytest.mark.parametrize("width", first_in_default_tier([1280, 1100, 960]))
def test_all_buttons_of_the_bars_are_visible_when_the_window_becomes_narrower(
    window, studio, width
) -> None:
    add_cliff(studio)
    resize(window, 1600, 900)
    resize(window, width, 720)
    for number in (1, 2, 3):
        press(window, number)
        buttons = [*window.tool_rail.buttons.values(), *window.drawer_bar.buttons.values()]
        buttons += window.top_bar.findChildren(QToolButton)
        named = {button.defaultAction() for button in buttons}
        assert {window.actions_table.all[name] for name in ("undo", "redo", "home")} <= named
        for button in buttons:
            if button.isVisible():
                whole = button.visibleRegion().boundingRect().size()
                assert whole == button.size(), button.text()
        menus = window.menuBar().actions()
        last = window.menuBar().actionGeometry(menus[-1])
        assert not last.isEmpty()
        assert last.right() < window.top_bar.x()
        assert window.menuBar().width() - window.top_bar.geometry().right() < 8
