"""The same work without a window, one file per command."""

from vomstudio.cli.entry import main
from vomstudio.cli.first_word import COMMANDS, is_for_window

__all__ = ["COMMANDS", "is_for_window", "main"]
