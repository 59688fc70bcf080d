"""Whether the process was asked to end: remembered, since libraries swallow exceptions.

A signal raises KeyboardInterrupt wherever the program is. In a callback, or where a library that is
being read catches everything, it is lost, and the work would go on to its end. So it is remembered,
and asked for again before results take their place.
"""

from __future__ import annotations

from types import FrameType

_asked: list[int] = []


def stop(number: int, frame: FrameType | None) -> None:
    """Handle a signal: as Ctrl+C does without a handler, but remembered."""
    _asked.append(number)
    raise KeyboardInterrupt


def check() -> None:
    """Raise KeyboardInterrupt if the process was asked to end since `forget`."""
    if _asked:
        raise KeyboardInterrupt


def forget() -> None:
    """What was asked is done, or of no concern to what begins."""
    _asked.clear()
