"""Something of the program fails while its window, a page or a dialog is being closed: it is said,
the rest is closed all the same, and the work is there when the program starts again."""

from __future__ import annotations

import contextlib
import threading

import pytest
import shiboken6
from PySide6.QtCore import Qt, QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QMessageBox

from tests import driver
from tests.driver import CTRL, LEFT, wait
from vomstudio.core.failures.error_collector import ERRORS
from vomstudio.project.folder import is_free, untitled_projects
from vomstudio.ui.dialogs.planner.planner_dialog import PlannerDialog

pytestmark = [pytest.mark.expects_log, pytest.mark.full]
WORDS = "the disk does not answer"


def fail(*_: object) -> None:
    raise RuntimeError(WORDS)


class Answers(QTimer):
    """Presses a button of each message that comes, in turn; `said` is what they said."""

    def __init__(self, *buttons: str) -> None:
        super().__init__()
        self.said: list[str] = []
        self._buttons = list(buttons)
        self.timeout.connect(self._look)
        self.start(20)

    def _look(self) -> None:
        box = QApplication.activeModalWidget()
        if not isinstance(box, QMessageBox) or not box.isVisible() or not self._buttons:
            return
        wanted = self._buttons[0]
        button = next((b for b in box.buttons() if b.text().replace("&", "") == wanted), None)
        if button is None:
            return
        self._buttons.pop(0)
        self.said.append(f"{box.text()} {box.informativeText()}")
        QTest.mouseClick(button, LEFT, pos=button.rect().center())


@pytest.fixture
def known(qapp):
    """Failures are counted from none, and each is told."""
    ERRORS.reset()
    yield
    ERRORS.reset()


def quit_by_key(window) -> None:
    driver.focus(window)
    QTest.keyClick(window.viewport, Qt.Key.Key_Q, CTRL)
    driver.pause(50)


STEPS = [
    "workspaces.export_state",
    "view.save_camera",
    "viewport.gestures.stop",
    "_feature_photo.close",
    "net.close_thread",
    "studio.keep_settings",
    "studio.workspace.layers.finish",
    "studio.jobs.close",
    "studio.workspace.projects._mark_open",
    "viewport.models.close",
]


@pytest.mark.parametrize("step", STEPS)
def test_error_on_closing_is_reported_and_everything_else_is_closed(
    own_folders, qtbot, known, outcrop, monkeypatch, step
):
    before = set(threading.enumerate())
    window = driver.make_window()
    driver.open_outcrop(window, outcrop)
    folder = window.studio.project.folder
    processes = [w._process for w in window.studio.jobs.workers.values() if w._process]
    *owners, name = step.split(".")
    owner = window
    for part in owners:
        owner = getattr(owner, part)
    whole = getattr(owner, name)

    def half(*words):
        # Or the test itself would leave threads and processes behind.
        whole(*words)
        fail()

    monkeypatch.setattr(owner, name, half)
    answers = Answers("Close")
    quit_by_key(window)
    wait(lambda: not window.isVisible(), "the end of the window")
    answers.stop()
    assert len(answers.said) == 1, step
    assert WORDS in answers.said[0]
    assert "journal" in answers.said[0]
    driver.delete(window)
    # Of an untitled one in which nothing was picked nothing is kept.
    assert is_free(folder) or not folder.exists(), step
    wait(lambda: all(p.poll() is not None for p in processes), "the end of the workers", 10.0)
    wait(lambda: set(threading.enumerate()) <= before, "the end of the threads", 20.0)


@pytest.mark.parametrize("part", ["files.ask_to_save", "photo_opening.may_close"])
def test_window_asks_before_closing_if_the_save_prompt_fails(
    own_folders, qtbot, known, outcrop, picks, monkeypatch, part
):
    window = driver.make_window()
    driver.open_outcrop(window, outcrop)
    driver.look_at(window, picks["B01"], trend=0.0)
    driver.key(window, Qt.Key.Key_T)
    driver.pick(window, picks["B01"][::4])
    driver.key(window, Qt.Key.Key_Return)
    folder = window.studio.project.folder
    owner, name = part.split(".")
    monkeypatch.setattr(getattr(window, owner), name, fail)
    answers = Answers("Cancel", "Close anyway")
    quit_by_key(window)
    assert len(answers.said) == 1
    assert WORDS in answers.said[0]
    assert window.isVisible()
    assert window.viewport.is_still
    assert not is_free(folder)
    quit_by_key(window)
    assert len(answers.said) == 2
    answers.stop()
    wait(lambda: not window.isVisible(), "the end of the window")
    driver.delete(window)
    # Nobody said that it may go: the next start offers it.
    assert folder in untitled_projects(finished=False)


@pytest.mark.usefixtures("new_window")
def test_dialog_closes_despite_an_error_on_closing(window, qtbot, monkeypatch):
    dialog = PlannerDialog(window, window.studio, window.survey)
    dialog.show()
    qtbot.waitExposed(dialog)
    whole = dialog._background.stop

    def half() -> None:
        whole()
        fail()

    monkeypatch.setattr(dialog._background, "stop", half)
    with pytest.raises(RuntimeError, match=WORDS):
        QTest.keyClick(dialog, Qt.Key.Key_Escape)
    # It is deleted once it is closed.
    wait(lambda: not shiboken6.isValid(dialog), "the end of the dialog")


@pytest.mark.usefixtures("new_window")
def test_photo_page_whose_cleanup_fails_frees_its_tab(window, qtbot, photos, monkeypatch):
    window.resize(1400, 900)
    window.open_path(photos)
    survey = window.survey
    wait(lambda: survey.document.is_imported and not survey.is_reading, "the photos", 120.0)
    window.photo_opening.open()
    page = window.photo_opening.page
    wait(
        lambda: page.canvas._picture is not None and page.canvas._picture.is_complete, "the picture"
    )
    wait(lambda: page.masks.used(page.photo) is not None, "its mask")
    whole = page.marks.close

    def half() -> None:
        whole()
        fail()

    monkeypatch.setattr(page.marks, "close", half)
    page.canvas.setFocus()
    with qtbot.capture_exceptions(), contextlib.suppress(RuntimeError):
        QTest.keyClick(page.canvas, Qt.Key.Key_W, CTRL)
    driver.pause(50)
    assert window.photo_opening.page is None
    # Another one can be opened, and the window closes.
    window.photo_opening.open()
    assert window.photo_opening.page is not page
    wait(lambda: not window.photo_opening.page.masks.busy_reason, "the photo")
