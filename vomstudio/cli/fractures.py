"""`vomstudio fractures`: statistics of a map of fracture traces."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.cli.common.arguments import Subparsers, add_command, progress_reporter
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.error_context import name_input_in_errors
from vomstudio.cli.common.frame_arguments import add_frame, frame_options
from vomstudio.cli.common.output import Output
from vomstudio.core.words import tr
from vomstudio.geology.fractures.fracture_options import FractureOptions

if TYPE_CHECKING:
    from vomstudio.geology.fractures.network import FractureNetwork


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``fractures`` command."""
    parser = add_command(
        subparsers,
        "fractures",
        run,
        help_=tr("Analyse number, length, nodes and spacing of fractures in a trace map"),
    )
    parser.add_argument(
        "traces",
        metavar="TRACES",
        help=tr("lines in metres: GeoPackage, GeoJSON, shapefile or DXF"),
    )
    add_options(parser, FractureOptions)
    parser.add_argument("--plot", metavar="FILE", help=tr("figure (.svg, .pdf or .png)"))
    add_frame(parser)
    parser.add_argument("--force", action="store_true", help=tr("replace an existing FILE"))


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio fractures``.

    Parameters
    ----------
    args : Namespace
        Parsed arguments.
    out : Output
        Object that receives the results, warnings and progress.

    Raises
    ------
    UsageError, InputError, GeometryError, TargetError
    """
    from vomstudio.core.files.atomic import atomic_write, check_target
    from vomstudio.products.fractures.mapping import FractureMapRequest, map_fractures
    from vomstudio.products.net.figure import picture_format

    options = parse_options(args, FractureOptions)
    request = FractureMapRequest(Path(args.traces), options, frame_options(args))
    format_ = None
    if args.plot is not None:
        format_ = picture_format(args.plot, "--plot")
        inputs = [p for p in (args.traces, args.area, args.scanline) if p is not None]
        check_target(args.plot, force=args.force, inputs=inputs)
    with name_input_in_errors(args.area or args.traces):
        mapped_fractures = map_fractures(request, progress=progress_reporter(args))
    if format_ is not None:
        from vomstudio.products.fractures.figure import write_fractures

        with atomic_write(args.plot, args.force) as temporary:
            write_fractures(temporary, mapped_fractures, format=format_)
    result = {**mapped_fractures.statistics.to_dict(), "image": args.plot}
    out.result(result)
    out.warn(mapped_fractures.statistics.warnings)
    out.text(_result_text(mapped_fractures.statistics))
    for note in mapped_fractures.statistics.notes:
        out.note(note.message)


def _result_text(network: FractureNetwork) -> str:
    from vomstudio.products.fractures.summary import figure_rows

    rows = figure_rows(network)
    width = max(len(label) for label, _ in rows)
    return "\n".join(f"{label:<{width}}  {value}" for label, value in rows)
