"""A person at the window: real mouse and key events, and waiting for what they bring about."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import numpy as np
import shiboken6
from PySide6.QtCore import QCoreApplication, QEvent, QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QDragEnterEvent, QDropEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractSpinBox, QApplication, QMessageBox, QPushButton, QWidget

from vomstudio.io.settings import read_settings
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import Model
from vomstudio.studio.running_jobs import Jobs
from vomstudio.ui.base import theme
from vomstudio.ui.shell.main_window import MainWindow

LEFT = Qt.MouseButton.LeftButton
NONE = Qt.KeyboardModifier.NoModifier
CTRL = Qt.KeyboardModifier.ControlModifier
CRS = "EPSG:32633"
Panel = TypeVar("Panel", bound=QWidget)


def is_seen(widget: QWidget) -> bool:
    """Return whether a part of a widget or of its children is not covered."""
    every = (widget, *widget.findChildren(QWidget))
    return any(not each.visibleRegion().isEmpty() for each in every)


def wait(until: Callable[[], object], what: str = "", seconds: float = 30.0) -> None:
    """Let the window work until something is so."""
    end = time.monotonic() + seconds
    while not until():
        if time.monotonic() > end:
            raise AssertionError(f"did not come about in {seconds:g} s: {what or until}")
        pause(5)


def pause(milliseconds: int = 30) -> None:
    """Let the window work for a while. Its threads work, too: QTest.qWait keeps Python's lock."""
    end = time.monotonic() + milliseconds / 1e3
    while True:
        QApplication.processEvents()
        QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
        left = end - time.monotonic()
        if left <= 0.0:
            return
        time.sleep(min(left, 0.005))


def make_window(paths: list[Path] | None = None) -> MainWindow:
    """The window as `vomstudio.ui.shell.window_start` makes it, with everything there."""
    settings, problems = read_settings()
    theme.use(settings.theme)
    window = MainWindow(settings)
    window.show()
    QTest.qWaitForWindowExposed(window)
    window.begin([Path(p) for p in paths or []])
    for problem in problems:
        window.studio.warn(problem.message)
    window.prepare_for_models()
    wait(lambda: hasattr(window, "net"), "the net")
    focus(window)
    return window


def page(window: MainWindow, name: str) -> QWidget:
    """The widget of a page, in its dock or over the outcrop."""
    return window.net if name == "stereonet" else window.docks[name].widget()


def focus(window: MainWindow) -> None:
    """Without a window manager nobody else gives the window the keyboard."""
    window.activateWindow()
    wait(lambda: QApplication.activeWindow() is not None, "an active window", 5.0)
    assert window.viewport is not None
    if window.viewport.isHidden():
        # Photos stand in its place.
        return
    window.viewport.setFocus()
    wait(window.viewport.hasFocus, "the viewport's focus", 5.0)


def dismiss(window: MainWindow) -> None:
    """Close for good, whatever is open, keeping nothing; a test may have done so itself."""
    if not shiboken6.isValid(window):
        return
    studio = window.studio
    if studio.project.session.dirty:
        studio.project.session.discard_unsaved()
    studio.cancel_tool()
    if studio.project.is_untitled:
        # Or it would ask what to do with hours of work.
        shutil.rmtree(studio.project.folder / "reconstruction", ignore_errors=True)
    window.close()
    QApplication.processEvents()
    delete(window)


def tool_panel(window: MainWindow, kind: type[Panel]) -> Panel:
    """The panel of a tool, by its class."""
    return window.tool_panel.panel(kind)


def close(window: QWidget) -> None:
    """Close, which must not be refused, and have nothing of the window stay."""
    assert window.close()
    delete(window)


def delete(window: QWidget) -> None:
    """As the end of the process does: what is connected to its parts holds a window for ever."""
    window.deleteLater()
    QCoreApplication.sendPostedEvents(window, QEvent.Type.DeferredDelete)


# --- models ----------------------------------------------------------------------------------
def declare(window: MainWindow, crs: str = CRS) -> None:
    """Type the CRS into the dialog that asks for it."""
    wait(lambda: dialog_of(window) is not None, "the frame dialog")
    dialog = dialog_of(window)
    field = dialog._crs
    dialog._crs_button.click()
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, crs)
    QTest.keyClick(field, Qt.Key.Key_Return)
    wait(lambda: dialog_of(window) is None, "the end of the frame dialog")
    focus(window)


def dialog_of(window: MainWindow):
    from vomstudio.ui.dialogs.frame_dialog import FrameDialog

    # Not among all that the window is made of, which takes as long as waiting does.
    shown = [d for d in QApplication.topLevelWidgets() if isinstance(d, FrameDialog)]
    return next((d for d in shown if d.isVisible() and d.parent() is window), None)


def open_outcrop(window: MainWindow, path: Path) -> str:
    """Open a model without a frame and declare it; its id."""
    window.open_path(path)
    declare(window)
    return settled(window)


def settled(window: MainWindow) -> str:
    """Wait until the model is drawn and can be picked."""
    viewport = window.viewport
    wait(lambda: window.studio.models, "the model's data")
    model_id = next(iter(window.studio.models))
    wait(lambda: "complete" in viewport.models.reached_stages(model_id), "the drawn model")
    wait(lambda: viewport.is_still, "the camera's rest")
    return model_id


