"""`vomstudio fit`: planes from points in a text table."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common import curved_beds, straight_traces, text_tables
from vomstudio.cli.common.arguments import (
    Subparsers,
    add_command,
    add_output,
    report_reading,
)
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.error_context import name_input_in_errors
from vomstudio.cli.common.frame_arguments import add_frame, frame_options
from vomstudio.cli.common.output import Output
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.tables.fit_options import FitOptions, FitTogether

if TYPE_CHECKING:
    from vomstudio.geology.beds.parallel import ParallelBeds
    from vomstudio.io.text.tables import PointGroups


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``fit`` command."""
    parser = add_command(
        subparsers, "fit", run, help_=tr("Fit planes to points and assess their quality")
    )
    parser.add_argument("points", metavar="POINTS", help=tr("text table with x, y, z"))
    add_options(parser, FitOptions)
    add_options(parser, FitTogether)
    straight_traces.add_set_options(parser)
    add_frame(parser)
    add_output(parser, tr("write the orientation table as CSV"))


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio fit``.

    Parameters
    ----------
    args : Namespace
        Parsed arguments.
    out : Output
        Object that receives the results, warnings and progress.

    Raises
    ------
    GeometryError
        If no plane can be fitted.
    UsageError, InputError, TargetError
    """
    from vomstudio.core.files.extensions import check_table_target
    from vomstudio.geology.profiles import PROFILES_BY_NAME
    from vomstudio.io.gate.point_tables import read_points
    from vomstudio.project.tables.fitted_planes import fitted_planes
    from vomstudio.project.tables.orientation_table import write_orientation_csv

    options, joint_options = parse_options(args, FitOptions), parse_options(args, FitTogether)
    if args.output is not None:
        check_table_target(args.output, force=args.force, inputs=[args.points])
    plot_format = None if args.plot is None else _plot_format(args)
    priors = straight_traces.read_sets(args)
    limits = PROFILES_BY_NAME[options.profile]
    progress = report_reading(args, args.points)
    point_table = read_points(args.points, options.by, frame_options(args))
    groups = point_table.groups
    fitted_groups = fitted_planes(
        groups.ids,
        groups.points,
        groups.offsets,
        method=options.method,
        axis=options.axis,
        thresholds=limits,
        metadata=groups.words,
        progress=progress,
    )
    rows, skipped_groups = fitted_groups.rows, fitted_groups.skipped
    if joint_options.parallel or joint_options.curved:
        progress.stage(tr("Fitting all traces together"))
    parallel_fit = (
        _fit_parallel_beds(args.points, joint_options.same, groups)
        if joint_options.parallel
        else None
    )
    curved_bed = curved_beds.fit_curved_bed(args.points, groups) if joint_options.curved else None
    bands = straight_traces.figures_by_trace(fitted_groups.bands, priors)
    crossings = straight_traces.crossings(joint_options.crossing, groups.ids, fitted_groups.bands)
    if not rows and parallel_fit is None and curved_bed is None:
        raise _no_fit_error(args.points, options.by, skipped_groups)
    progress.stage(tr("Writing the results"))
    result: dict[str, Any] = {
        "planes": rows,
        "skipped": skipped_groups,
        "bands": [{"id": name, **band.to_dict()} for name, band in bands.items()],
        "crossings": crossings,
        "dropped_lines": list(groups.dropped),
        "warnings": list(groups.warnings),
    }
    if parallel_fit is not None:
        result["parallel"] = asdict(parallel_fit)
        result["warnings"] += parallel_fit.warnings
    if curved_bed is not None:
        result["curved"] = curved_bed
    if args.output is not None:
        write_orientation_csv(
            args.output, rows, limits=limits, crs=point_table.crs, force=args.force
        )
        result["table"] = args.output
    if plot_format is not None:
        from vomstudio.core.files.atomic import atomic_write
        from vomstudio.products.net.shape_figure import write_shapes

        with atomic_write(args.plot, args.force) as temporary:
            write_shapes(temporary, rows, format=plot_format)
        result["image"] = args.plot
    out.result(result)
    out.warn(result["warnings"])
    out.warn(
        [
            Finding("feature.left-out", feature=str(item["id"]), reason=item["reason"])
            for item in skipped_groups
        ]
    )
    if rows:
        out.text(f"{_result_text(rows)}\n{limits.description}")
    for name, band in bands.items():
        out.text("\n".join(f"{name}: {line}" for line in straight_traces.band_lines(band)))
    for crossing in crossings:
        out.text(straight_traces.crossing_text(crossing))
    if parallel_fit is not None:
        out.text(f"\n{_parallel_text(parallel_fit)}")
    if curved_bed is not None:
        out.text(f"\n{curved_beds.result_text(curved_bed)}")


def _plot_format(args: argparse.Namespace) -> str:
    """Check the target of the figure and return its format. Raises UsageError, TargetError."""
    from vomstudio.core.files.atomic import check_target
    from vomstudio.products.net.figure import picture_format

    format_ = picture_format(args.plot, "--plot")
    check_target(args.plot, force=args.force, inputs=[args.points])
    return format_


def _fit_parallel_beds(
    path: str, same_bed_pairs: Sequence[str], groups: PointGroups
) -> ParallelBeds:
    from vomstudio.geology.beds.parallel import parallel_beds

    pairs = [straight_traces.trace_pair(text, groups.ids, "--same") for text in same_bed_pairs]
    with name_input_in_errors(path, "--parallel"):
        return parallel_beds(groups.ids, groups.points, groups.offsets, pairs=pairs)


def _parallel_text(parallel_fit: ParallelBeds) -> str:
    summary = tr(
        "Joint fit of parallel planes: {plane} (dip direction/dip ± maximum 95 % error; minimum"
        " {smallest} deg), RMS {rms} m, p {p} for parallel planes",
        plane=text_tables.plane_with_error(vars(parallel_fit), "max_confidence95_deg"),
        smallest=text_tables.figures(parallel_fit.min_confidence95_deg),
        rms=text_tables.figures(parallel_fit.rms_m),
        p=text_tables.figures(parallel_fit.p_parallel),
    )
    bed_table = text_tables.table(
        [tr("id"), tr("n"), tr("distance"), tr("95 %"), tr("rms")],
        ["", "", "m", "m", "m"],
        [
            [
                bed.id,
                str(bed.n),
                f"{bed.distance_m:.3f}",
                text_tables.figures(bed.error95_m),
                text_tables.figures(bed.rms_m),
            ]
            for bed in parallel_fit.beds
        ],
    )
    pair_table = text_tables.table(
        [tr("first"), tr("second"), tr("apart"), tr("95 %"), tr("p, one plane")],
        ["", "", "m", "m", ""],
        [
            [
                item.first,
                item.second,
                f"{item.distance_m:.3f}",
                text_tables.figures(item.error95_m),
                text_tables.figures(item.p),
            ]
            for item in parallel_fit.same
        ],
    )
    return "\n".join([summary, bed_table, *([pair_table] if parallel_fit.same else [])])


def _no_fit_error(path: str, by: str | None, skipped_groups: list[dict[str, Any]]) -> GeometryError:
    first_skipped = skipped_groups[0]
    if by is None:
        return GeometryError(first_skipped["reason"], file=path)
    return GeometryError(
        Finding("plane.none-fitted", count=len(skipped_groups), reason=first_skipped["reason"]),
        file=path,
        field=f"{by} {first_skipped['id']}",
    )


def _result_text(rows: list[dict[str, Any]]) -> str:
    from vomstudio.geology.notation import attitude_decimals, format_azimuth

    headers = [
        tr("id"),
        tr("n"),
        tr("plane"),
        tr("strike"),
        tr("fit 95 %"),
        tr("ang. error"),
        tr("rms"),
        tr("extent"),
        tr("quality"),
    ]
    error_unit = tr("deg max/min")
    plane_unit = tr("dip direction/dip ± 95 %")
    units = ["", "", plane_unit, tr("deg RHR"), error_unit, error_unit, "m", "m", ""]
    body = [
        [
            str(row["id"]),
            str(row["n_points"]),
            text_tables.plane_with_error(row),
            "-"
            if row["undefined"]
            else format_azimuth(row["strike_rhr_deg"], attitude_decimals(row["total95_deg"])),
            _pair(row, "confidence95"),
            _pair(row, "angular_error"),
            text_tables.figures(row["rms_m"]),
            text_tables.figures(row["extent_m"]),
            row["quality"],
        ]
        for row in rows
    ]
    reasons = [
        tr(
            "{plane} is {verdict}: {reasons}",
            plane=row["id"],
            verdict=row["quality"],
            reasons=row["quality_reason"],
        )
        for row in rows
        if row["quality_reason"]
    ]
    return "\n".join([text_tables.table(headers, units, body), *reasons])


def _pair(row: dict[str, Any], name: str) -> str:
    max_deg, min_deg = row[f"max_{name}_deg"], row[f"min_{name}_deg"]
    return f"{text_tables.number(max_deg, 4)}/{text_tables.number(min_deg, 4)}"
