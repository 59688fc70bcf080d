"""Command-line interface, with one module per command."""

from __future__ import annotations

from collections.abc import Sequence

from vomstudio.cli.common.first_word import COMMANDS, opens_window

__all__ = ["COMMANDS", "main", "opens_window"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments, by default those of the process.

    Returns
    -------
    int
        Exit code.
    """
    # Not needed to open the window, which would start 30 ms later.
    from vomstudio.cli.common import entry

    return entry.main(argv)
