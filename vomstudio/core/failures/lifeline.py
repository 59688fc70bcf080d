"""Mechanism that ends a child process as soon as its parent ends for any reason.

A listening thread cannot react while native code holds the GIL for minutes, so the operating
system ends the child: a pipe that only the parent has open raises SIGIO in the child when it
closes. On Windows, the child ends when its stdin is closed.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping

NAME = "VOMSTUDIO_LIFELINE"
"""Environment variable that contains the file descriptor of the pipe."""


class Lifeline:
    """Parent's end of the pipe.

    Attributes
    ----------
    descriptors : tuple of int
        File descriptors to pass to the child (``pass_fds``); empty on Windows.
    """

    def __init__(self) -> None:
        self._write_end: int | None = None
        self.descriptors: tuple[int, ...] = ()
        if os.name == "posix":
            read_end, self._write_end = os.pipe()
            self.descriptors = (read_end,)

    def environment(self) -> Mapping[str, str]:
        """Return the environment variables for the child."""
        return {NAME: str(self.descriptors[0])} if self.descriptors else {}

    def close_child_end(self) -> None:
        """Close the child's end of the pipe in this process, after the child has started."""
        for descriptor in self.descriptors:
            os.close(descriptor)
        self.descriptors = ()

    def close(self) -> None:
        """Close the pipe after the child has ended, or to end the child now."""
        self.close_child_end()
        if self._write_end is not None:
            os.close(self._write_end)
            self._write_end = None


def end_with_parent() -> None:
    """Let the operating system end this process when its parent ends."""
    descriptor = os.environ.pop(NAME, None)
    if descriptor is None:
        return
    with contextlib.suppress(ImportError, AttributeError, OSError, ValueError):
        import fcntl
        import select

        flags = fcntl.fcntl(int(descriptor), fcntl.F_GETFL)
        fcntl.fcntl(int(descriptor), fcntl.F_SETOWN, os.getpid())
        # SIGIO is raised when the other end closes, and its default action is to end the process.
        fcntl.fcntl(int(descriptor), fcntl.F_SETFL, flags | os.O_ASYNC)
        if select.select([int(descriptor)], [], [], 0)[0]:
            # The pipe is already closed.
            os._exit(1)
