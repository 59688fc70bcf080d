"""`vomstudio repeats`: repeatability of picks compared with their stated errors."""

from vomstudio.cli.repeats.command import add_parser, run

__all__ = ["add_parser", "run"]
