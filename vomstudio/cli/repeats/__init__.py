"""`vomstudio repeats`: how far apart repeated picks lie, beside the errors that they state."""

from vomstudio.cli.repeats.command import add_parser, run

__all__ = ["add_parser", "run"]
