"""`vomstudio section`: intersection of a model with a plane or a vertical curtain."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common.arguments import (
    Subparsers,
    add_command,
    add_output,
    progress_reporter,
)
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.frame_arguments import add_frame, add_project, frame_options
from vomstudio.cli.common.orientation_tables import add_table_options
from vomstudio.cli.common.output import Output
from vomstudio.cli.common.unitless_lengths import add_unitless_names, length_unit
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.products.section.section_options import DOMAINS, SectionFeatures, SectionOptions

if TYPE_CHECKING:
    from vomstudio.products.section.inputs import ProfileLine
    from vomstudio.products.section.section_lines import Curtain
    from vomstudio.studio.world_models import WorldModel


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``section`` command."""
    parser = add_command(
        subparsers, "section", run, help_=tr("Draw a section of a model along a plane or a line")
    )
    parser.add_argument("model", metavar="MODEL", help=tr("mesh, point cloud or table x, y, z"))
    add_options(parser, SectionOptions)
    add_output(parser, tr("output section (.csv, .dxf or .svg)"), is_required=True)
    add_options(parser, SectionFeatures)
    add_table_options(parser)
    add_frame(parser)
    add_project(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio section``.

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
    from vomstudio.io.gate.points import ModelFrame
    from vomstudio.io.text.table_options import TableOptions
    from vomstudio.products.section import writing
    from vomstudio.products.section.cutting import cut_model
    from vomstudio.products.section.directions import ProjectionDirections, assign_domain_axes
    from vomstudio.products.section.inputs import (
        FeatureInput,
        read_features,
        read_profile_line,
    )
    from vomstudio.products.section.section_lines import curtain_from_options
    from vomstudio.studio.world_models import read_in_world

    options, features = parse_options(args, SectionOptions), parse_options(args, SectionFeatures)
    profile = (
        curtain_from_options(options)
        if options.section_line is None
        else read_profile_line(options.section_line, progress_reporter(args))
    )
    has_domain_axes = features.along == DOMAINS
    line_direction = None if has_domain_axes else _parse_direction(features.along)
    writing.check_targets(args.output, features.features is not None, force=args.force)
    model = read_in_world(args.model, progress_reporter(args), frame_options(args), args.project)
    section_features = FeatureInput()
    if features.features is not None:
        section_features = read_features(
            features.features, parse_options(args, TableOptions), ModelFrame(model.crs)
        )
    directions = (
        assign_domain_axes(section_features.items, "--along")
        if has_domain_axes
        else ProjectionDirections(line_direction)
    )
    curtain, warnings = _curtain(profile, model, options.flip)
    grazing_findings = directions.check(curtain)
    progress_reporter(args).stage(tr("Intersecting the model"))
    model_cut = cut_model(model.data, curtain, options.slab_m)
    projected_items, n_skipped = writing.project_items(
        section_features.items, curtain, directions, features.within_m
    )
    try:
        figures = writing.section_figures(
            model_cut, curtain, projected_items, n_skipped, directions
        )
    except InputError as error:
        raise error.with_file(args.model) from error
    files = writing.write_section(
        args.output,
        model_cut,
        curtain,
        figures,
        projected_items,
        crs=model.crs,
        model=str(model.loaded.path),
        is_metric=model.has_metric_unit,
        is_north_known=model.is_placed,
        warnings=(*model.warnings, *section_features.warnings, *warnings, *grazing_findings),
        force=args.force,
    )
    result = {**files.to_dict(), "convention": section_features.convention or None}
    out.result(add_unitless_names(result, is_metric=model.has_metric_unit))
    if section_features.convention:
        out.note(tr("read {convention}", convention=section_features.convention))
    out.warn(files.warnings)
    projection_lines = writing.describe_projection(figures)
    out.text(_result_text(files.to_dict(), length_unit(model.has_metric_unit), projection_lines))


def _curtain(
    profile: Curtain | ProfileLine, model: WorldModel, is_flipped: bool
) -> tuple[Curtain, tuple[Finding, ...]]:
    """Return the curtain in the World frame, and findings on the line. Raises InputError."""
    import numpy as np

    from vomstudio.products.section.inputs import profile_to_world
    from vomstudio.products.section.section_lines import Curtain, curtain_from_line

    if isinstance(profile, Curtain):
        return profile, ()
    bounds = np.array(model.data.bounds, np.float64)
    points, warnings = profile_to_world(profile, model.crs, bounds)
    try:
        curtain = curtain_from_line(points)
        return curtain.flipped() if is_flipped else curtain, warnings
    except InputError as error:
        error.file = str(profile.path)
        raise


def _parse_direction(text: str | None) -> Any:
    from vomstudio.geology.notation import parse_line

    if text is None:
        return None
    try:
        return parse_line(text).vector()
    except InputError as error:
        error.field = "--along"
        raise


def _result_text(result: dict[str, Any], unit: str, projection_lines: list[str]) -> str:
    lines = [
        tr(
            "lines: {count}, total length {length:.3f} {unit}",
            unit=unit,
            count=result["polylines"],
            length=result["length_m"],
        )
    ]
    if result["slab_m"] is not None:
        lines.append(
            tr(
                "{count} points in a slab {slab:.3g} {unit} thick",
                unit=unit,
                count=result["points"],
                slab=result["slab_m"],
            )
        )
    if result["features"] or result["left_out"]:
        lines.append(
            tr(
                "features projected: {count}, left out: {left_out}",
                count=result["features"],
                left_out=result["left_out"],
            )
        )
    lines += projection_lines
    lines += [file for file in (result["file"], result["features_file"]) if file is not None]
    return "\n".join(lines)