# --- mouse -----------------------------------------------------------------------------------
def pixel(window: MainWindow, point: np.ndarray) -> QPoint:
    """Where a World point is on the viewport; it must be in sight."""
    pixels, _ = window.viewport.project(np.asarray(point, float)[None])
    assert np.isfinite(pixels).all(), "the point is behind the viewer"
    return QPoint(round(float(pixels[0, 0])), round(float(pixels[0, 1])))


def move(widget: QWidget, at: QPoint) -> None:
    QTest.mouseMove(widget, at)
    pause(25)


def click(widget: QWidget, at: QPoint, modifier: Qt.KeyboardModifier = NONE) -> None:
    QTest.mouseMove(widget, at)
    QTest.mouseClick(widget, LEFT, modifier, at)
    # Two clicks of one place within the system's interval would be a double click.
    QTest.qWait(1)


def drag(
    widget: QWidget,
    start: QPoint,
    end: QPoint,
    button: Qt.MouseButton = LEFT,
    modifier: Qt.KeyboardModifier = NONE,
    *,
    release: bool = True,
) -> None:
    from PySide6.QtCore import QEvent
    from PySide6.QtGui import QMouseEvent

    def send(kind: QEvent.Type, at: QPoint, held: Qt.MouseButton) -> None:
        changed = Qt.MouseButton.NoButton if kind == QEvent.Type.MouseMove else button
        where = QPointF(at)
        event = QMouseEvent(kind, where, QPointF(widget.mapToGlobal(at)), changed, held, modifier)
        QApplication.sendEvent(widget, event)

    send(QEvent.Type.MouseButtonPress, start, button)
    for step in range(1, 6):
        at = start + (end - start) * step / 5
        send(QEvent.Type.MouseMove, at, button)
        QApplication.processEvents()
    if release:
        send(QEvent.Type.MouseButtonRelease, end, Qt.MouseButton.NoButton)
    pause(5)


def key(window: MainWindow, code: Qt.Key, modifier: Qt.KeyboardModifier = NONE) -> None:
    """A key for whatever has the focus, as the keyboard would send it."""
    target = QApplication.focusWidget() or window
    QTest.keyClick(target, code, modifier)
    pause(5)


def pick(window: MainWindow, points: np.ndarray, modifier: Qt.KeyboardModifier = NONE) -> None:
    """Click World points on the outcrop, one after the other."""
    for point in points:
        click(window.viewport, pixel(window, point), modifier)


def look_at(window: MainWindow, points: np.ndarray, trend: float, plunge: float = 0.0) -> None:
    """Stand before some points and wait for the picture."""
    window.viewport.moves.look_along(trend, plunge)
    window.viewport.moves.frame(points)
    viewport = window.viewport
    wait(lambda: viewport.is_still, "the camera's rest")


# --- files -----------------------------------------------------------------------------------
def drop(window: MainWindow, paths: list[Path]) -> None:
    """Drag files onto the window and let them go."""
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path)) for path in paths])
    copy = Qt.DropAction.CopyAction
    enter = QDragEnterEvent(QPoint(400, 300), copy, data, LEFT, NONE)
    QApplication.sendEvent(window, enter)
    assert enter.isAccepted()
    QApplication.sendEvent(window, QDropEvent(QPointF(400, 300), copy, data, LEFT, NONE))


def begin_reading(window: MainWindow, folder: Path) -> Jobs:
    """Open a file that takes long to be read; the jobs, of which the reading is one."""
    path = folder / "big.obj"
    path.write_bytes(b"v 1.5 2.5 3.5\n" * 300_000)
    window.open_path(path)
    jobs = window.studio.jobs
    wait(lambda: jobs.visible() and jobs.visible()[0].stage, "the reading")
    return jobs


# --- boxes -----------------------------------------------------------------------------------
def answer(button: QMessageBox.StandardButton, seen: list[str]) -> None:
    """Click a button of the next message box for real, and note what it says."""
    from PySide6.QtCore import QTimer

    tries = 0

    def look() -> None:
        nonlocal tries
        tries += 1
        box = QApplication.activeModalWidget()
        if isinstance(box, QMessageBox):
            seen.append(box.text())
            target = box.button(button)
            assert isinstance(target, QPushButton)
            QTest.mouseClick(target, LEFT, NONE, target.rect().center())
        elif tries < 400:
            QTimer.singleShot(25, look)

    QTimer.singleShot(25, look)


def traces(window: MainWindow) -> list[Trace]:
    return window.studio.session.of(Trace)


def model(window: MainWindow) -> Model:
    return window.studio.session.of(Model)[0]


def type_number(field: QWidget, text: str) -> None:
    """Replace the number in a field and press Enter."""
    assert isinstance(field, QAbstractSpinBox)
    field.selectAll()
    QTest.keyClicks(field, text)
    QTest.keyClick(field, Qt.Key.Key_Return)


def keep_picture(window: QWidget, name: str) -> None:
    """VOMSTUDIO_PICTURES names a folder for pictures of the window, for people to look at."""
    if folder := os.environ.get("VOMSTUDIO_PICTURES"):
        Path(folder).mkdir(parents=True, exist_ok=True)
        window.grab().save(str(Path(folder) / f"{name}.png"))
