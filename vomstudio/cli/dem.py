"""`vomstudio dem`: heights of a model above a plane, as a raster."""

from __future__ import annotations

import argparse
from typing import Any

from vomstudio.cli.common.arguments import Subparsers, add_command, add_output, progress_reporter
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.frame_arguments import add_frame, add_project
from vomstudio.cli.common.output import Output
from vomstudio.cli.common.unitless_lengths import add_unitless_names, length_unit
from vomstudio.core.errors import InputError
from vomstudio.core.words import tr
from vomstudio.products.elevation.dem_options import DemFiles, DemOptions


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``dem`` command."""
    parser = add_command(
        subparsers,
        "dem",
        run,
        help_=tr("Compute an elevation model relative to a reference plane, as GeoTIFF"),
    )
    parser.add_argument("model", metavar="MODEL", help=tr("mesh, point cloud or table x, y, z"))
    add_output(parser, tr("the heights, NAME.tif; NAME.json is written too"), is_required=True)
    add_options(parser, DemOptions)
    add_options(parser, DemFiles)
    add_frame(parser)
    add_project(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio dem``.

    Parameters
    ----------
    args : Namespace
        Parsed arguments.
    out : Output
        Object that receives the results, warnings and progress.

    Raises
    ------
    UsageError, InputError, TargetError
    """
    import numpy as np

    from vomstudio.cli.common.frame_arguments import frame_options
    from vomstudio.products.elevation import writing
    from vomstudio.products.elevation.heights import compute_heights
    from vomstudio.products.elevation.planning import parse_reference_plane, plan_heights
    from vomstudio.studio.world_models import read_in_world

    options, files = parse_options(args, DemOptions), parse_options(args, DemFiles)
    plane = parse_reference_plane(options.plane)
    writing.check_targets(args.output, files, force=args.force)
    progress = progress_reporter(args)
    model = read_in_world(args.model, progress, frame_options(args), args.project)
    try:
        plan = plan_heights(
            model.data,
            plane,
            to_world=np.eye(4),
            gsd=options.gsd_m,
            is_metric=model.has_metric_unit,
        )
        elevation_model, limit = compute_heights(model.data, plan, options.limit_m, progress)
        figures = writing.elevation_figures(elevation_model, plan, limit, model.crs)
    except InputError as error:
        raise error.with_file(args.model) from error
    progress.stage(tr("Writing the results"))
    written_files = writing.write_elevation(
        elevation_model,
        plan,
        figures,
        args.output,
        files=files,
        world=model.crs,
        is_north_known=model.is_placed,
        model=str(model.loaded.path),
        content_hash=model.loaded.content_hash,
        warnings=(*model.warnings, *plan.notes),
        force=args.force,
    )
    out.result(add_unitless_names(written_files.to_dict(), is_metric=model.has_metric_unit))
    out.warn(written_files.warnings)
    out.text(_result_text(written_files.to_dict(), length_unit(model.has_metric_unit)))


def _result_text(result: dict[str, Any], unit: str) -> str:
    files = [result[k] for k in ("raster", "sidecar", "hillshade", "slope", "aspect", "contours")]
    return "\n".join(
        [
            tr(
                "{width} x {height} cells of {gsd:g} {unit}, {coverage:.0f} % covered, heights"
                " from {low:.3f} to {high:.3f} {unit}",
                unit=unit,
                width=result["width"],
                height=result["height"],
                gsd=result["gsd_m"],
                coverage=100 * result["coverage"],
                low=result["lowest_m"],
                high=result["highest_m"],
            ),
            *(str(file) for file in files if file is not None),
        ]
    )
