"""A child process that ends when its parent does, however that one ends.

Native code that holds Python's lock for minutes keeps a thread that listens from noticing, so the
system itself ends the child: a pipe that only the parent holds open raises SIGIO in the child when
it closes. Windows has no such pipes; there the end of stdin must do.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping

NAME = "VOMSTUDIO_LIFELINE"
"""Environment variable with the descriptor of the pipe."""


class Lifeline:
    """The parent's side of the pipe.

    Attributes
    ----------
    descriptors : tuple of int
        To be passed to the child (``pass_fds``); empty on Windows.
    """

    def __init__(self) -> None:
        self._writing: int | None = None
        self.descriptors: tuple[int, ...] = ()
        if os.name == "posix":
            reading, self._writing = os.pipe()
            self.descriptors = (reading,)

    def environment(self) -> Mapping[str, str]:
        """Return what the child's environment needs."""
        return {NAME: str(self.descriptors[0])} if self.descriptors else {}

    def started(self) -> None:
        """Close the child's end here once the child has it."""
        for descriptor in self.descriptors:
            os.close(descriptor)
        self.descriptors = ()

    def close(self) -> None:
        """Let go of the child: it has ended, or ends now."""
        self.started()
        if self._writing is not None:
            os.close(self._writing)
            self._writing = None


def end_with_parent() -> None:
    """Let the system end this process when its parent is gone."""
    descriptor = os.environ.pop(NAME, None)
    if descriptor is None:
        return
    with contextlib.suppress(ImportError, AttributeError, OSError, ValueError):
        import fcntl
        import select

        flags = fcntl.fcntl(int(descriptor), fcntl.F_GETFL)
        fcntl.fcntl(int(descriptor), fcntl.F_SETOWN, os.getpid())
        # SIGIO comes when the other end closes, and its default action is to end the process.
        fcntl.fcntl(int(descriptor), fcntl.F_SETFL, flags | os.O_ASYNC)
        if select.select([int(descriptor)], [], [], 0)[0]:
            # It has closed already.
            os._exit(1)
