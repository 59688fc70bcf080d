"""Requests to end the process: handled, remembered, and obeyed while native code runs.

A signal raises KeyboardInterrupt wherever the program is. In a callback, or where a library that is
being read catches everything, it is lost, and the work would go on to its end. So it is remembered,
and asked for again before results take their place.

Python handles signals between two of its own instructions, which native code can hold up for as
long as it likes. So a second signal of the same kind is left to the system, which ends the process
at once (`listen`), and a thread ends a command that does not handle the first one (`watch`).
"""

from __future__ import annotations

import os
import signal
import struct
import sys
import threading
import time
from types import FrameType

_SENTENCE = b"vomstudio: Cancelled.\n"
_EXIT_CODE = 130
_PATIENCE_S = 2.0
_LOOK_S = 0.05
_RESET_FLAGS = {"linux": (136, 0x80000000), "darwin": (12, 0x4)}
"""By platform: where `sa_flags` is in a `struct sigaction` of 64 bits, and SA_RESETHAND."""

_asked: list[int] = []


def listen(number: int) -> None:
    """Handle a signal by `stop`; a second one ends the process, also inside native code."""
    signal.signal(number, stop)
    end_on_second(number)


def end_on_second(number: int) -> None:
    """Have the system forget the handler of a signal once it was called.

    Has no effect on Windows, where `stop` does it once Python runs.
    """
    if sys.platform not in _RESET_FLAGS or struct.calcsize("P") != 8:
        return
    import ctypes

    offset, reset = _RESET_FLAGS[sys.platform]
    action = ctypes.create_string_buffer(256)
    try:
        sigaction = ctypes.CDLL(None).sigaction
    except (OSError, AttributeError):
        return
    if sigaction(number, None, action) == 0:
        (flags,) = struct.unpack_from("=I", action, offset)
        struct.pack_into("=I", action, offset, flags | reset)
        sigaction(number, action, None)


def stop(number: int, frame: FrameType | None) -> None:
    """Handle a signal: as Ctrl+C does without a handler, but remembered."""
    _asked.append(number)
    sys.unraisablehook = _unraisable
    # The system has forgotten this handler (`listen`), except on Windows.
    signal.signal(number, signal.SIG_DFL)
    raise KeyboardInterrupt


def watch() -> None:
    """End the process soon after a signal that its main thread does not handle.

    For the process of a command, called in its main thread. Nothing is cleaned up then: what is
    written takes its place only when it is complete. Has no effect on Windows.
    """
    if os.name != "posix":
        return
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    # What a forked child receives is no request to this process.
    os.register_at_fork(after_in_child=lambda: signal.set_wakeup_fd(-1))
    threading.Thread(target=_watch, args=(reading,), name="stop signals", daemon=True).start()


def _watch(reading: int) -> None:
    while os.read(reading, 64):
        end = time.monotonic() + _PATIENCE_S
        while not _asked and time.monotonic() < end:
            time.sleep(_LOOK_S)
        if not _asked:
            try:
                os.write(2, _SENTENCE)
            finally:
                os._exit(_EXIT_CODE)


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
