"""`vomstudio stereonet`: the orientations of a table as a picture."""

from __future__ import annotations

import argparse
from pathlib import Path

from vomstudio.cli.arguments import Subparsers, add_azimuth, add_command, add_output
from vomstudio.cli.output import Output
from vomstudio.errors import UsageError
from vomstudio.words import tr


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers,
        "stereonet",
        run,
        help_=tr("Draw a stereonet, lower hemisphere, as SVG, PDF or PNG"),
    )
    parser.add_argument("table", metavar="TABLE", help=tr("table of planes or lines"))
    add_output(parser, tr("the picture, by its ending: .svg, .pdf or .png"), required=True)
    parser.add_argument(
        "--set",
        metavar="COLUMN",
        dest="set_column",
        help=tr("colour by this column (name or number)"),
    )
    parser.add_argument(
        "--contour", metavar="METHOD", help=tr("density: kamb, exponential_kamb ...")
    )
    parser.add_argument(
        "--projection",
        choices=["area", "angle"],
        default="area",
        help=tr("equal area or equal angle"),
    )
    add_azimuth(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.files.atomic import atomic_write, check_target
    from vomstudio.geology.stereonet import DENSITY_METHODS
    from vomstudio.io.text.orientation_reading import read_orientations
    from vomstudio.products.net.table_net import net_of_table

    format_ = _format(args.output)
    if args.contour is not None and args.contour not in DENSITY_METHODS:
        raise UsageError(
            tr(
                "'{method}' is not a density method. Use {methods}.",
                method=args.contour,
                methods=", ".join(DENSITY_METHODS),
            ),
            field="--contour",
        )
    check_target(args.output, force=args.force, inputs=[args.table])
    table = read_orientations(args.table, args.azimuth)
    net = net_of_table(table, args.set_column, projection=args.projection, contour=args.contour)

    from vomstudio.products.net.figure import write_stereonet

    with atomic_write(args.output, args.force) as temporary:
        write_stereonet(temporary, net, format=format_)
    out.result(
        {
            "image": args.output,
            "n": len(table),
            "sets": {s.name: len(s) for s in net.sets},
            "projection": args.projection,
            "hemisphere": "lower",
            "contour": args.contour,
            "convention": table.convention,
            "dropped_lines": list(table.dropped),
            "warnings": list(table.warnings),
        }
    )
    out.note(tr("read as {convention}", convention=table.convention))
    out.warn(table.warnings)
    sets = ", ".join(f"{s.name} (n = {len(s)})" for s in net.sets)
    out.text(
        tr("{file}: {sets}; equal area, lower hemisphere", file=args.output, sets=sets)
        if args.projection == "area"
        else tr("{file}: {sets}; equal angle, lower hemisphere", file=args.output, sets=sets)
    )


def _format(path: str) -> str:
    from vomstudio.products.net.figure import FORMATS

    ending = Path(path).suffix.lower().removeprefix(".")
    if ending not in FORMATS:
        raise UsageError(
            tr("The ending of the name decides the format: .svg, .pdf or .png."),
            file=path,
            field="--output",
        )
    return ending
