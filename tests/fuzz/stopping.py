"""Campaigns run for hours: one that is asked to end says what it has counted."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterable, Iterator
from types import FrameType


def until_stopped(numbers: Iterable[int]) -> Iterator[int]:
    """The numbers, and none more once the process was asked to end by SIGTERM."""
    asked = threading.Event()

    def stop(number: int, frame: FrameType | None) -> None:
        asked.set()

    if threading.current_thread() is not threading.main_thread():
        yield from numbers
        return
    before = signal.signal(signal.SIGTERM, stop)
    try:
        for number in numbers:
            if asked.is_set():
                return
            yield number
    finally:
        signal.signal(signal.SIGTERM, before)
