"""Work in threads outlives the windows that asked for it."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable

import pytest
from PySide6.QtCore import QObject

from vomstudio.core.errors import InputError, VomError
from vomstudio.ui.base.qt_background import LatestRequestRunner

_OWNERS_COME_AND_GO = """
import random, sys, time
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication, QWidget
from vomstudio.ui.base.qt_background import QtBackground

# Threads take turns as often as they can, so that the seconds of this test show what months would.
sys.setswitchinterval(1e-5)
app, root, handed = QApplication([]), QWidget(), []

def come_and_go():
    owner = QWidget(root)
    background = QtBackground(owner)
    for number in range(4):
        background.run(lambda: time.sleep(random.uniform(0.0, 0.002)), handed.append)
    QTimer.singleShot(random.randrange(4), owner.deleteLater)

timer = QTimer()
timer.timeout.connect(come_and_go)
timer.start(5)
QTimer.singleShot(5000, app.quit)
app.exec()
print(len(handed))
"""


@pytest.mark.full
def test_deleting_an_owner_during_its_work_does_not_crash() -> None:
    """A thread that emitted a signal of a dialog which Qt deleted in that moment ended the program
    (segmentation fault; with such threads within two seconds, mostly)."""
    ran = subprocess.run(
        [sys.executable, "-X", "faulthandler", "-c", _OWNERS_COME_AND_GO],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (ran.returncode, ran.stderr) == (0, "")
    assert int(ran.stdout) > 0


_MAPS_IN_THREADS = """
from PySide6.QtCore import QCoreApplication, QObject, QThreadPool, QTimer
from vomstudio.ui.base.qt_background import QtBackground

app, done = QCoreApplication([]), []
owner = QObject()
background = QtBackground(owner)

def work():
    from pyproj import CRS
    return CRS.from_user_input("EPSG:32633").name

def again(name):
    done.append(name)
    app.quit() if len(done) == 20 else background.run(work, again)

# One thread of Qt's for all of it.
QThreadPool.globalInstance().setMaxThreadCount(1)
background.run(work, again)
QTimer.singleShot(60000, app.quit)
app.exec()
print(len(done))
"""


def test_repeated_use_of_pyproj_in_threads_does_not_crash() -> None:
    """pyproj in a thread of Qt's ended the program at its second use."""
    ran = subprocess.run(
        [sys.executable, "-X", "faulthandler", "-c", _MAPS_IN_THREADS],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (ran.returncode, ran.stderr, ran.stdout.strip()) == (0, "", "20")


def test_only_the_latest_request_is_delivered(qtbot) -> None:
    owner, begun, came, slow = QObject(), [], [], []
    go = threading.Event()
    failed: list[VomError] = []
    newest = LatestRequestRunner(owner, came.append, failed.append, lambda: slow.append(True))

    def work(number: int) -> Callable[[], int]:
        def do() -> int:
            begun.append(number)
            go.wait(30.0)
            return number

        return do

    newest.request(work(0))
    qtbot.waitUntil(lambda: begun == [0])
    for number in range(1, 5):
        newest.request(work(number))
    qtbot.waitUntil(lambda: bool(slow))
    assert newest.is_waiting
    go.set()
    qtbot.waitUntil(lambda: came == [4])
    assert begun == [0, 4]
    assert not newest.is_waiting
    # What is done at once stands in place of what is still to come.
    go.clear()
    newest.request(work(5))
    newest.run_now(lambda: 6)
    go.set()
    newest.request(work(7))
    qtbot.waitUntil(lambda: came == [4, 6, 7])
    # Errors arrive, whether they are raised at once or in the thread.
    error = InputError("is no plane")

    def fail() -> None:
        raise error

    newest.run_now(fail)
    newest.request(fail)
    qtbot.waitUntil(lambda: failed == [error, error])
    assert not newest.is_waiting
