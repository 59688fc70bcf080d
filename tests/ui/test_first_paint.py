"""Work that starts with the first paint of the window."""

from __future__ import annotations

from PySide6.QtGui import QPaintEvent
from PySide6.QtWidgets import QWidget

from tests import driver
from vomstudio.ui.shell.first_paint import MAX_WAIT_MS, FirstPaint


class Painted(QWidget):
    def __init__(self, events: list[str]) -> None:
        super().__init__()
        self.events = events

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        self.events.append("paint")


def test_work_starts_once_and_after_the_first_paint(qapp):
    events: list[str] = []
    window = Painted(events)
    FirstPaint(window, lambda: events.append("work"))
    driver.pause(30)
    # As under a window manager, which shows a window some time after `show`.
    assert not events
    window.show()
    driver.wait(lambda: "work" in events, "the work")
    assert events[0] == "paint"
    window.update()
    driver.pause(MAX_WAIT_MS + 100)
    assert events.count("work") == 1
    window.close()


def test_work_starts_even_if_the_window_is_never_painted(qapp):
    events: list[str] = []
    window = Painted(events)
    FirstPaint(window, lambda: events.append("work"))
    driver.wait(lambda: events == ["work"], "the work")
    window.close()
