"""`vomstudio trace`: lines on the surface of a model."""

from __future__ import annotations

import argparse

from vomstudio.cli import trace_drawing
from vomstudio.cli.common.arguments import Subparsers, add_command, add_output
from vomstudio.cli.common.output import Output
from vomstudio.errors import UsageError
from vomstudio.words import tr


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(subparsers, "trace", run, help_=tr("Lines on the surface of a model"))
    parser.add_argument("model", metavar="MODEL", help=tr("mesh or point cloud"))
    add_output(parser, tr("the table of the lines, line, x, y, z in World"), required=True)
    trace_drawing.add_options(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    if args.from_ortho is None:
        raise UsageError(
            tr("Give a drawing with its picture: --from-ortho DRAWING --sidecar FILE."),
            field="--from-ortho",
        )
    trace_drawing.run(args, out)
