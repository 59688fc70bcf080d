"""Work in threads outlives the windows that asked for it."""

from __future__ import annotations

import subprocess
import sys

_OWNERS_COME_AND_GO = """
import random, sys, time
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication, QWidget
from vomstudio.ui.common.background_reading import Background

# Threads take turns as often as they can, so that the seconds of this test show what months would.
sys.setswitchinterval(1e-5)
app, root, handed = QApplication([]), QWidget(), []

def come_and_go():
    owner = QWidget(root)
    background = Background(owner)
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


def test_owners_are_deleted_while_their_work_is_being_done() -> None:
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
