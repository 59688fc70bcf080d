"""`vomstudio measurable`: expected quality of a plane before it is picked."""

from vomstudio.cli.measurable.command import add_parser, run

__all__ = ["add_parser", "run"]
