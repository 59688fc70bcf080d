"""`vomstudio stereonet`: the orientations of a table as a picture."""

from __future__ import annotations

import argparse
from dataclasses import asdict
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
from vomstudio.errors import UsageError
from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.geology.orientation_rows import OrientationRows
    from vomstudio.products.net.contents import NetContents
    from vomstudio.products.net.net_wishes import NetWishes


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
        "--by",
        metavar="COLUMN",
        help=tr("colour by this column (name or number)"),
    )
    _add_contours(parser)
    parser.add_argument(
        "--projection",
        choices=["area", "angle"],
        default="area",
        help=tr("equal area or equal angle"),
    )
    _add_drawn(parser)
    _add_style(parser)
    add_azimuth(parser)


def _add_contours(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--contour",
        metavar="METHOD",
        help=tr("density by exponential_kamb, linear_kamb, kamb or schmidt"),
    )
    parser.add_argument(
        "--levels",
        metavar="A,B,...",
        help=tr("levels of the contours: standard deviations, of schmidt percent"),
    )
    parser.add_argument(
        "--filled",
        action=argparse.BooleanOptionalAction,
        help=tr("contours filled, or lines (default: filled, lines with --each-set)"),
    )
    parser.add_argument(
        "--each-set", action="store_true", help=tr("contours of each set by itself, in its colour")
    )
    parser.add_argument(
        "--kamb-sigma",
        type=float,
        default=3.0,
        help=tr("smoothness of Kamb's methods: what a uniform scatter has (default 3)"),
    )


def _add_drawn(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--untilt",
        metavar="DD/D",
        help=tr(
            "turn everything, also what is typed here, so that this plane (dip direction/dip) "
            "becomes horizontal"
        ),
    )
    parser.add_argument(
        "--rotate",
        metavar="T/P/ANGLE",
        help=tr("turn everything about an axis (trend/plunge), by the right-hand rule"),
    )
    parser.add_argument(
        "--intersections",
        action="store_true",
        help=tr("the lines in which each two of the planes meet"),
    )
    parser.add_argument(
        "--plane",
        action="append",
        default=[],
        metavar="DD/D",
        help=tr("draw this great circle too; may be given again"),
    )
    parser.add_argument(
        "--cone",
        action="append",
        default=[],
        metavar="T/P/ANGLE",
        help=tr("draw this small circle about an axis (trend/plunge); may be given again"),
    )
    parser.add_argument(
        "--slip-line",
        action="append",
        default=[],
        metavar="DD/D/RAKE",
        help=tr("draw this plane and the line in it with this rake; may be given again"),
    )
    for option, of in (
        ("--girdles", tr("the great circle that each set fits best")),
        ("--maxima", tr("mark where each set, or all as contoured, is densest")),
        ("--errors", tr("the 95 %% ellipse of each plane, by the error columns of the table")),
        ("--averages", tr("the averages of each set in words, with n and method")),
    ):
        parser.add_argument(option, action="store_true", help=of)
    parser.add_argument(
        "--fold", action="store_true", help=tr("the fold axis of the bedding and its great circle")
    )
    parser.add_argument(
        "--quality",
        choices=("good", "doubtful"),
        help=tr("planes of the fold axis: none with a worse verdict"),
    )
    parser.add_argument(
        "--only-set", metavar="SET", help=tr("planes of the fold axis: of this set only")
    )


def _add_style(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--size",
        metavar="WxH",
        help=tr("of the figure, in millimetres (default 170, and as high as its words need)"),
    )
    add_look(parser, symbols=True)


