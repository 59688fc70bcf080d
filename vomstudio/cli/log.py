"""`vomstudio log`: bed boundaries along a line and the thicknesses between them."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from vomstudio.cli.common import text_tables
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
from vomstudio.cli.common.unitless_lengths import add_unitless_names
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.beds.log_options import LogLine, LogOptions

if TYPE_CHECKING:
    from vomstudio.geology.beds.bed_log import BedLog
    from vomstudio.geology.orientation import Plane


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``log`` command."""
    parser = add_command(
        subparsers,
        "log",
        run,
        help_=tr("Compute a log of true bed thicknesses along a line, with errors"),
    )
    parser.add_argument(
        "table",
        metavar="TABLE",
        help=tr("table with one point per boundary, in metres; or a project, with --line"),
    )
    add_output(parser, tr("output table"))
    add_options(parser, LogLine)
    add_options(parser, LogOptions)
    add_frame(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio log``.

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
    from vomstudio.core.files.extensions import check_table_target
    from vomstudio.geology.notation import parse_plane_option
    from vomstudio.products.net.figure import picture_format
    from vomstudio.products.section.decimals import format_with_error
    from vomstudio.project.tables.log_table import describe_log_inputs, write_log

    is_project = Path(args.table).is_dir()
    _check_options(args, is_project)
    options, line = parse_options(args, LogOptions), parse_options(args, LogLine)
    bed = None if args.bed is None else parse_plane_option(args.bed, "--bed")
    inputs = [] if is_project else [args.table]
    if args.output is not None:
        check_table_target(args.output, force=args.force, inputs=inputs)
    if args.plot is not None:
        format_ = picture_format(args.plot, "--plot")
        check_target(args.plot, force=args.force, inputs=[*inputs, *filter(None, [args.output])])
    compute_log = (
        _project_log(args, line, bed, options) if is_project else _table_log(args, bed, options)
    )
    log = compute_log.log
    description = describe_log_inputs(compute_log.bed, compute_log.bed95_deg)
    if args.plot is not None:
        from vomstudio.products.section.bed_log_figure import write_log_figure

        with atomic_write(args.plot, args.force) as temporary:
            write_log_figure(
                temporary,
                log,
                format=format_,
                description=description,
                is_metric=compute_log.is_metric,
            )
    if args.output is not None:
        write_log(
            args.output,
            log,
            description=description,
            is_metric=compute_log.is_metric,
            force=args.force,
        )
    result = {
        **log.to_dict(),
        "table": args.output,
        "image": args.plot,
        "dropped_lines": list(compute_log.dropped),
        "line": args.line,
        "bed": {
            "dip_direction_deg": compute_log.bed.dip_direction_deg,
            "dip_deg": compute_log.bed.dip_deg,
            "error95_deg": compute_log.bed95_deg,
            "traces": list(compute_log.bed_traces),
        },
        "sigma_m": compute_log.sigma_m,
    }
    out.result(add_unitless_names(result, is_metric=compute_log.is_metric))
    out.warn(log.warnings)
    headers = [tr("bed"), tr("from"), tr("to"), tr("thickness"), tr("lithology"), tr("notes")]
    rows = [
        [
            str(i.number),
            i.base,
            i.top,
            format_with_error(i.thickness_m.value, i.thickness_m.error95),
            i.lithology,
            i.notes,
        ]
        for i in reversed(log.intervals)
    ]
    heading = tr("True thickness in metres, with 95 % errors, youngest bed on top")
    if not compute_log.is_metric:
        heading = tr("True thickness in model units, with 95 % errors, youngest bed on top")
    out.text(heading + "\n" + text_tables.table(headers, [""] * len(headers), rows))


class _LogResult(NamedTuple):
    """Result of the command.

    Parameters
    ----------
    dropped : tuple of int
        Lines of the table that have no coordinates.
    is_metric : bool
        Whether lengths are in metres.
    bed_traces : tuple of str
        Names of the traces to which the bedding plane was fitted.
    """

    log: BedLog
    bed: Plane
    bed95_deg: float
    sigma_m: float
    dropped: tuple[int, ...] = ()
    is_metric: bool = True
    bed_traces: tuple[str, ...] = ()


def _check_options(args: argparse.Namespace, is_project: bool) -> None:
    """Check the combination of options. Raises UsageError."""
    if is_project and args.line is None:
        raise UsageError(Finding("log.line-not-given"), field="--line")
    if not is_project and args.line is not None:
        raise UsageError(Finding("log.not-a-project", table=args.table), field="--line")
    if is_project and frame_options(args).is_given:
        raise UsageError(Finding("option.not-with-project"), field=frame_options(args).first_option)
    if not is_project and args.bed is None:
        raise UsageError(Finding("log.no-bed"), field="--bed")
    if is_project and args.bed is None and args.bed_error_deg is not None:
        raise UsageError(
            Finding("option.requires", option="--bed-error", other="--bed"), field="--bed-error"
        )


def _table_log(args: argparse.Namespace, bed: Plane | None, options: LogOptions) -> _LogResult:
    from vomstudio.geology.beds.bed_log import bed_log
    from vomstudio.io.gate.point_tables import read_boundaries

    assert bed is not None
    progress = report_reading(args, args.table)
    boundaries = read_boundaries(args.table, frame_options(args))
    progress.stage(tr("Measuring thicknesses"))
    sigma, error = options.sigma_m or 0.0, options.bed_error_deg or 0.0
    with name_input_in_errors(args.table):
        log = bed_log(
            boundaries.points,
            bed,
            names=boundaries.names,
            lithologies=boundaries.lithologies,
            notes=boundaries.notes,
            sigma_m=sigma,
            bed_error_deg=error,
            overturned=options.overturned,
        )
    log = replace(log, warnings=(*boundaries.warnings, *log.warnings))
    return _LogResult(log, bed, error, sigma, boundaries.dropped)


def _project_log(
    args: argparse.Namespace, line: LogLine, bed: Plane | None, options: LogOptions
) -> _LogResult:
    from vomstudio.products.section.line_log import TRACES, compute_log
    from vomstudio.products.section.project_log import read_log_request

    progress = report_reading(args, args.table)
    log_request = read_log_request(
        Path(args.table),
        line.line or "",
        of=line.of or TRACES,
        type_name=line.type or "bedding",
        bed=bed,
        options=options,
        reach_m=line.reach_m,
    )
    progress.stage(tr("Measuring thicknesses"))
    with name_input_in_errors(args.table):
        project_log = compute_log(log_request)
    q = project_log.request
    names = tuple(q.names[id_] for id_ in project_log.bed_ids)
    return _LogResult(
        project_log.log,
        project_log.bed,
        project_log.bed95_deg,
        project_log.sigma_m,
        (),
        q.is_metric,
        names,
    )
