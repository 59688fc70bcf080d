"""Command-line interface, with one module per command."""

from vomstudio.cli.common.entry import main
from vomstudio.cli.common.first_word import COMMANDS, opens_window

__all__ = ["COMMANDS", "main", "opens_window"]
