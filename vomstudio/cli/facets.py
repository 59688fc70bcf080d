"""`vomstudio facets`: planar parts of an outcrop face."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import Subparsers, add_command, add_output, progress_reporter
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.error_context import name_input_in_errors
from vomstudio.cli.common.frame_arguments import (
    add_frame,
    add_project,
    frame_options,
    unknown_unit,
)
from vomstudio.cli.common.labelled_models import write_labelled_model
from vomstudio.cli.common.output import Output
from vomstudio.cli.common.unitless_lengths import add_unitless_names
from vomstudio.core.words import tr
from vomstudio.extraction.facet_options import FacetOptions

if TYPE_CHECKING:
    from vomstudio.extraction.facet_table import FacetTable
    from vomstudio.geology.sets.proposals import DescribedSet

MAX_SHOWN_FACETS = 20


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``facets`` command."""
    parser = add_command(
        subparsers, "facets", run, help_=tr("Find the facets of an outcrop and fit their planes")
    )
    parser.add_argument("model", metavar="MODEL", help=tr("mesh or point cloud"))
    add_output(parser, tr("write the orientation table as CSV"), is_required=True)
    parser.add_argument(
        "--labels",
        metavar="OUT.ply",
        help=tr("write the model with the fields facet and set (-1 for none)"),
    )
    add_options(parser, FacetOptions)
    add_frame(parser)
    add_project(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio facets``.

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
    from vomstudio.core.files.extensions import check_table_target
    from vomstudio.extraction.facet_search import search_facets
    from vomstudio.geology.profiles import DEFAULT_THRESHOLDS
    from vomstudio.io.models.writing import choose_writer
    from vomstudio.project.tables.orientation_table import write_orientation_csv
    from vomstudio.studio.world_models import read_in_world

    options = parse_options(args, FacetOptions)
    check_table_target(args.output, force=args.force, inputs=[args.model])
    if args.labels is not None:
        choose_writer(Path(args.labels))
        check_target(args.labels, force=args.force, inputs=[args.model, args.output])
    progress = progress_reporter(args)
    model = read_in_world(args.model, progress, frame_options(args), args.project)
    warnings = list(model.warnings)
    with name_input_in_errors(args.model):
        facet_table = search_facets(
            model.data,
            options,
            model=Path(args.model).name,
            frame=model.crs or "local",
            progress=progress,
        )
    progress.stage(tr("Writing the results"))
    warnings += unknown_unit(model)
    result: dict[str, Any] = {**facet_table.to_dict(), "table": args.output}
    warnings += facet_table.warnings
    if args.labels is not None:
        warnings += write_labelled_model(args, model, facet_table.labels)
        result["labels"] = args.labels
    write_orientation_csv(
        args.output,
        facet_table.rows,
        crs=model.crs,
        limits=DEFAULT_THRESHOLDS,
        extra_columns=facet_table.more,
        force=args.force,
    )
    result["warnings"] = warnings
    out.result(add_unitless_names(result, is_metric=model.has_metric_unit))
    out.warn(warnings)
    out.text(_result_text(facet_table))


def _result_text(facet_table: FacetTable) -> str:
    """Describe the largest facets and the share of the outcrop that all facets cover."""
    headers = [tr("facet"), tr("plane"), tr("area"), tr("n"), tr("quality")]
    units = ["", tr("dip direction/dip ± 95 %"), "m2", "", ""]
    rows = [
        [
            str(row["id"]),
            text_tables.plane_with_error(row),
            text_tables.figures(row["area_m2"]),
            str(row["n_points"]),
            row["quality"],
        ]
        for row in facet_table.rows[:MAX_SHOWN_FACETS]
    ]
    lines = [text_tables.table(headers, units, rows)] if rows else []
    if facet_table.facets > MAX_SHOWN_FACETS:
        lines.append(
            tr("more facets in the table: {count}", count=facet_table.facets - MAX_SHOWN_FACETS)
        )
    if facet_table.coverage is not None:
        lines.append(
            tr(
                "{count} facets cover {share:.0f} % of the model.",
                count=facet_table.facets,
                share=100.0 * facet_table.coverage,
            )
        )
    if facet_table.near_planar_share is not None:
        lines.append(
            tr(
                "{share:.0f} % of the exposed rock, without vegetation and debris, is near-planar.",
                share=100.0 * facet_table.near_planar_share,
            )
        )
    return "\n".join([*lines, *(_set_text(item) for item in facet_table.sets)])


def _set_text(described_set: DescribedSet) -> str:
    plane = text_tables.plane(vars(described_set))
    if described_set.spacing_m is None:
        return tr(
            "Set {name}: {count} facets, mean plane {plane}.",
            name=described_set.name,
            count=described_set.n,
            plane=plane,
        )
    return tr(
        "Set {name}: {count} facets of {planes} discontinuities, mean plane {plane}, spacing"
        " {spacing} m.",
        name=described_set.name,
        count=described_set.n,
        planes=described_set.discontinuities,
        plane=plane,
        spacing=text_tables.figures(described_set.spacing_m),
    )
