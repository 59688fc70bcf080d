"""`vomstudio compare`: distances of a model from a benchmark."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import (
    Subparsers,
    add_command,
    add_output,
    progress_reporter,
    report_reading,
)
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.error_context import name_input_in_errors
from vomstudio.cli.common.frame_arguments import add_frame, frame_options
from vomstudio.cli.common.orientation_tables import add_table_options, read_table_picks
from vomstudio.cli.common.output import Output
from vomstudio.cli.common.unitless_lengths import add_unitless_names
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.registration.distances.compare_options import CompareOptions

if TYPE_CHECKING:
    from vomstudio.geology.model_agreement import Agreement
    from vomstudio.registration.distances.comparison import Comparison
    from vomstudio.studio.world_models import WorldModel


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``compare`` command."""
    parser = add_command(
        subparsers, "compare", run, help_=tr("Compute signed distances of a model from a benchmark")
    )
    parser.add_argument("model", metavar="MODEL", help=tr("mesh or point cloud"))
    parser.add_argument(
        "benchmark", metavar="BENCHMARK", help=tr("mesh or point cloud to compare with")
    )
    add_options(parser, CompareOptions)
    parser.add_argument(
        "--orientations",
        nargs=2,
        metavar=("TABLE", "OTHER"),
        help=tr("compare planes measured on the model and on the benchmark"),
    )
    add_table_options(parser)
    add_frame(parser)
    parser.add_argument(
        "--project",
        metavar="PROJECT",
        help=tr("use the registrations of both models in this project"),
    )
    add_output(parser, tr("write the model with its distances as a field (NAME.ply)"))


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio compare``.

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
    from vomstudio.core.files.atomic import check_target
    from vomstudio.io.models.reconstruction_file import placing_error_m
    from vomstudio.io.models.writing import choose_writer
    from vomstudio.registration.distances.comparison import compare
    from vomstudio.registration.overlap import crs_findings
    from vomstudio.studio.world_models import read_comparison_model, read_in_world

    options = parse_options(args, CompareOptions)
    if args.output is not None:
        choose_writer(Path(args.output))
        check_target(args.output, force=args.force, inputs=[args.model, args.benchmark])
    agreement = None if args.orientations is None else _compare_planes(args)
    progress = progress_reporter(args)
    frame = frame_options(args)
    model = read_in_world(args.model, progress, frame, args.project)
    benchmark = read_comparison_model(args.benchmark, progress, args.project, frame)
    names = (Path(args.model).name, Path(args.benchmark).name)
    warnings: list[Finding] = [
        *(
            warning.with_file(name)
            for name, input_model in zip(names, (model, benchmark), strict=True)
            for warning in input_model.warnings
        ),
        *crs_findings(model.crs, benchmark.crs, names),
    ]
    if not (model.is_metric or benchmark.is_metric):
        warnings.append(Finding("comparison.no-unit"))
    is_metric = model.has_metric_unit or benchmark.has_metric_unit
    error = options.registration_error_m
    if error is None and options.m3c2_m is not None:
        error = (
            placing_error_m(Path(args.model))
            if model.registration is None
            else model.registration.placing_error_m(model.data.bounds)
        )
    with name_input_in_errors(args.model):
        comparison_result = compare(
            model.data,
            benchmark.data,
            radius_m=options.m3c2_m,
            registration_error_m=error,
            progress=progress,
        )
    result: dict[str, Any] = comparison_result.to_dict()
    warnings += comparison_result.warnings
    if args.output is not None:
        warnings += _write_files(args, model, benchmark, comparison_result)
        result["out"] = args.output
    if agreement is not None:
        result["orientations"] = agreement.to_dict()
    result["warnings"] = warnings
    out.result(add_unitless_names(result, is_metric=is_metric))
    out.warn(warnings)
    out.text(_result_text(comparison_result))
    if agreement is not None:
        out.text(_agreement_text(agreement))


def _compare_planes(args: argparse.Namespace) -> Agreement:
    from vomstudio.geology.model_agreement import compare_orientations
    from vomstudio.io.text.oriented_planes import extract_planes

    tables = []
    for path in args.orientations:
        report_reading(args, path)
        tables.append(extract_planes(read_table_picks(args, path)))
    table, other_table = tables
    progress_reporter(args).stage(tr("Comparing orientations"))
    return compare_orientations(table, other_table)


def _agreement_text(comparison: Agreement) -> str:
    """Return a table of the planes measured on both models, and the number that agree."""
    rows = [
        [
            item.first,
            item.second,
            item.by,
            f"{item.angle_deg:.1f}",
            "-" if item.error95_deg is None else f"{item.error95_deg:.1f}",
        ]
        for item in comparison.matched
    ]
    first_unmatched, second_unmatched = comparison.unmatched
    findings = [
        *comparison.findings,
        Finding("comparison.planes-unmatched", first=first_unmatched, second=second_unmatched),
    ]
    lines = [finding.message for finding in findings]
    if rows:
        header = [tr("plane"), tr("other"), tr("by"), tr("angle"), "95 %"]
        lines.insert(0, text_tables.table(header, ["", "", "", "deg", "deg"], rows))
    return "\n".join(lines)


def _write_files(
    args: argparse.Namespace, model: WorldModel, benchmark: WorldModel, comparison: Comparison
) -> list[Finding]:
    from vomstudio.io.models.model_copy import companions
    from vomstudio.io.models.writing import write_model

    return write_model(
        replace(model.data, fields={**model.data.fields, **comparison.as_fields()}),
        model.crs or benchmark.crs,
        args.output,
        force=args.force,
        inputs=[
            model.loaded.path,
            *companions(model.loaded.path),
            benchmark.loaded.path,
            *companions(benchmark.loaded.path),
        ],
        progress=progress_reporter(args),
        registration=model.registration_in_world,
    )


def _result_text(comparison: Comparison) -> str:
    """Return accuracy, precision and the share of significant distances as text."""
    rows = [
        [subject_text, name, text_tables.figures(value)]
        for subject_text, name, value in (
            (tr("accuracy"), tr("mean"), comparison.mean_m),
            ("", tr("median"), comparison.median_m),
            (tr("precision"), tr("standard deviation"), comparison.std_m),
            ("", tr("median absolute deviation"), comparison.mad_m),
            (tr("both"), tr("root mean square"), comparison.rms_m),
        )
    ]
    lines = [text_tables.table([tr("distance"), "", "m"], ["", "", ""], rows)]
    lines.append(
        tr(
            "{n} distances; {beyond} points of the model have no counterpart.",
            n=comparison.n,
            beyond=comparison.beyond,
        )
    )
    if comparison.lod95_m is not None and comparison.significant_share is not None:
        lines.append(
            tr(
                "Level of detection (95 %, median): {lod:.3g} m; {share:.0f} % of the distances"
                " exceed it.",
                lod=comparison.lod95_m,
                share=100.0 * comparison.significant_share,
            )
        )
    if (direction := comparison.positive_toward) is not None:
        lines.append(
            tr(
                "Positive: the model lies in front of the benchmark, toward {trend}"
                " (trend/plunge).",
                trend=text_tables.line(vars(direction), 0),
            )
        )
    return "\n".join(lines)
