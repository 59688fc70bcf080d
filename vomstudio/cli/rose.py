"""`vomstudio rose`: rose diagrams of the azimuths in a table."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common.arguments import (
    Subparsers,
    add_command,
    add_output,
    report_reading,
)
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.orientation_tables import add_table_options, read_table_picks
from vomstudio.cli.common.output import Output
from vomstudio.cli.common.set_colors import select_colors
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.rose_options import RoseOptions
from vomstudio.products.net.figure_options import SIZE_MM, RoseFigure, SetColors

if TYPE_CHECKING:
    from vomstudio.products.net.rose_contents import RoseContents

OPTION_CLASSES: tuple[type[Any], ...] = (RoseOptions, RoseFigure, SetColors)


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``rose`` command."""
    parser = add_command(
        subparsers,
        "rose",
        run,
        help_=tr("Draw rose diagrams of azimuths, or histograms of dips or plunges"),
    )
    parser.add_argument("table", metavar="TABLE", help=tr("table of planes or lines, or a project"))
    add_output(parser, tr("output figure (.svg, .pdf or .png)"), is_required=True)
    for options in OPTION_CLASSES:
        add_options(parser, options)
    add_table_options(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio rose``.

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
    from vomstudio.products.net.figure import picture_format
    from vomstudio.products.net.figure_style import FigureStyle
    from vomstudio.products.net.rose import describe_mean
    from vomstudio.products.net.rose_contents import check_roses, roses_from_table

    format_ = picture_format(args.output, "--output")
    options, figure = parse_options(args, RoseOptions), parse_options(args, RoseFigure)
    style, colors = FigureStyle.from_options(figure), parse_options(args, SetColors).colors_by_set
    check_target(args.output, force=args.force, inputs=[args.table])
    progress = report_reading(args, args.table)
    table = read_table_picks(args, args.table, azimuth_only=True)
    progress.stage(tr("Drawing the rose diagram"))
    angle_kind = options.of or ("strike" if table.is_plane.any() else "trend")
    roses = roses_from_table(
        table,
        angle_kind,
        options.by,
        bin_deg=options.bin_deg,
        weight=options.weight,
        is_area_scaled=options.scale == "area",
    )
    check_roses(roses, args.table)
    roses = replace(roses, colors=select_colors(colors, list(roses.roses)))

    from vomstudio.products.net.rose import write_roses

    with atomic_write(args.output, args.force) as temporary:
        write_roses(
            temporary,
            roses,
            format=format_,
            style=style.net_style(),
            width_mm=figure.width_mm or SIZE_MM[0],
        )
    warnings: list[Finding] = list(table.warnings)
    for name, rose in roses.roses.items():
        if rose.left_out:
            warnings.append(Finding("rose.rows-left-out", set=name, count=rose.left_out))
    warnings += [Finding("rose.no-azimuth", set=name) for name in roses.empty]
    result = _result_without_warnings(
        args, options, angle_kind, roses, table.convention, table.dropped
    )
    out.result({**result, "warnings": warnings})
    out.note(tr("read {convention}", convention=table.convention))
    out.warn(warnings)
    for name, rose in roses.roses.items():
        out.text(
            tr("{set} (n = {count:,}): {mean}", set=name, count=rose.n, mean=describe_mean(rose))
        )


def _result_without_warnings(
    args: argparse.Namespace,
    options: RoseOptions,
    angle_kind: str,
    roses: RoseContents,
    convention: str,
    dropped_indices: tuple[int, ...],
) -> dict[str, Any]:
    """Return the result of the command without its warnings."""
    from vomstudio.geology.roses import Rose

    return {
        "image": args.output,
        "n": sum(rose.n for rose in roses.roses.values()),
        "of": angle_kind,
        "axial": angle_kind == "strike",
        "bin_deg": options.bin_deg,
        "weight": options.weight,
        "scale": options.scale,
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
            for name, rose in roses.roses.items()
        },
        "convention": convention,
        "dropped_lines": list(dropped_indices),
    }
