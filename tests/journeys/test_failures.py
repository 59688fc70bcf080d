"""Whatever goes wrong, in whichever thread or process, is said once, and the window lives on."""

from __future__ import annotations

import gc
import logging
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from PySide6.QtCore import QEventLoop, QObject, QTimer, Signal, qWarning
from PySide6.QtWidgets import QApplication, QFileDialog, QPushButton, QWidget

from tests import driver
from tests.messages import shown_codes
from tests.studio.jobs import odd_jobs
from vomstudio.core.failures import crashes, exception_hooks, log
from vomstudio.io.settings import read_settings
from vomstudio.studio.jobs.job import Job, NoArguments
from vomstudio.ui.base import qt_log as qt_messages
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.shell.main_window import MainWindow
from vomstudio.ui.widgets.failure_notices import FailureNotices, compose_report

pytestmark = [pytest.mark.expects_log, pytest.mark.full]
SECRET = 432100.25

ROOT = Path(__file__).resolve().parents[2]


class OurMistake(ValueError):
    """No other error of the program is of this kind."""


def mistake() -> None:
    raise OurMistake(f"at {SECRET} of {Path.home()}/Val Camonica/cliff.obj")


@pytest.fixture
def hooked(own_folders):
    """The hooks of the running program, in place of those of the tests."""
    exception_hooks.install(crashes.WINDOW)
    qt_messages.install()
    yield
    qt_messages.uninstall()
    exception_hooks.uninstall()


@pytest.fixture
def window(hooked, qtbot):
    made = driver.make_window()
    notices = FailureNotices(made, made)
    notices.begin()
    said: list[str] = []
    made.studio.notice.connect(lambda notice: said.append(notice.text))
    made.said = said
    yield made
    notices.close()
    driver.dismiss(made)


def work(milliseconds: int) -> None:
    """The program's own event loop; QTest's keeps an error and raises it where it returns."""
    loop = QEventLoop()
    QTimer.singleShot(milliseconds, loop.quit)
    loop.exec()


def offers(window: MainWindow, *texts: str) -> None:
    """A button of the bar is there as soon as the bar has laid itself out."""

    def buttons() -> tuple[str, ...]:
        found = window.message_bar.findChildren(QPushButton)
        return tuple(button.text() for button in found if button.isVisible())

    driver.wait(lambda: buttons() == texts, f"the buttons {texts}")


def is_said(window: MainWindow, words: str = "OurMistake", times: int = 1) -> None:
    """In the bar, with the button, once, and in the log; the window can still be worked with."""
    work(100)
    driver.wait(lambda: words in window.message_bar.text, f"{words} in the bar")
    assert window.message_bar.isVisible()
    offers(window, "Save report…")
    assert len([text for text in window.said if words in text]) == times
    notation = window.studio.settings.notation
    other = "notation_strike" if notation == "dipdir/dip" else "notation_dipdir"
    window.actions_table.all[other].trigger()
    assert window.studio.settings.notation != notation


def is_logged(words: str) -> None:
    text = log.path().read_text()
    assert words in text
    assert "Traceback" in text
    assert "in mistake" in text


def test_error_in_a_slot_is_shown_and_the_window_stays_usable(window, outcrop, picks):
    class Sender(QObject):
        sent = Signal()

    driver.open_outcrop(window, outcrop)
    sender = Sender()
    sender.sent.connect(mistake)
    sender.sent.emit()
    is_said(window)
    is_logged("OurMistake")
    points = next(iter(picks.values()))
    driver.look_at(window, points, 0.0)
    window.actions_table.all["trace"].trigger()
    driver.pick(window, points)
    window.actions_table.all["finish"].trigger()
    assert len(driver.traces(window)) == 1, "a trace can be picked"


def test_an_error_in_every_paint_is_shown_once_and_leaves_no_painter_open(window):
    from PySide6.QtGui import QPainter

    painters = 0

    class Broken(QWidget):
        def paintEvent(self, event) -> None:  # noqa: N802
            nonlocal painters
            painter = QPainter(self)
            painters += painter.isActive()
            painter.drawLine(0, 0, 5, 5)
            mistake()

    broken = Broken(window)
    broken.setGeometry(0, 0, 300, 300)
    broken.show()
    broken.raise_()
    again = QTimer()
    again.timeout.connect(broken.update)
    again.start(15)
    work(1500)
    again.stop()
    broken.hide()
    broken.deleteLater()
    is_said(window)
    is_logged("OurMistake")
    assert painters >= 10, "each paint has a painter of its own"
    assert "paint device" not in log.path().read_text()
    assert "active painter" not in log.path().read_text()


