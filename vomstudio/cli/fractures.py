"""`vomstudio fractures`: a map of fracture traces in figures."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.cli.common.arguments import Subparsers, add_command, progress_of
from vomstudio.cli.common.frames_of_models import add_frame, frame_options
from vomstudio.cli.common.naming import numbers_of
from vomstudio.cli.common.output import Output
from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.geology.fractures.network import FractureNetwork


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers, "fractures", run,
        help_=tr("Number, length, nodes and spacing of the fractures of a trace map"),
    )  # fmt: skip
    parser.add_argument(
        "traces", metavar="TRACES",
        help=tr("lines in metres: GeoPackage, GeoJSON, shapefile or DXF"),
    )  # fmt: skip
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--area", metavar="POLYGON", help=tr("file with the area in which traces were mapped")
    )
    where.add_argument(
        "--circle",
        metavar="X,Y,R",
        help=tr("count in a circle: centre and radius in metres (X,Y,Z,R on a plane)"),
    )
    where.add_argument(
        "--scanline", metavar="LINE", help=tr("file with one line or several to count along")
    )
    parser.add_argument(
        "--snap", type=float, default=0.0, metavar="M",
        help=tr("how far ends may miss a trace that they abut on, in metres (default 0)"),
    )  # fmt: skip
    parser.add_argument(
        "--plane", metavar="DD/D",
        help=tr("plane of lines with heights (default: best fit, if they are three-dimensional)"),
    )  # fmt: skip
    sets = parser.add_mutually_exclusive_group()
    sets.add_argument(
        "--by", metavar="COLUMN", dest="by",
        help=tr("the attribute that names the sets (default: set, where there is one)"),
    )  # fmt: skip
    sets.add_argument(
        "--strikes", metavar="A-B,...", help=tr("sets by ranges of strike, such as 340-020,060-100")
    )
    parser.add_argument(
        "--terzaghi-cap", type=float, metavar="W",
        help=tr("the largest Terzaghi weight (default: none)"),
    )  # fmt: skip
    parser.add_argument("--layer", metavar="NAME", help=tr("the layer of TRACES"))
    parser.add_argument(
        "--plot", metavar="FILE", help=tr("a picture, by its ending: .svg, .pdf or .png")
    )
    add_frame(parser)
    parser.add_argument(
        "--force", action="store_true", help=tr("replace FILE if it is there already")
    )


def run(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.files.atomic import atomic_write, check_target
    from vomstudio.products.fractures.mapping import (
        FractureOrder,
        map_fractures,
        parse_circle,
        parse_strikes,
    )  # fmt: skip
    from vomstudio.products.net.figure import picture_format
    from vomstudio.products.section.curtain import parse_section_plane

    order = FractureOrder(
        traces=Path(args.traces),
        area=None if args.area is None else Path(args.area),
        circle=None if args.circle is None else parse_circle(args.circle),
        scanline=None if args.scanline is None else Path(args.scanline),
        snap_m=args.snap,
        set_column=args.by,
        strikes=parse_strikes(args.strikes),
        terzaghi_cap=args.terzaghi_cap,
        layer=args.layer,
        plane=None if args.plane is None else parse_section_plane(args.plane),
        frame=frame_options(args),
    )
    format_ = None
    if args.plot is not None:
        format_ = picture_format(args.plot, "--plot")
        inputs = [p for p in (args.traces, args.area, args.scanline) if p is not None]
        check_target(args.plot, force=args.force, inputs=inputs)
    with numbers_of(args.area or args.traces):
        mapped = map_fractures(order, progress=progress_of(args))
    if format_ is not None:
        from vomstudio.products.fractures.figure import write_fractures

        with atomic_write(args.plot, args.force) as temporary:
            write_fractures(temporary, mapped, format=format_)
    result = {**mapped.found.as_dict(), "image": args.plot}
    out.result(result)
    out.warn(mapped.found.warnings)
    out.text(_in_words(mapped.found))
    for note in mapped.found.notes:
        out.note(note)


def _in_words(found: FractureNetwork) -> str:
    from vomstudio.products.fractures.words import figure_rows

    rows = figure_rows(found)
    width = max(len(label) for label, _ in rows)
    return "\n".join(f"{label:<{width}}  {value}" for label, value in rows)
