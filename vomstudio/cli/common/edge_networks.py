"""`--cost onnx --onnx-model FILE`: a network of the user's says what an edge is."""

from __future__ import annotations

import argparse

from vomstudio.cli.common.arguments import Parser
from vomstudio.errors import UsageError
from vomstudio.words import tr


def add_option(parser: Parser) -> None:
    parser.add_argument(
        "--onnx-model",
        metavar="FILE",
        help=tr("with --cost onnx: a network that gives the probability of an edge at each pixel"),
    )


def check(args: argparse.Namespace) -> None:
    """Raises UsageError for one option without the other, and for a drawing."""
    if args.onnx_model is not None and args.from_ortho is not None:
        raise UsageError(
            tr("A network is for lines that are followed or proposed, not for a drawing."),
            field="--onnx-model",
        )
    if args.onnx_model is not None and args.cost != "onnx":
        raise UsageError(
            tr("A network is followed with --cost onnx. Give that too."), field="--onnx-model"
        )
    if args.onnx_model is None and args.cost == "onnx":
        raise UsageError(
            tr("Name the network whose edges are followed, --onnx-model FILE."), field="--cost"
        )