def test_error_in_a_timer_is_shown_and_the_window_stays_usable(window):
    QTimer.singleShot(0, mistake)
    is_said(window)
    is_logged("OurMistake")


def test_error_in_a_thread_is_shown_and_the_window_stays_usable(window):
    thread = threading.Thread(target=mistake, name="measuring")
    thread.start()
    thread.join()
    is_said(window)
    is_logged("in the thread measuring")


def test_worker_thread_continues_after_an_error_in_one_task(window):
    done = threading.Event()
    worker = QtBackground(window, "pieces", threads=1)
    worker.run(mistake, print)
    worker.run(done.set, print)
    assert done.wait(5.0)
    worker.stop()
    is_said(window)
    is_logged("in the thread pieces")


def test_error_in_background_work_is_shown_and_gives_no_result(window):
    handed = []
    QtBackground(window).run(mistake, handed.append)
    is_said(window)
    is_logged("OurMistake")
    assert handed == []


def test_error_in_a_destructor_is_shown(window):
    class Fragile:
        def __del__(self) -> None:
            mistake()

    Fragile()
    gc.collect()
    is_said(window)
    is_logged("__del__")


@pytest.fixture
def odd_workers(monkeypatch):
    """Worker processes that also know the jobs of `odd_jobs`."""
    real = subprocess.Popen

    def start(words, **more):
        return real([sys.executable, "-m", "tests.studio.jobs.odd_jobs"], **{**more, "cwd": ROOT})

    monkeypatch.setattr("vomstudio.studio.jobs.supervisor.subprocess.Popen", start)


@pytest.mark.parametrize(
    ("task", "words", "in_log"),
    [
        (odd_jobs.MISTAKE, "OurMistake", "in the task mistake"),
        (odd_jobs.ASIDE, "OurMistake", "in the thread aside"),
        (odd_jobs.ABORT, "the worker process ended: exit code -6", "exit code -6"),
        (odd_jobs.SEGFAULT, "the worker process ended: exit code -11", "exit code -11"),
    ],
)
def test_error_in_a_worker_is_shown_and_the_next_job_runs(odd_workers, window, task, words, in_log):
    ended = []

    def have_done(job: Job) -> None:
        ended.clear()
        window.studio.jobs.submit(
            job,
            NoArguments(),
            title="Looking closely",
            on_done=ended.append,
            on_failed=lambda event: (ended.append(event), window.studio.warn(event.message)),
        )
        driver.wait(lambda: ended, "the job's end")

    have_done(task)
    is_said(window, f"an internal error occurred ({words}")
    assert "Looking closely" in window.message_bar.text
    assert "job.internal-error" in shown_codes(window.message_bar.text)
    have_done(odd_jobs.IDLE)
    assert ended[-1] == NoArguments()
    assert in_log in log.path().read_text()
    if task in (odd_jobs.ABORT, odd_jobs.SEGFAULT):
        assert "Fatal Python error" in compose_report(window)


def test_an_error_in_a_quiet_job_is_not_lost(odd_workers, window):
    window.studio.jobs.submit(
        odd_jobs.MISTAKE,
        NoArguments(),
        title="Getting ready",
        on_done=lambda _: None,
        on_failed=lambda _: None,
        is_quiet=True,
    )
    is_said(window)


def test_qt_warnings_are_logged(window):
    warning = "a widget is not well"
    qWarning(warning)
    assert f"WARNING vomstudio.qt: {warning}" in log.path().read_text()


