"""`vomstudio measurable`: how well a plane could be measured, before anyone picks."""

from vomstudio.cli.measurable.command import add_parser, run

__all__ = ["add_parser", "run"]
