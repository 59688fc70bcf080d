"""Command `vomstudio trace --propose`: lines that exceed the noise, most reliable first."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from vomstudio.cli.common.arguments import progress_reporter
from vomstudio.cli.common.error_context import name_input_in_errors
from vomstudio.cli.common.frame_arguments import frame_options
from vomstudio.cli.common.output import Output
from vomstudio.cli.common.unitless_lengths import add_unitless_names, length_unit
from vomstudio.core.words import tr, tr_n
from vomstudio.extraction.trace_options import ProposalOptions


def run(args: argparse.Namespace, options: ProposalOptions, out: Output) -> None:
    """Run ``vomstudio trace --propose``.

    Parameters
    ----------
    args : Namespace
        Parsed arguments.
    options : ProposalOptions
    out : Output
        Object that receives the results, warnings and progress.

    Raises
    ------
    UsageError, InputError, GeometryError, TargetError
    """
    from vomstudio.core.files.extensions import check_table_target
    from vomstudio.extraction.proposals.edge_pictures import colour_by_edges
    from vomstudio.extraction.proposals.traces import propose_traces
    from vomstudio.extraction.surface_graph import SurfaceGraph
    from vomstudio.io.models.opening import resolution
    from vomstudio.project.tables.line_table import write_line_table
    from vomstudio.studio.jobs.edge_detection import open_edge_finder
    from vomstudio.studio.world_models import read_in_world

    check_table_target(args.output, force=args.force, inputs=[args.model])
    progress = progress_reporter(args)
    model = read_in_world(args.model, progress, frame_options(args), args.project)
    data, spacing = model.data, resolution(model.data)
    with open_edge_finder(options.onnx_model, progress) as edges, name_input_in_errors(args.model):
        proposed_traces = propose_traces(
            SurfaceGraph(data if edges is None else colour_by_edges(data, spacing, *edges)),
            options,
            resolution=spacing,
            model=Path(args.model).name,
            frame=model.crs or "local",
            progress=progress,
        )
    write_line_table(
        args.output,
        [(proposal.line, proposal.points) for proposal in proposed_traces.proposals],
        crs=model.crs,
        is_north_known=model.is_placed,
        source=tr("{model}, proposed and not reviewed", model=Path(args.model).name),
        force=args.force,
    )
    result: dict[str, Any] = {**proposed_traces.to_dict(), "table": args.output}
    result["warnings"] = [*model.warnings, *proposed_traces.warnings]
    out.result(add_unitless_names(result, is_metric=model.has_metric_unit))
    out.warn(result["warnings"])
    lines = [
        tr_n(
            "{count} line is proposed and not reviewed.",
            "{count} lines are proposed and not reviewed.",
            len(proposed_traces.proposals),
        )
    ]
    lines += [
        tr(
            "{line}: {length:.3g} {unit}, evidence {evidence:.1f}, doubt {doubt:.2f}",
            unit=length_unit(model.has_metric_unit),
            line=proposal.line,
            length=proposal.length_m,
            evidence=proposal.evidence,
            doubt=proposal.doubt,
        )
        for proposal in proposed_traces.proposals
    ]
    out.text("\n".join(lines))
