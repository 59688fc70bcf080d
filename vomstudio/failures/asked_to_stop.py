"""Whether the process was asked to end: remembered, since libraries swallow exceptions.

A signal raises KeyboardInterrupt wherever the program is. In a callback, or where a library that is
being read catches everything, it is lost, and the work would go on to its end. So it is remembered,
and asked for again before results take their place.
"""

from __future__ import annotations

import sys
from types import FrameType

_asked: list[int] = []


def stop(number: int, frame: FrameType | None) -> None:
    """Handle a signal: as Ctrl+C does without a handler, but remembered."""
    _asked.append(number)
    sys.unraisablehook = _unraisable
    raise KeyboardInterrupt


def was_asked() -> bool:
    """Whether the process was asked to end since `forget`."""
    return bool(_asked)


def check() -> None:
    """Raise KeyboardInterrupt if the process was asked to end since `forget`."""
    if _asked:
        raise KeyboardInterrupt


def forget() -> None:
    """What was asked is done, or of no concern to what begins."""
    _asked.clear()
    if sys.unraisablehook is _unraisable:
        sys.unraisablehook = sys.__unraisablehook__


def _unraisable(unraisable: sys.UnraisableHookArgs, /) -> None:
    """Where an interruption is lost, in a callback of Python's own, nothing is wrong: it is
    remembered, and nobody is shown a stack."""
    if not issubclass(unraisable.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(unraisable)
