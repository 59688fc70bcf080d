"""`vomstudio extend`: extension of a plane through a model, with its position error."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import Subparsers, add_command, add_output, progress_reporter
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.error_context import name_input_in_errors
from vomstudio.cli.common.frame_arguments import add_frame, frame_options
from vomstudio.cli.common.labelled_models import write_labelled_model
from vomstudio.cli.common.output import Output
from vomstudio.cli.common.unitless_lengths import add_unitless_names, length_unit
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr, tr_n
from vomstudio.products.section.extend_options import ExtendOptions

if TYPE_CHECKING:
    from vomstudio.geology.beds.extended import PlaneEstimate
    from vomstudio.products.section.extension import ExtendedPlane
    from vomstudio.studio.world_models import WorldModel

MAX_SHOWN_BEDS = 20


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``extend`` command."""
    parser = add_command(
        subparsers,
        "extend",
        run,
        help_=tr("Extend a plane through a model, with the error of its position"),
    )
    parser.add_argument("model", metavar="MODEL", help=tr("mesh or point cloud"))
    parser.add_argument(
        "points", metavar="POINTS", nargs="?", help=tr("points of the plane (table x, y, z)")
    )
    add_options(parser, ExtendOptions)
    add_output(
        parser, tr("write the traces of the plane on the model (.csv or .gpkg)"), is_required=True
    )
    parser.add_argument(
        "--labels",
        metavar="OUT.ply",
        help=tr("write the model with distance from the plane, its error, and the error band"),
    )
    add_frame(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio extend``.

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
    from vomstudio.io.models.writing import choose_writer
    from vomstudio.products.section.extension import extend, format_from_path, write_traces
    from vomstudio.studio.world_models import read_in_world

    options = parse_options(args, ExtendOptions)
    options.check_points(args.points, "POINTS")
    format_from_path(args.output)
    inputs = [args.model, *([args.points] if args.points else [])]
    check_target(args.output, force=args.force, inputs=inputs)
    if args.labels is not None:
        choose_writer(Path(args.labels))
        check_target(args.labels, force=args.force, inputs=[*inputs, args.output])
    progress = progress_reporter(args)
    model = read_in_world(args.model, progress, frame_options(args))
    estimate, findings = _plane_estimate(options, args.points, model)
    progress.stage(tr("Extending the plane"))
    extension = extend(model.data, estimate, options)
    progress.stage(tr("Writing the results"))
    write_traces(
        args.output,
        extension,
        crs=model.crs,
        model=Path(args.model).name,
        force=args.force,
        axes=model.axes,
    )
    warnings = [*model.warnings, *findings, *extension.warnings]
    result: dict[str, Any] = {"file": args.output, **extension.to_dict()}
    if args.labels is not None:
        warnings += write_labelled_model(args, model, extension.as_fields())
        result["labels"] = args.labels
    result["warnings"] = warnings
    out.result(add_unitless_names(result, is_metric=model.has_metric_unit))
    out.warn(warnings)
    out.text(_result_text(extension, length_unit(model.has_metric_unit)))


def _plane_estimate(
    options: ExtendOptions, points: str | None, model: WorldModel
) -> tuple[PlaneEstimate, tuple[Finding, ...]]:
    """Return the plane with its errors in the World frame, and findings about its points."""
    from vomstudio.geology.beds.extended import (
        plane_estimate_from_attitude,
        plane_estimate_from_fit,
    )
    from vomstudio.geology.notation import parse_plane_option
    from vomstudio.geometry.planes import fit_plane
    from vomstudio.io.gate.point_tables import read_points
    from vomstudio.io.gate.points import ModelFrame
    from vomstudio.products.section.section_lines import parse_through_point

    if points is not None:
        point_table = read_points(points, model=ModelFrame(model.crs))
        groups = point_table.groups
        with name_input_in_errors(points):
            return plane_estimate_from_fit(fit_plane(groups.points)), groups.warnings
    assert options.error_deg is not None
    plane, passing_point = (
        parse_plane_option(str(options.plane)),
        parse_through_point(str(options.through)),
    )
    return plane_estimate_from_attitude(
        plane, passing_point, options.error_deg, options.through_error_m
    ), ()


def _result_text(extension: ExtendedPlane, unit: str) -> str:
    """Describe the planes that intersect the model, with the errors of their position."""
    rows = [
        [
            str(bed.bed),
            text_tables.figures(bed.offset_m),
            text_tables.figures(bed.length_m),
            text_tables.figures(bed.least_error95_m),
            text_tables.figures(bed.most_error95_m),
        ]
        for bed in extension.beds[:MAX_SHOWN_BEDS]
    ]
    headers = [tr("bed"), tr("offset"), tr("length"), tr("95 % min"), tr("95 % max")]
    lines = [
        tr(
            "Plane {plane} (95 %), extended over the model.",
            plane=text_tables.plane_with_error(vars(extension), "max_error95_deg"),
        ),
        text_tables.table(headers, ["", *[unit] * 4], rows),
    ]
    remaining_count = len(extension.beds) - MAX_SHOWN_BEDS
    if remaining_count > 0:
        lines.append(
            tr_n(
                "{count} more bed is in the output file.",
                "{count} more beds are in the output file.",
                remaining_count,
            )
        )
    return "\n".join(lines)
