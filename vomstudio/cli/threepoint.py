"""`vomstudio threepoint`: plane through three or more points, with its errors."""

from __future__ import annotations

import argparse

from vomstudio.cli.common.arguments import Subparsers, add_command, report_reading
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.error_context import name_input_in_errors
from vomstudio.cli.common.frame_arguments import add_frame, frame_options
from vomstudio.cli.common.output import Output
from vomstudio.core.words import tr
from vomstudio.geology.faults.displacement_options import ThreePointOptions


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``threepoint`` command."""
    parser = add_command(
        subparsers, "threepoint", run, help_=tr("Fit a plane to three or more points, with errors")
    )
    parser.add_argument(
        "points", metavar="POINTS", help=tr("table of three or more points, in metres")
    )
    add_options(parser, ThreePointOptions)
    add_frame(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio threepoint``.

    Parameters
    ----------
    args : Namespace
        Parsed arguments.
    out : Output
        Object that receives the results, warnings and progress.

    Raises
    ------
    UsageError, InputError, GeometryError
    """
    from vomstudio.geology.faults.three_points import plane_of_three_points
    from vomstudio.geology.notation import format_attitude
    from vomstudio.io.gate.point_tables import read_boundaries

    options = parse_options(args, ThreePointOptions)
    progress = report_reading(args, args.points)
    point_table = read_boundaries(args.points, frame_options(args))
    progress.stage(tr("Fitting the plane"))
    with name_input_in_errors(args.points):
        result = plane_of_three_points(point_table.points, options.sigma_m)
    result = result.with_table_findings(point_table.dropped, point_table.warnings)
    out.result(result.to_dict())
    out.warn(result.warnings)
    attitude = format_attitude(result.plane, result.max_confidence95_deg)
    if result.max_confidence95_deg is None:
        out.text(tr("{plane}; its error is unknown", plane=attitude))
        return
    if result.dip_direction_error_deg is None:
        out.text(
            tr(
                "{plane} (95 %): dip ± {dip:.1f}°, dip direction unknown",
                plane=attitude,
                dip=result.dip_error_deg,
            )
        )
        return
    out.text(
        tr(
            "{plane} (95 %): dip ± {dip:.1f}°, dip direction ± {direction:.1f}°",
            plane=attitude,
            dip=result.dip_error_deg,
            direction=result.dip_direction_error_deg,
        )
    )
