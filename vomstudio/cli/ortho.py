"""`vomstudio ortho`: orthographic picture of a model along any direction."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from vomstudio.cli.common.arguments import (
    Subparsers,
    add_command,
    add_output,
    report_reading,
)
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.frame_arguments import add_frame, add_project, frame_options
from vomstudio.cli.common.orientation_tables import add_table_options, read_table_picks
from vomstudio.cli.common.output import Output
from vomstudio.cli.common.text_tables import azimuth
from vomstudio.cli.common.unitless_lengths import add_unitless_names, length_unit
from vomstudio.core.words import tr
from vomstudio.products.ortho.ortho_options import OrthoDrawing, OrthoOptions

if TYPE_CHECKING:
    from vomstudio.core.findings import Finding
    from vomstudio.geology.table_folds import TableFold
    from vomstudio.geometry.matrices import Matrix
    from vomstudio.io.models.reader import LoadedModel


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``ortho`` command."""
    parser = add_command(
        subparsers,
        "ortho",
        run,
        help_=tr("Make an orthophoto of a model along any direction, as GeoTIFF"),
    )
    parser.add_argument("model", metavar="MODEL", help=tr("mesh or point cloud"))
    add_options(parser, OrthoOptions)
    add_output(
        parser,
        tr("the picture, NAME.tif; NAME_depth.tif and NAME.json are written too"),
        is_required=True,
    )
    add_options(parser, OrthoDrawing)
    add_frame(parser)
    add_project(parser)
    add_table_options(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio ortho``.

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
    from vomstudio.io.models.opening import read_model
    from vomstudio.products.ortho import orthophoto, requests
    from vomstudio.products.ortho.domain_mask import domain_extent
    from vomstudio.products.ortho.drawn_features import drawing_targets
    from vomstudio.products.ortho.interpretation import (
        LEGEND,
        PARTS,
        parse_parts,
        read_items,
        select_items,
    )
    from vomstudio.products.ortho.sheet import format_from_path
    from vomstudio.studio.world_models import check_frame_source

    options, drawing = parse_options(args, OrthoOptions), parse_options(args, OrthoDrawing)
    has_own_axis = drawing.domain is not None and not options.has_direction
    if not has_own_axis:
        options.check_direction()
    region = None if drawing.around is None else requests.parse_region(drawing.around)
    if drawing.sheet is not None:
        format_from_path(drawing.sheet)
    parts = PARTS if drawing.show is None else parse_parts(drawing.show)
    drawings = () if drawing.draw is None else drawing_targets(args.output).values()
    for target in (
        args.output,
        *orthophoto.orthophoto_outputs(args.output),
        drawing.sheet,
        *drawings,
    ):
        if target is not None:
            check_target(target, force=args.force)
    fold = None if options.fold is None else _read_fold(options.fold, args)
    items = () if drawing.draw is None else read_items(Path(drawing.draw))
    drawn_domain = None if drawing.domain is None else domain_extent(items, drawing.domain)
    direction = (
        requests.domain_axis_direction(items, str(drawing.domain))
        if has_own_axis
        else requests.direction_from_options(options, fold)
    )
    drawn_items = items if drawn_domain is None else drawn_domain.features(items)
    features = None if drawing.draw is None else select_items(drawn_items, parts)
    progress = report_reading(args, args.model)
    check_frame_source(frame_options(args), args.project)
    loaded_model = read_model(args.model, progress, frame_options(args))
    progress.stage(tr("Preparing the model"))
    placement = _place_model(args, loaded_model)
    request = requests.plan_picture(
        loaded_model.data,
        direction,
        to_world=placement.to_world,
        path=args.model,
        gsd_m=options.gsd_m,
        flip=options.flip,
        is_placed=placement.is_placed,
        is_metric=placement.is_metric,
        region=region,
    )
    picture_files = orthophoto.write_orthophoto(
        loaded_model.data,
        request.plan,
        args.output,
        crs=placement.crs,
        model=str(loaded_model.path),
        content_hash=loaded_model.content_hash,
        sheet=drawing.sheet,
        force=args.force,
        progress=progress,
        features=features,
        legend=LEGEND in parts,
        domain_extent=None
        if drawn_domain is None
        else drawn_domain.add_view_findings(items, request.plan),
    )
    result = requests.collect_result(
        picture_files,
        request,
        args.output,
        drawing.sheet,
        (*loaded_model.warnings, *placement.findings),
    )
    out.result(add_unitless_names(result.to_dict(), is_metric=placement.has_metric_unit))
    out.warn(result.warnings)
    out.text(_result_text(result.to_dict(), length_unit(placement.has_metric_unit)))


class _Placement(NamedTuple):
    """Placement of the model in the World frame.

    `is_placed` and `is_metric` state whether north and unit are known. `has_metric_unit` is as in
    `WorldModel`.
    """

    to_world: Matrix
    crs: str | None
    is_placed: bool
    is_metric: bool
    has_metric_unit: bool
    findings: tuple[Finding, ...]


def _place_model(args: argparse.Namespace, loaded_model: LoadedModel) -> _Placement:
    from vomstudio.io.gis.crs import world_crs
    from vomstudio.io.models.frames import establish_frame
    from vomstudio.io.photos.cameras_file import has_known_scale
    from vomstudio.studio.world_models import find_project_model

    if args.project is not None:
        model = find_project_model(args.project, loaded_model)
        frame = model.frame
        crs = world_crs(frame.crs, frame.unit_m)
        is_metric = frame.has_metres
        return _Placement(model.to_world, crs, frame.has_north, is_metric, is_metric, ())
    options = frame_options(args)
    frame_result = establish_frame(loaded_model, options)
    frame = frame_result.frame
    registration = frame_result.registration
    if registration is not None:
        is_placed, is_metric = frame.has_north, frame.has_metres
        return _Placement(
            frame_result.to_world(),
            world_crs(frame.crs, frame.unit_m),
            is_placed,
            is_metric,
            is_metric,
            frame_result.findings,
        )
    is_placed = frame.crs is not None or has_known_scale(loaded_model.path) is not False
    return _Placement(
        frame.to_world(),
        world_crs(frame.crs, frame.unit_m),
        is_placed,
        frame.unit_m != 1.0,
        is_placed or options.unit is not None,
        frame_result.findings,
    )


def _read_fold(table: str, args: argparse.Namespace) -> TableFold:
    from vomstudio.geology.table_folds import table_fold

    return table_fold(read_table_picks(args, table))


def _result_text(result: dict[str, Any], unit: str) -> str:
    files = [result[key] for key in ("image", "depth", "sidecar", "world_file", "sheet")]
    cost = (result["fold"] or {}).get("cost")
    return "\n".join(
        [
            tr(
                "{width} x {height} pixels of {gsd:g} {unit}, {coverage:.0f} % covered",
                unit=unit,
                width=result["width"],
                height=result["height"],
                gsd=result["gsd_m"],
                coverage=100 * result["coverage"],
            ),
            tr(
                "view toward {trend}/{plunge:.1f} trend/plunge, {sense}: {reason}",
                trend=azimuth(result["trend_deg"]),
                plunge=result["plunge_deg"],
                sense=tr(result["sense"]),
                reason=result["sense_reason"]["message"],
            ),
            *([] if cost is None or cost in result["warnings"] else [cost["message"]]),
            *(str(file) for file in files if file is not None),
            *(result["drawing"] or {}).values(),
        ]
    )
