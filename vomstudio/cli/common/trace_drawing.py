"""`vomstudio trace --from-ortho`: projection of the lines of a drawing onto the surface."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common.arguments import progress_reporter
from vomstudio.cli.common.frame_arguments import frame_options
from vomstudio.cli.common.output import Output
from vomstudio.cli.common.unitless_lengths import add_unitless_names
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr_n
from vomstudio.extraction.trace_options import DrawnTraceOptions

if TYPE_CHECKING:
    from vomstudio.products.ortho.back_projection import ProjectedLines, Sidecar


def run(args: argparse.Namespace, options: DrawnTraceOptions, out: Output) -> None:
    """Run ``vomstudio trace --from-ortho``.

    Parameters
    ----------
    args : Namespace
        Parsed arguments.
    options : DrawnTraceOptions
    out : Output
        Object that receives the results, warnings and progress.

    Raises
    ------
    UsageError, InputError, GeometryError, TargetError
    """
    from vomstudio.core.files.extensions import check_table_target
    from vomstudio.products.ortho import back_projection
    from vomstudio.project.tables.line_table import write_line_table
    from vomstudio.studio.world_models import read_in_world

    if options.sidecar is None:
        raise UsageError(
            Finding("option.requires", option="--from-ortho", other="--sidecar"),
            field="--sidecar",
        )
    check_table_target(
        args.output, force=args.force, inputs=[args.model, args.from_ortho, options.sidecar]
    )
    sidecar = back_projection.read_sidecar(options.sidecar)
    lines, findings = back_projection.read_drawing(
        args.from_ortho, sidecar, progress_reporter(args)
    )
    model = read_in_world(args.model, progress_reporter(args), frame_options(args), args.project)
    try:
        projected_lines = back_projection.project_lines(lines, sidecar, model.data, options.step_m)
    except InputError as error:
        raise error.with_file(args.from_ortho) from error
    warnings = [*model.warnings, *findings, *projected_lines.warnings]
    if sidecar.content_hash not in (None, model.loaded.content_hash):
        model_name = Path(args.model).name
        warnings.append(Finding("drawing.orthophoto-of-other-file", model=model_name))
    result: dict[str, Any] = {**back_projection.command_output(projected_lines, args.output)}
    if options.into is not None:
        result |= _add_to_project(
            args,
            options,
            options.into,
            projected_lines,
            (line.name for line in lines),
            sidecar,
            warnings,
        )
    write_line_table(
        args.output,
        [(line.name, line.points) for line in projected_lines.lines],
        crs=model.crs,
        is_north_known=model.is_placed,
        source=Path(args.from_ortho).name,
        force=args.force,
    )
    result["warnings"] = warnings
    out.result(add_unitless_names(result, is_metric=model.has_metric_unit))
    out.warn(warnings)
    out.text(
        tr_n(
            "{count} line of {points} points on the surface: {table}",
            "{count} lines of {points} points on the surface: {table}",
            result["lines"],
            points=result["points"],
            table=args.output,
        )
    )


def _add_to_project(
    args: argparse.Namespace,
    options: DrawnTraceOptions,
    project: str,
    projected_lines: ProjectedLines,
    names: Iterable[str],
    sidecar: Sidecar,
    warnings: list[Finding],
) -> dict[str, list[dict[str, str]]]:
    """Add a drawing to the project; findings are appended to `warnings`.

    Returns the traces that were ``added`` or ``updated`` and the features that are ``unchanged``.
    """
    from vomstudio.project.records import get_feature
    from vomstudio.studio.headless_project import HeadlessProject

    with HeadlessProject.open(Path(project), progress_reporter(args)) as headless_project:
        traces = headless_project.add_drawing(
            projected_lines,
            names,
            sidecar,
            Path(args.from_ortho),
            headless_project.find_model(options.on),
            None if options.type is None else headless_project.find_type(options.type),
            options.set or "",
            update=options.update,
        )
        findings = (*headless_project.warnings, *traces.messages, *headless_project.save())
        records = headless_project.session.records
    warnings += [item for item in findings if item not in warnings]
    ids = {
        "added": [trace.id for trace in traces.traces],
        "updated": [trace.id for trace in traces.edited] if options.update else [],
        "unchanged": traces.unchanged,
    }
    return {
        state: [
            {"id": id_, "name": feature.name}
            for id_ in feature_ids
            if (feature := get_feature(records, id_)) is not None
        ]
        for state, feature_ids in ids.items()
    }
