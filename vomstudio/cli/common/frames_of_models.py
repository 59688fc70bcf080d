"""How a model stands in World, as the user says it on the command line."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from vomstudio.cli.common.arguments import Parser
from vomstudio.geometry.units import METRES
from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.workspace.frame_declaration import DeclaredFrame


def add_frame(parser: Parser) -> None:
    parser.add_argument(
        "--crs", metavar="EPSG", help=tr("coordinate reference system of the model")
    )
    parser.add_argument(
        "--up", choices=["y", "z"], help=tr("the model's axis that points up (default z)")
    )
    parser.add_argument(
        "--unit", choices=list(METRES), help=tr("unit of the model's coordinates (default m)")
    )


def add_project(parser: Parser) -> None:
    parser.add_argument(
        "--project",
        metavar="PROJECT",
        help=tr("the model stands as it does in this project, registered or declared"),
    )


def declared_of(args: argparse.Namespace) -> DeclaredFrame:
    from vomstudio.workspace.frame_declaration import DeclaredFrame

    return DeclaredFrame(args.crs, args.up, args.unit)