def run(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.files.atomic import atomic_write, check_target
    from vomstudio.geology.density import DENSITY_METHODS
    from vomstudio.io.text.orientation_reading import read_orientations
    from vomstudio.products.net.contents import Contouring
    from vomstudio.products.net.contours import check_contouring
    from vomstudio.products.net.figure import picture_format
    from vomstudio.products.net.figure_style import FigureStyle, size_of
    from vomstudio.products.net.table_net import net_of_table, recoloured

    format_ = picture_format(args.output, "--output")
    if args.contour is not None and args.contour not in DENSITY_METHODS:
        raise UsageError(
            tr(
                "'{method}' is not a density method. Use {methods}.",
                method=args.contour,
                methods=", ".join(DENSITY_METHODS),
            ),
            field="--contour",
        )
    levels = _levels(args.levels)
    style = FigureStyle(
        *size_of(args.size), args.font or "", args.font_size, args.symbol_size, args.line_width,
        args.grey,
    )  # fmt: skip
    style.check()
    colors = colors_of(args)
    check_contouring(args.contour, levels, args.kamb_sigma)
    look = Contouring(levels, args.filled, args.each_set, args.kamb_sigma)
    wishes = _wishes(args)
    check_target(args.output, force=args.force, inputs=[args.table])
    progress = report_reading(args, args.table)
    table = read_orientations(args.table, args.azimuth)
    progress.stage(tr("Drawing the stereonet"))
    net = net_of_table(
        table,
        args.by,
        projection=args.projection,
        contour=args.contour,
        contouring=look,
    )
    net = recoloured(net, colors_among(colors, [s.name for s in net.sets]))
    net = wishes.net(net, table)

    from vomstudio.products.net.figure import write_stereonet

    with atomic_write(args.output, args.force) as temporary:
        write_stereonet(
            temporary, net, format=format_, style=style.of_net(),
            width_mm=style.width_mm, height_mm=style.height_mm,
        )  # fmt: skip
    progress.stage(tr("Writing the results"))
    _tell(args, table, net, out)


def _tell(args: argparse.Namespace, table: OrientationRows, net: NetContents, out: Output) -> None:
    from vomstudio.geology.table_folds import not_good_warning
    from vomstudio.products.net.contours import density_found, few_for_contours

    found = density_found(net)
    warnings = [*table.warnings, *few_for_contours(net)]
    fold = net.fold
    if fold is not None:
        warnings += not_good_warning(net.fold_not_good, fold.n)
    if found is not None and not found["levels"]:
        warnings.append(tr("Nothing is dense enough for a contour."))
    out.result(
        {
            "image": args.output,
            "n": len(table),
            "sets": {s.name: len(s) for s in net.sets},
            "projection": args.projection,
            "hemisphere": "lower",
            "untilted_by": args.untilt,
            "rotated_by": args.rotate,
            "circles": [circle.label for circle in net.circles_typed],
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
            else {"n": fold.n, "not_good": net.fold_not_good, **asdict(fold.figures.beta)},
            "contour": args.contour,
            "density": found,
            "convention": table.convention,
            "dropped_lines": list(table.dropped),
            "warnings": warnings,
        }
    )
    out.note(tr("read as {convention}", convention=table.convention))
    out.warn(warnings)
    sets = ", ".join(f"{s.name} (n = {len(s)})" for s in net.sets)
    out.text(
        tr("{file}: {sets}; equal area, lower hemisphere", file=args.output, sets=sets)
        if args.projection == "area"
        else tr("{file}: {sets}; equal angle, lower hemisphere", file=args.output, sets=sets)
    )
    if found is not None:
        _say_densest(found, out)


def _wishes(args: argparse.Namespace) -> NetWishes:
    """Read before anything else is. Raises UsageError."""
    if not args.fold and (args.quality is not None or args.only_set is not None):
        raise UsageError(
            tr("--quality and --only-set choose the planes of --fold. Add --fold."), field="--fold"
        )
    from vomstudio.geology.fold_planes import FoldFilter
    from vomstudio.products.net.net_options import (
        Turning,
        plane_of,
        turn_of,
        typed_cone,
        typed_plane,
        typed_slip,
    )
    from vomstudio.products.net.net_wishes import FINDINGS, NetWishes

    plane = None if args.untilt is None else plane_of(args.untilt, "--untilt")
    slips = [typed_slip(text) for text in args.slip_line]
    return NetWishes(
        Turning(plane) if args.rotate is None else Turning(plane, *turn_of(args.rotate)),
        (
            *map(typed_plane, args.plane),
            *map(typed_cone, args.cone),
            *(circle for circle, _ in slips),
        ),
        tuple(mark for _, mark in slips),
        frozenset(name for name in FINDINGS if getattr(args, name)),
        args.intersections,
        args.errors,
        FoldFilter(args.quality, args.only_set) if args.fold else None,
    )


def _say_densest(found: dict[str, Any], out: Output) -> None:
    from vomstudio.geology.notation import format_azimuth

    for part in found["parts"]:
        out.text(
            tr(
                "densest: {name} {trend}/{plunge:02.0f} (trend/plunge), {value:.1f} {unit}",
                name=part["set"] or tr("all"),
                trend=format_azimuth(part["trend_deg"]),
                plunge=part["plunge_deg"],
                value=part["maximum"],
                unit=tr(found["unit"]),
            )
        )


def _levels(text: str | None) -> tuple[float, ...]:
    """Ascending, each once."""
    if text is None:
        return ()
    try:
        return tuple(sorted({float(word) for word in text.split(",")}))
    except ValueError:
        raise UsageError(
            tr("“{text}” is no list of levels; write them like 2,4,6.", text=text), field="--levels"
        ) from None
