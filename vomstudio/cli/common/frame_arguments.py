"""Options that determine the placement of a model in the World frame."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from vomstudio.cli.common.arguments import Parser
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.gate.frame_options import FrameOptions

if TYPE_CHECKING:
    from vomstudio.studio.world_models import WorldModel


def add_frame(parser: Parser) -> None:
    """Add the options that define the frame of a model."""
    add_options(parser, FrameOptions)


def add_project(parser: Parser) -> None:
    """Add `--project`, which applies the placement of the model in a project."""
    parser.add_argument(
        "--project",
        metavar="PROJECT",
        help=tr("use the registration or declared frame of the model in this project"),
    )


def unknown_unit(model: WorldModel) -> list[Finding]:
    """Return a list with ``frame.no-unit`` if the unit is neither known nor assumed."""
    codes = {item.code for item in model.warnings}
    return [] if model.is_metric or "frame.assumed" in codes else [Finding("frame.no-unit")]


def frame_options(args: argparse.Namespace) -> FrameOptions:
    """Return the frame options of a command."""
    return parse_options(args, FrameOptions)