def test_report_contains_no_coordinates_or_names(window, outcrop, picks, tmp_path, monkeypatch):
    driver.open_outcrop(window, outcrop)
    points = next(iter(picks.values()))
    driver.look_at(window, points, 0.0)
    window.actions_table.all["trace"].trigger()
    driver.pick(window, points)
    window.actions_table.all["finish"].trigger()
    QTimer.singleShot(0, mistake)
    is_said(window)
    file = tmp_path / "report"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(file), ""))
    window.message_bar.findChildren(QPushButton)[0].click()
    text = file.with_suffix(".txt").read_text()
    assert "OurMistake: at # of ~/….obj" in text
    for part in ("VOM Studio", "PySide6", "vtk", "numpy", "Traceback", "action trace"):
        assert part in text
    assert "trace added (" in text
    assert "model added (" in text
    trace = driver.traces(window)[0]
    numbers = {f"{v:.2f}" for point in trace.vertices for v in point}
    numbers |= {str(v) for point in trace.vertices for v in point}
    assert not any(number in text for number in numbers)
    text = text.replace("outcrop_normal", "the field of a record")
    private = ("432100", "Camonica", str(Path.home()), str(tmp_path), "outcrop", trace.name)
    assert [word for word in private if word in text] == []


def test_unwritable_report_is_reported(window, monkeypatch):
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: ("/nowhere/report.txt", ""))
    window.actions_table.all["save_report"].trigger()
    assert "/nowhere" in window.message_bar.text


def test_crash_of_the_last_run_is_reported_at_the_next_start(hooked, qtbot):
    words = (
        "import os; from vomstudio.core.failures import exception_hooks; "
        "exception_hooks.install('window'); os.abort()"
    )
    subprocess.run([sys.executable, "-c", words], check=False, capture_output=True)
    window = driver.make_window()
    notices = FailureNotices(window, window)
    try:
        window.said = []
        window.studio.notice.connect(lambda notice: window.said.append(notice.text))
        notices.begin()
        is_said(window, "crashed in the last session")
        assert "Fatal Python error: Aborted" in compose_report(window)
    finally:
        notices.close()
        driver.dismiss(window)


def test_error_in_the_error_display_does_not_recurse(window, monkeypatch):
    def broken(notice) -> None:
        raise RuntimeError("the messages are broken")

    monkeypatch.setattr(window.messages, "add", broken)
    QTimer.singleShot(0, mistake)
    driver.wait(lambda: "messages are broken" in log.path().read_text(), "the log")
    work(300)
    assert log.path().read_text().count("the messages are broken\n") <= 2


def test_error_before_the_window_is_ready_is_shown_later(hooked, qtbot):
    window = MainWindow(read_settings()[0])
    notices = FailureNotices(window, window)
    try:
        QTimer.singleShot(0, mistake)
        work(50)
        window.show()
        window.begin([])
        notices.begin()
        assert "OurMistake" in window.message_bar.text
    finally:
        notices.close()
        driver.dismiss(window)


def test_exception_hooks_are_restored(own_folders):
    before = sys.excepthook, threading.excepthook, sys.unraisablehook
    exception_hooks.install(crashes.WINDOW)
    assert sys.excepthook is not before[0]
    exception_hooks.uninstall()
    assert (sys.excepthook, threading.excepthook, sys.unraisablehook) == before
    assert logging.getLogger().handlers.count(None) == 0
    assert list(crashes.folder().iterdir()) == []


def test_crash_is_reported_beside_the_unsaved_work_it_left(hooked, qtbot, tmp_path):
    words = (
        "import os; from vomstudio.core.failures import exception_hooks; "
        "exception_hooks.install('window'); os.abort()"
    )
    subprocess.run([sys.executable, "-c", words], check=False, capture_output=True)
    window = driver.make_window()
    notices = FailureNotices(window, window)
    try:
        left = tmp_path / "left.vom"
        window.studio.save_as(left)
        window.studio.new_project()
        window.studio.recovery_found.emit([left])
        notices.begin()
        offers(window, "Restore", "Save report…")
        assert "crash" in window.messages.item(window.messages.count() - 1).text()
    finally:
        notices.close()
        driver.dismiss(window)


def test_window_that_fails_to_initialize_reports_it_and_offers_the_report(
    hooked, qtbot, tmp_path, monkeypatch
):
    file = tmp_path / "report.txt"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(file), ""))
    window = MainWindow(read_settings()[0])
    notices = FailureNotices(window, window)
    seen: list[str] = []

    def press() -> None:
        box = QApplication.activeModalWidget()
        seen.append(box.text())
        next(b for b in box.buttons() if b.text() == "Save report…").click()

    QTimer.singleShot(100, press)
    try:
        mistake()
    except OurMistake as error:
        notices.show_fatal(error)
    assert "OurMistake" in seen[0]
    assert "OurMistake: at #" in file.read_text()
    notices.close()
    driver.delete(window)
