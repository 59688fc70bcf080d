"""`vomstudio stereonet`: stereonet of the orientations in a table."""

from __future__ import annotations

import argparse
from dataclasses import asdict
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
from vomstudio.products.net.figure_options import SetColors, StereonetFigure, StereonetOptions

if TYPE_CHECKING:
    from vomstudio.geology.orientation_rows import OrientationRows
    from vomstudio.products.net.contents import NetContents

OPTION_CLASSES: tuple[type[Any], ...] = (StereonetOptions, StereonetFigure, SetColors)


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``stereonet`` command."""
    parser = add_command(
        subparsers,
        "stereonet",
        run,
        help_=tr("Draw a lower-hemisphere stereonet as SVG, PDF or PNG"),
    )
    parser.add_argument("table", metavar="TABLE", help=tr("table of planes or lines, or a project"))
    add_output(parser, tr("output figure (.svg, .pdf or .png)"), is_required=True)
    for options in OPTION_CLASSES:
        add_options(parser, options)
    add_table_options(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio stereonet``.

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
    from vomstudio.products.net.preparation import additions_from_options, contouring_from_options
    from vomstudio.products.net.table_net import net_from_table, replace_colors

    format_ = picture_format(args.output, "--output")
    options = parse_options(args, StereonetOptions)
    net_request = additions_from_options(options)
    style = FigureStyle.from_options(parse_options(args, StereonetFigure))
    colors = parse_options(args, SetColors).colors_by_set
    check_target(args.output, force=args.force, inputs=[args.table])
    progress = report_reading(args, args.table)
    table = read_table_picks(args, args.table)
    progress.stage(tr("Drawing the stereonet"))
    net = net_from_table(
        table,
        options.by,
        projection=options.projection,
        contour=options.contour,
        contouring=contouring_from_options(options),
    )
    net = replace_colors(net, select_colors(colors, [s.name for s in net.sets]))
    net = net_request.net(net, table)

    from vomstudio.products.net.figure import write_stereonet

    with atomic_write(args.output, args.force) as temporary:
        write_stereonet(
            temporary,
            net,
            format=format_,
            style=style.net_style(),
            width_mm=style.width_mm,
            height_mm=style.height_mm,
        )
    progress.stage(tr("Writing the results"))
    _report(args, options, table, net, out)


def _report(
    args: argparse.Namespace,
    options: StereonetOptions,
    table: OrientationRows,
    net: NetContents,
    out: Output,
) -> None:
    from vomstudio.geology.table_folds import not_good_warning
    from vomstudio.products.net.contours import check_contour_sizes, describe_density

    density = describe_density(net)
    warnings = [*table.warnings, *check_contour_sizes(net)]
    fold = net.fold
    if fold is not None:
        warnings += not_good_warning(net.fold_not_good_count, fold.n)
    if density is not None and not density["levels"]:
        warnings.append(Finding("contours.none"))
    out.result(
        {
            "image": args.output,
            "n": len(table),
            "sets": {s.name: len(s) for s in net.sets},
            "projection": options.projection,
            "hemisphere": "lower",
            "untilted_by": options.untilt,
            "rotated_by": options.rotate,
            "circles": [circle.label for circle in net.user_circles],
            "marks": [
                {
                    "label": mark.label,
                    "trend_deg": mark.line.trend_deg,
                    "plunge_deg": mark.line.plunge_deg,
                }
                for mark in net.marks
            ],
            "averages": list(net.averages),
            "errors": len(net.errors),
            "fold": None
            if fold is None
            else {"n": fold.n, "not_good": net.fold_not_good_count, **asdict(fold.figures.beta)},
            "contour": options.contour,
            "density": density,
            "convention": table.convention,
            "dropped_lines": list(table.dropped),
            "warnings": warnings,
        }
    )
    out.note(tr("read {convention}", convention=table.convention))
    out.warn(warnings)
    sets = ", ".join(f"{s.name} (n = {len(s)})" for s in net.sets)
    out.text(
        tr("{file}: {sets}; equal area, lower hemisphere", file=args.output, sets=sets)
        if options.projection == "area"
        else tr("{file}: {sets}; equal angle, lower hemisphere", file=args.output, sets=sets)
    )
    if density is not None:
        _report_maximum(density, out)


def _report_maximum(density: dict[str, Any], out: Output) -> None:
    from vomstudio.geology.notation import format_azimuth

    for part in density["parts"]:
        out.text(
            tr(
                "maximum density: {name} {trend}/{plunge:02.0f} (trend/plunge), {value:.1f} {unit}",
                name=part["set"] or tr("all"),
                trend=format_azimuth(part["trend_deg"]),
                plunge=part["plunge_deg"],
                value=part["maximum"],
                unit=tr(density["unit"]),
            )
        )
