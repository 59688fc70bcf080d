"""The same work without a window, one file per command."""

from vomstudio.cli.common.first_word import COMMANDS, is_for_window
from vomstudio.cli.entry import main

__all__ = ["COMMANDS", "is_for_window", "main"]
