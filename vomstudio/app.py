"""The one place where objects are made and joined."""

from __future__ import annotations

import sys
from collections.abc import Sequence


def main(argv: Sequence[str] | None = None) -> int:
    """`vomstudio` opens the window, `vomstudio COMMAND ...` works without one."""
    from vomstudio.languages import use_users_language

    use_users_language()
    words = list(sys.argv[1:] if argv is None else argv)
    if words[:1] == ["--worker"]:
        from vomstudio.jobs.worker import main as work

        return work()
    if words[:1] == ["--graphics"]:
        from vomstudio.rendering.scene.graphics import main as say

        return say()
    from vomstudio.cli import is_for_window

    if not is_for_window(words):
        from vomstudio.cli import main as command_line
        from vomstudio.failures import log

        log.start("command")
        return command_line(words)
    from vomstudio.failures import crashes, exception_hooks
    from vomstudio.failures.error_collector import ERRORS
    from vomstudio.ui.shell.window_start import run_window

    exception_hooks.install(crashes.WINDOW)
    try:
        return run_window(words)
    except Exception as error:
        ERRORS.report(error, "outside the window's event loop")
        raise
    finally:
        exception_hooks.uninstall()
