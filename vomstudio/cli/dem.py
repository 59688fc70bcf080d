"""`vomstudio dem`: heights of a model over a plane, as a raster."""

from __future__ import annotations

import argparse
import math
from typing import Any

from vomstudio.cli.common.arguments import Subparsers, add_command, add_output, progress_of
from vomstudio.cli.common.frames_of_models import add_frame, add_project
from vomstudio.cli.common.lengths import named_by_unit, unit_of
from vomstudio.cli.common.output import Output
from vomstudio.errors import InputError, UsageError
from vomstudio.words import tr


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers, "dem", run, help_=tr("Elevation model over a plane of reference, as GeoTIFF")
    )
    parser.add_argument("model", metavar="MODEL", help=tr("mesh, point cloud or table x, y, z"))
    add_output(parser, tr("the heights, NAME.tif; NAME.json is written beside it"), required=True)
    parser.add_argument("--gsd", type=float, metavar="M", help=tr("side of a cell in metres"))
    parser.add_argument(
        "--plane",
        metavar="DD/D",
        help=tr("plane of reference, dip direction and dip (default: the horizontal)"),
    )
    parser.add_argument(
        "--limit",
        type=float,
        metavar="M",
        help=tr("of a cloud or table: the longest side of triangles between points, in metres"),
    )
    parser.add_argument("--hillshade", action="store_true", help=tr("also NAME_hillshade.tif"))
    parser.add_argument(
        "--slope", action="store_true", help=tr("also NAME_slope.tif, the dip of the surface")
    )
    parser.add_argument(
        "--aspect", action="store_true", help=tr("also NAME_aspect.tif, its dip direction")
    )
    parser.add_argument(
        "--contours",
        type=float,
        metavar="SPACING",
        help=tr("also NAME_contours.gpkg, lines at multiples of so many metres"),
    )
    add_frame(parser)
    add_project(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    import numpy as np

    from vomstudio.cli.common.frames_of_models import frame_options
    from vomstudio.geometry.cloud import PointCloud
    from vomstudio.products.elevation import writing
    from vomstudio.products.elevation.heights import draw_heights
    from vomstudio.products.elevation.planning import plan_heights, reference_plane
    from vomstudio.products.elevation.results import Wanted
    from vomstudio.products.ortho.requests import check_gsd
    from vomstudio.workspace.world_models import read_in_world

    plane = reference_plane(args.plane)
    check_gsd(args.gsd)
    if args.limit is not None and not 0 < args.limit < math.inf:
        raise UsageError(tr("The longest side must be a length in metres."), field="--limit")
    wanted = Wanted(args.hillshade, args.slope, args.aspect, args.contours)
    wanted.check()
    writing.check_targets(args.output, wanted, force=args.force)
    progress = progress_of(args)
    model = read_in_world(args.model, progress, frame_options(args), args.project)
    if args.limit is not None and not isinstance(model.data, PointCloud):
        raise UsageError(
            tr("A mesh is not interpolated. --limit is for point clouds and tables."),
            field="--limit",
        )
    try:
        plan = plan_heights(
            model.data, plane, to_world=np.eye(4), gsd=args.gsd, metric=model.in_metres
        )
        heights, limit = draw_heights(model.data, plan, args.limit, progress)
        figures = writing.figures_of(heights, plan, limit, model.crs)
    except InputError as error:
        raise error.of_file(args.model) from error
    progress.stage(tr("Writing the results"))
    made = writing.write_elevation(
        heights,
        plan,
        figures,
        args.output,
        wanted=wanted,
        world=model.crs,
        north_known=model.placed,
        model=str(model.loaded.path),
        content_hash=model.loaded.content_hash,
        warnings=(*model.warnings, *plan.notes),
        force=args.force,
    )
    out.result(named_by_unit(made.as_dict(), metric=model.in_metres))
    out.warn(made.warnings)
    out.text(_in_words(made.as_dict(), unit_of(model.in_metres)))


def _in_words(result: dict[str, Any], unit: str) -> str:
    files = [result[k] for k in ("raster", "sidecar", "hillshade", "slope", "aspect", "contours")]
    return "\n".join(
        [
            tr(
                "{width} x {height} cells of {gsd:g} {unit}, {coverage:.0f} % with a height, from "
                "{low:.3f} to {high:.3f} {unit}",
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
