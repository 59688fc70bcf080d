"""The same work without a window, one file per command."""

from vomstudio.cli.entry import COMMANDS, main

__all__ = ["COMMANDS", "main"]
