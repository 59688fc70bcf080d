"""One window for all tests of a module: a new one costs two seconds, a new project 0.1."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from copy import deepcopy
from dataclasses import fields
from functools import partial
from pathlib import Path

import shiboken6
from PySide6.QtCore import QPoint
from PySide6.QtGui import QCursor, QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QApplication,
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QLineEdit,
    QMenu,
    QRadioButton,
    QSpinBox,
    QWidget,
)

from tests import driver, guards
from tests.driver import wait
from vomstudio.io.settings import Settings
from vomstudio.studio.tools.element_tool import ElementTool
from vomstudio.studio.tools.select import SelectTool
from vomstudio.ui.panels.photos.reconstruction_settings import ReconstructionSettings
from vomstudio.ui.shell import screens
from vomstudio.ui.shell.layout import DEFAULT_WORKSPACE
from vomstudio.ui.shell.main_window import MainWindow
from vomstudio.ui.shell.tour import Tour
from vomstudio.ui.widgets.group_box import GroupBox
from vomstudio.ui.widgets.type_box import TypeBox


class PanelDefaults:
    """Values that the fields of the tools have when they are made. The program keeps what was
    typed into them for the next project, a new user has not typed anything."""

    def __init__(self, window: MainWindow) -> None:
        self._restore: list[tuple[QWidget, Callable[[], None]]] = []
        self._modes: list[Callable[[], None]] = []
        self._note(window.tool_panel)
        for tool in window.studio.workspace.tools.tools.values():
            if isinstance(tool, ElementTool):
                self._note_modes(tool)

    def _note(self, panel: QWidget) -> None:
        for field in panel.findChildren(QWidget):
            if isinstance(field, QSpinBox | QDoubleSpinBox):
                self._restore.append((field, partial(field.setValue, field.value())))
            elif isinstance(field, GroupBox):
                # An empty one chooses as in a new panel.
                self._restore.append((field, field.clear))
            elif isinstance(field, QComboBox) and not isinstance(field, TypeBox):
                self._restore.append((field, partial(_choose, field, field.currentText())))
            elif isinstance(field, QCheckBox | QRadioButton):
                self._restore.append((field, partial(_check, field, field.isChecked())))
            elif isinstance(field, QLineEdit) and not isinstance(
                field.parent(), QSpinBox | QDoubleSpinBox | QComboBox
            ):
                self._restore.append((field, partial(_write, field, field.text())))

    def _note_modes(self, tool: ElementTool) -> None:
        """Remember the settings that the buttons of a tool change: shape, combination, target."""
        self._modes += [
            partial(tool.set_mode, tool.mode),
            partial(tool.set_combine, tool.combine),
            partial(tool.set_select_through, tool.is_through),
        ]
        if isinstance(tool, SelectTool):
            self._modes.append(partial(tool.set_target, tool.target))

    def restore(self) -> None:
        for field, restore in self._restore:
            if shiboken6.isValid(field):
                restore()
        for restore in self._modes:
            restore()


def _choose(box: QComboBox, text: str) -> None:
    """Choose an item as a user does: the one of the start, the first in a box that was empty then.
    One that belonged to a project is not there any more."""
    index = box.findText(text) if text else 0
    if 0 <= index < box.count() and index != box.currentIndex():
        box.setCurrentIndex(index)
        box.activated.emit(index)


def _check(box: QCheckBox | QRadioButton, checked: bool) -> None:
    if box.isChecked() == checked:
        return
    if checked or isinstance(box, QCheckBox):
        box.click()
    if box.isChecked() != checked:
        box.setChecked(checked)


def _write(field: QLineEdit, text: str) -> None:
    if field.text() != text:
        field.setText(text)
        field.setModified(False)


class SharedWindow:
    """The window that the tests of a module share. Each test gets it as a new user would."""

    def __init__(self, home: Path) -> None:
        """home : folder of the user of this window, see `own_folders`"""
        self._home = home
        self._window: MainWindow | None = None
        self._camera: dict[str, object] = {}
        self._last = ""

    def lend(self, test: str) -> MainWindow:
        """Return the window for a test, reset after the previous one."""
        if self._window is None or not shiboken6.isValid(self._window):
            self._make()
        else:
            try:
                reset(self._window, self._home, self._camera, self._defaults)
            except BaseException as error:
                error.add_note(f"The window was last used by {self._last}.")
                self.close(check=False)
                raise
        self._last = test
        assert self._window is not None
        return self._window

    def _make(self) -> None:
        # A failed test has left files and settings.
        shutil.rmtree(self._home)
        self._home.mkdir()
        guards.begin_sharing()
        try:
            self._window = driver.make_window()
        except BaseException:
            guards.end_sharing(check=False)
            raise
        assert self._window.viewport is not None
        self._camera = self._window.viewport.moves.camera_state()
        self._defaults = PanelDefaults(self._window)

    def close(self, *, check: bool = True) -> list[str]:
        """Close the window for good and return what it leaves in memory."""
        if self._window is None:
            return []
        window, self._window = self._window, None
        del self._defaults
        driver.dismiss(window)
        del window
        return guards.end_sharing(check=check)


def reset(
    window: MainWindow, home: Path, camera: dict[str, object], defaults: PanelDefaults
) -> None:
    """Give the window the state that a new user finds, as far as possible by its own commands."""
    _finish_work(window)
    _close_dialogs(window)
    window.actions_table.run("new")
    defaults.restore()
    # A choice in the panel of a tool may have begun to use it.
    window.actions_table.run("navigate")
    _forget_user(window, home)
    _arrange(window)
    assert window.viewport is not None
    window.viewport.moves.set_camera_state(camera)
    assert_unused(window)
    driver.focus(window)


def assert_unused(window: MainWindow) -> None:
    """Assert that no data, job or dialog of an earlier project is left."""
    studio = window.studio
    assert studio.project.is_untitled
    assert not studio.session.dirty
    assert not studio.session.features()
    assert not studio.models
    assert not studio.selection.ids
    assert studio.open_tool is None
    assert studio.tool is None
    assert studio.undo_label is None
    assert studio.redo_label is None
    assert not studio.jobs.visible()
    assert window.survey.folder is None
    assert window.photo_opening.page is None
    assert not _other_windows(window)
    assert window.start_page.isVisible()


def _finish_work(window: MainWindow) -> None:
    """Discard whatever is unfinished or unsaved, and stop running jobs."""
    studio = window.studio
    _release_mouse(window)
    if (tour := window.findChild(Tour)) is not None:
        tour.end()
    if window.photo_opening.page is not None:
        assert window.photo_opening.may_close()
    studio.cancel_tool()
    if studio.project.session.dirty:
        studio.project.session.discard_unsaved()
    if studio.project.is_untitled:
        # Otherwise the window asks whether to keep it.
        shutil.rmtree(studio.project.folder / "reconstruction", ignore_errors=True)
    for job in list(studio.jobs.jobs.values()):
        if not job.is_quiet:
            studio.jobs.cancel(job)
    wait(lambda: not studio.jobs.visible(), "the end of all jobs")


def _release_mouse(window: MainWindow) -> None:
    """Release a button that a test left pressed: `QTest.mouseDClick` sends no release."""
    assert window.viewport is not None
    gestures = window.viewport.gestures
    if gestures._press_position is not None:
        QTest.mouseRelease(
            window.viewport, gestures._button, pos=gestures._press_position.toPoint()
        )


def _close_dialogs(window: MainWindow) -> None:
    while (popup := QApplication.activePopupWidget()) is not None:
        popup.close()
    assert QApplication.activeModalWidget() is None
    for other in _other_windows(window):
        assert other.close(), f"{other} does not close"
    driver.pause(0)


def _other_windows(window: MainWindow) -> list[object]:
    docks = set(window.docks.values())
    return [
        widget
        for widget in QApplication.topLevelWidgets()
        if widget is not window
        and widget.isVisible()
        and widget not in docks
        and not isinstance(widget, QMenu)
    ]


def _forget_user(window: MainWindow, home: Path) -> None:
    """Forget settings, files and messages of the previous test."""
    studio = window.studio
    settings, new = studio.settings, Settings()
    for each in fields(settings):
        setattr(settings, each.name, deepcopy(getattr(new, each.name)))
    window.view.set_turntable(settings.turntable)
    studio.keep_settings()
    window.survey.apply_settings(ReconstructionSettings())
    QGuiApplication.clipboard().clear()
    current = studio.project.folder
    for folder in current.parent.iterdir():
        if folder != current and folder.is_dir():
            shutil.rmtree(folder)
    (home / "settings.toml").unlink(missing_ok=True)
    driver.pause(0)


def _arrange(window: MainWindow) -> None:
    """Give window and docks the places of a first start."""
    workspaces = window.workspaces
    screens.set_default_size(window)
    window.move(0, 0)
    for name in workspaces._pages:
        workspaces._pages[name] = {"inspector": "project", "drawer": ""}
    workspaces.switch(DEFAULT_WORKSPACE)
    window.net_overlay.reset()
    # The command docks it again but leaves it open.
    window.docks.close_page("second_view")
    window.actions_table.run("reset_panels")
    QCursor.setPos(QPoint(0, 0))
    driver.pause(0)
