"""`vomstudio log`: boundaries of beds along a line, and the thickness between them."""

from __future__ import annotations

import argparse

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.angles import plane_of
from vomstudio.cli.common.arguments import Subparsers, add_command, add_output
from vomstudio.cli.common.naming import numbers_of
from vomstudio.cli.common.output import Output
from vomstudio.words import tr


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers, "log", run, help_=tr("True thicknesses along a line, with errors")
    )
    parser.add_argument(
        "table", metavar="TABLE", help=tr("table of a point on each boundary, in metres")
    )
    add_output(parser, tr("the log as a table"))
    parser.add_argument(
        "--plot", metavar="FILE", help=tr("also the column of beds, .svg, .pdf or .png")
    )
    parser.add_argument("--bed", metavar="DD/D", required=True, help=tr("attitude of the beds"))
    for option, of in (
        ("--sigma", tr("standard deviation of each coordinate, in metres")),
        ("--bed-error", tr("half-angle of the bedding's 95 %% cone, in degrees")),
    ):
        parser.add_argument(option, type=float, default=0.0, metavar="N", help=of)
    parser.add_argument("--overturned", action="store_true", help=tr("younger beds lie below"))


def run(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.files.atomic import atomic_write, check_target
    from vomstudio.geology.beds.bed_log import bed_log
    from vomstudio.io.text.log_reading import read_boundaries
    from vomstudio.products.net.figure import picture_format
    from vomstudio.tables.log_table import about_log, write_log

    bed = plane_of(args.bed, "--bed")
    if args.output is not None:
        check_target(args.output, force=args.force, inputs=[args.table])
    if args.plot is not None:
        format_ = picture_format(args.plot, "--plot")
        check_target(
            args.plot, force=args.force, inputs=[p for p in (args.table, args.output) if p]
        )
    read = read_boundaries(args.table)
    with numbers_of(args.table):
        found = bed_log(
            read.points, bed, names=read.names, lithologies=read.lithologies, notes=read.notes,
            sigma_m=args.sigma, bed_error_deg=args.bed_error, overturned=args.overturned,
        )  # fmt: skip
    about = about_log(bed, args.bed_error)
    if args.plot is not None:
        from vomstudio.products.section.bed_log_figure import write_log_figure

        with atomic_write(args.plot, args.force) as temporary:
            write_log_figure(temporary, found, format=format_, about=about)
    if args.output is not None:
        write_log(args.output, found, about=about, force=args.force)
    out.result(
        {
            **found.as_dict(),
            "table": args.output,
            "image": args.plot,
            "dropped_lines": list(read.dropped),
        }
    )
    out.warn(found.warnings)
    heads = [tr("bed"), tr("from"), tr("to"), tr("thickness"), "+-", tr("lithology"), tr("notes")]
    rows = [
        [str(i.number), i.base, i.top, text_tables.number(i.thickness_m.value, 3),
         text_tables.number(i.thickness_m.error95, 3), i.lithology, i.notes]
        for i in reversed(found.intervals)
    ]  # fmt: skip
    out.text(
        tr("Metres across the bedding, errors 95 %, the youngest bed on top")
        + "\n" + text_tables.table(heads, [""] * len(heads), rows)
    )  # fmt: skip
