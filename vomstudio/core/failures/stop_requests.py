"""Requests to end the process, which are recorded and also take effect in native code.

A signal may raise KeyboardInterrupt at any point. The exception is lost in callbacks, and in
libraries that catch every exception during their import. Therefore the signal is recorded and
checked again before results are saved.

Python handles signals between its own instructions, so native code can delay them. Therefore a
second signal of the same kind is left to the operating system, which ends the process at once
(`listen`), and a thread ends a command that does not handle the first signal (`watch`).
"""

from __future__ import annotations

import os
import signal
import struct
import sys
import time
from types import FrameType

from vomstudio.core.threads import start_thread

_CANCELLED_MESSAGE = b"vomstudio: Cancelled.\n"
_EXIT_CODE = 130
_GRACE_PERIOD_S = 2.0
_POLL_PERIOD_S = 0.05
_RESET_FLAGS = {"linux": (136, 0x80000000), "darwin": (12, 0x4)}
"""Offset of `sa_flags` in a 64-bit `struct sigaction`, and SA_RESETHAND, by platform."""

_received_signals: list[int] = []


def listen(signal_number: int) -> None:
    """Handle a signal with `stop`; a second one ends the process, even inside native code."""
    signal.signal(signal_number, stop)
    reset_handler_after_first(signal_number)


def reset_handler_after_first(signal_number: int) -> None:
    """Make the operating system reset the handler of a signal after the first call.

    This has no effect on Windows, where `stop` resets the handler as soon as Python code runs.
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
    if sigaction(signal_number, None, action) == 0:
        (flags,) = struct.unpack_from("=I", action, offset)
        struct.pack_into("=I", action, offset, flags | reset)
        sigaction(signal_number, action, None)


def stop(signal_number: int, frame: FrameType | None) -> None:
    """Record a signal and raise KeyboardInterrupt, as the default handler of Ctrl+C does."""
    _received_signals.append(signal_number)
    sys.unraisablehook = _handle_unraisable
    # The operating system has already reset the handler (`listen`), except on Windows.
    signal.signal(signal_number, signal.SIG_DFL)
    raise KeyboardInterrupt


def watch() -> None:
    """End the process shortly after a signal that its main thread does not handle.

    Call this function in the main thread of a command. No cleanup is needed because outputs are
    only replaced by complete files. This has no effect on Windows.
    """
    if os.name != "posix":
        return
    read_end, write_end = os.pipe()
    os.set_blocking(write_end, False)
    signal.set_wakeup_fd(write_end, warn_on_full_buffer=False)
    # A signal sent to a forked child must not reach this process through the shared pipe.
    os.register_at_fork(after_in_child=lambda: signal.set_wakeup_fd(-1))
    start_thread(_watch_signals, read_end, name="stop signals")


def _watch_signals(read_end: int) -> None:
    while os.read(read_end, 64):
        end = time.monotonic() + _GRACE_PERIOD_S
        while not _received_signals and time.monotonic() < end:
            time.sleep(_POLL_PERIOD_S)
        if not _received_signals:
            try:
                os.write(2, _CANCELLED_MESSAGE)
            finally:
                os._exit(_EXIT_CODE)


def is_requested() -> bool:
    """Return whether a signal has been received since the last call of `clear_state`."""
    return bool(_received_signals)


def check() -> None:
    """Raise KeyboardInterrupt if a signal was received since the last call of `clear_state`."""
    if _received_signals:
        raise KeyboardInterrupt


def clear_state() -> None:
    """Clear the received signals before other work begins."""
    _received_signals.clear()
    if sys.unraisablehook is _handle_unraisable:
        sys.unraisablehook = sys.__unraisablehook__


def _handle_unraisable(unraisable: sys.UnraisableHookArgs, /) -> None:
    """Suppress the traceback of an interrupt in a callback; the signal is recorded anyway."""
    if not issubclass(unraisable.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(unraisable)
