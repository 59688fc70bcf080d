"""The one place where objects are made and joined."""

from __future__ import annotations

import sys
from collections.abc import Sequence


def main(argv: Sequence[str] | None = None) -> int:
    """`vomstudio` opens the window, `vomstudio COMMAND ...` works without one."""
    words = list(sys.argv[1:] if argv is None else argv)
    if words[:1] == ["--worker"]:
        from vomstudio.jobs.worker import main as work

        return work()
    from vomstudio.cli import COMMANDS

    if words and (words[0] in COMMANDS or words[0].startswith("-")):
        from vomstudio.cli import main as command_line

        return command_line(words)
    from vomstudio.ui.shell.start import run_window

    return run_window(words)
