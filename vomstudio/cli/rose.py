"""`vomstudio rose`: the azimuths of a table as rose diagrams."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common.arguments import (
    Subparsers,
    add_azimuth,
    add_command,
    add_output,
    report_reading,
)
from vomstudio.cli.common.figure_look import add_look, colors_among, colors_of
from vomstudio.cli.common.output import Output
from vomstudio.core.findings import Message
from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.products.net.rose_contents import RoseContents


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers, "rose", run, help_=tr("Draw rose diagrams and histograms of dip")
    )
    parser.add_argument("table", metavar="TABLE", help=tr("table of planes or lines"))
    add_output(parser, tr("the picture, by its ending: .svg, .pdf or .png"), required=True)
    parser.add_argument(
        "--of",
        choices=["strike", "dip-direction", "trend", "dip", "plunge"],
        help=tr("which angle (default: strike, of lines alone trend)"),
    )
    parser.add_argument(
        "--bin", type=float, default=10.0, metavar="DEG", help=tr("width of the bins (default 10)")
    )
    parser.add_argument(
        "--weight", metavar="COLUMN", help=tr("weight by this column, such as the length")
    )
    parser.add_argument("--by", metavar="COLUMN", help=tr("a rose for each group of this column"))
    parser.add_argument(
        "--scale",
        choices=["area", "length"],
        default="area",
        help=tr("what of a petal is its share (default area)"),
    )
    parser.add_argument(
        "--width", metavar="MM", type=float, help=tr("of the figure, in millimetres (default 170)")
    )
    add_look(parser, symbols=False)
    add_azimuth(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.files.atomic import atomic_write, check_target
    from vomstudio.geology.roses import HISTOGRAM_OF, bins_of
    from vomstudio.io.text.orientation_reading import read_orientations
    from vomstudio.products.net.figure import picture_format
    from vomstudio.products.net.figure_style import SIZE_MM, FigureStyle
    from vomstudio.products.net.rose import mean_words
    from vomstudio.products.net.rose_contents import check_roses, roses_of_table

    format_ = picture_format(args.output, "--output")
    if args.of not in HISTOGRAM_OF:
        bins_of(args.bin)
    style = FigureStyle(
        args.width, None, args.font or "", args.font_size, None, args.line_width, args.grey
    )
    style.check("--width")
    colors = colors_of(args)
    check_target(args.output, force=args.force, inputs=[args.table])
    progress = report_reading(args, args.table)
    table = read_orientations(args.table, args.azimuth)
    progress.stage(tr("Drawing the rose diagram"))
    of = args.of or ("strike" if table.is_plane.any() else "trend")
    found = roses_of_table(
        table,
        of,
        args.by,
        bin_deg=args.bin,
        weight=args.weight,
        by_area=args.scale == "area",
    )
    check_roses(found, args.table)
    found = replace(found, colors=colors_among(colors, list(found.roses)))

    from vomstudio.products.net.rose import write_roses

    with atomic_write(args.output, args.force) as temporary:
        write_roses(
            temporary,
            found,
            format=format_,
            style=style.of_net(),
            width_mm=args.width or SIZE_MM[0],
        )
    warnings: list[Message] = list(table.warnings)
    for name, rose in found.roses.items():
        if rose.left_out:
            warnings.append(
                tr(
                    "{set}: {count} rows without azimuth or weight are left out.",
                    set=name,
                    count=rose.left_out,
                )
            )
    warnings += [
        tr("{set}: no row has an azimuth and a weight; it has no rose.", set=name)
        for name in found.empty
    ]
    told = _told(args, of, found, table.convention, table.dropped)
    out.result({**told, "warnings": warnings})
    out.note(tr("read as {convention}", convention=table.convention))
    out.warn(warnings)
    for name, rose in found.roses.items():
        out.text(tr("{set} (n = {count:,}): {mean}", set=name, count=rose.n, mean=mean_words(rose)))


def _told(
    args: argparse.Namespace,
    of: str,
    found: RoseContents,
    convention: str,
    dropped: tuple[int, ...],
) -> dict[str, Any]:
    """The command's object, but for its warnings."""
    from vomstudio.geology.roses import Rose

    return {
        "image": args.output,
        "n": sum(rose.n for rose in found.roses.values()),
        "of": of,
        "axial": of == "strike",
        "bin_deg": args.bin,
        "weight": args.weight,
        "scale": args.scale,
        "sets": {
            name: {
                "n": rose.n,
                "total": rose.total,
                "shares": rose.shares.tolist(),
                "mean_deg": rose.mean_deg,
                "resultant": rose.resultant if isinstance(rose, Rose) else None,
                "rayleigh_p": rose.rayleigh_p if isinstance(rose, Rose) else None,
                "std_deg": None if isinstance(rose, Rose) else rose.std_deg,
                "left_out": rose.left_out,
            }
            for name, rose in found.roses.items()
        },
        "convention": convention,
        "dropped_lines": list(dropped),
    }
