"""`vomstudio ortho`: a scale-true picture of a model along any direction."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from vomstudio.cli.common.arguments import (
    Subparsers,
    add_azimuth,
    add_command,
    add_output,
    report_reading,
)
from vomstudio.cli.common.frames_of_models import add_frame, add_project, frame_options
from vomstudio.cli.common.lengths import named_by_unit, unit_of
from vomstudio.cli.common.output import Output
from vomstudio.cli.common.text_tables import azimuth
from vomstudio.errors import UsageError
from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.core.findings import Finding
    from vomstudio.document.records import Matrix
    from vomstudio.geology.table_folds import TableFold
    from vomstudio.io.models.reader import LoadedModel


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers, "ortho", run, help_=tr("Orthophoto of a model along any direction, as GeoTIFF")
    )
    parser.add_argument("model", metavar="MODEL", help=tr("mesh or point cloud"))
    parser.add_argument(
        "--trend", type=float, metavar="T", help=tr("look toward this trend, deg (with --plunge)")
    )
    parser.add_argument(
        "--plunge", type=float, metavar="P", help=tr("and this plunge: 90 is straight down")
    )
    parser.add_argument(
        "--plane", metavar="DD/D", help=tr("look against the upward normal of this plane")
    )
    parser.add_argument(
        "--fold", metavar="TABLE", help=tr("look along the fold axis of this table's bedding")
    )
    add_output(
        parser,
        tr("the picture, NAME.tif; NAME_depth.tif and NAME.json are written beside it"),
        required=True,
    )
    parser.add_argument("--gsd", type=float, metavar="M", help=tr("metres per pixel"))
    parser.add_argument("--flip", action="store_true", help=tr("look from the other side"))
    parser.add_argument(
        "--sheet",
        metavar="FILE",
        help=tr("also a page to scale with ticks and scale bar (.png, .jpg, .pdf)"),
    )
    parser.add_argument(
        "--draw",
        metavar="PROJECT",
        help=tr("also NAME_drawing.gpkg, .svg and .dxf: this project's features over the picture"),
    )
    parser.add_argument(
        "--show",
        metavar="PARTS",
        help=tr("of --draw: some of traces, patches, symbols, legend (default: all)"),
    )
    parser.add_argument(
        "--domain",
        metavar="NAME",
        help=tr(
            "with --draw: all but this domain of the project grey, along its own axis where no "
            "direction is given"
        ),
    )
    add_frame(parser)
    add_project(parser)
    parser.add_argument(
        "--around",
        metavar="X,Y,Z,W,H",
        help=tr("only so many metres of width and height about this point of World"),
    )
    add_azimuth(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.files.atomic import check_target
    from vomstudio.io.models.opening import read_model
    from vomstudio.products.ortho import orthophoto, requests
    from vomstudio.products.ortho.drawn_features import drawing_targets
    from vomstudio.products.ortho.interpretation import (
        LEGEND,
        PARTS,
        items_shown,
        parse_parts,
        read_items,
    )
    from vomstudio.products.ortho.one_domain import territory
    from vomstudio.products.ortho.sheet import format_of
    from vomstudio.workspace.world_models import check_place

    own_axis = _checked(args)
    requests.check_gsd(args.gsd)
    region = None if args.around is None else requests.parse_region(args.around)
    if args.sheet is not None:
        format_of(args.sheet)
    parts = PARTS if args.show is None else parse_parts(args.show)
    drawings = () if args.draw is None else drawing_targets(args.output).values()
    for target in (args.output, *orthophoto.outputs_of(args.output), args.sheet, *drawings):
        if target is not None:
            check_target(target, force=args.force)
    fold = None if args.fold is None else _fold(args)
    items = () if args.draw is None else read_items(Path(args.draw))
    only = None if args.domain is None else territory(items, args.domain)
    direction = (
        requests.axis_of_domain(items, args.domain)
        if own_axis
        else requests.direction_of(args.trend, args.plunge, args.plane, fold)
    )
    shown = items if only is None else only.features(items)
    features = None if args.draw is None else items_shown(shown, parts)
    progress = report_reading(args, args.model)
    check_place(frame_options(args), args.project)
    loaded = read_model(args.model, progress, frame_options(args))
    progress.stage(tr("Preparing the model"))
    place = _place(args, loaded)
    asked = requests.request_picture(
        loaded.data,
        direction,
        to_world=place.to_world,
        path=args.model,
        gsd_m=args.gsd,
        flip=args.flip,
        placed=place.placed,
        metric=place.metric,
        region=region,
    )
    made = orthophoto.write_orthophoto(
        loaded.data,
        asked.plan,
        args.output,
        crs=place.crs,
        model=str(loaded.path),
        content_hash=loaded.content_hash,
        sheet=args.sheet,
        force=args.force,
        progress=progress,
        features=features,
        legend=LEGEND in parts,
        only=None if only is None else only.seen_in(items, asked.plan),
    )
    found = requests.written(
        made, asked, args.output, args.sheet, (*loaded.warnings, *place.findings)
    )
    out.result(named_by_unit(found.as_dict(), metric=place.in_metres))
    out.warn(found.warnings)
    out.text(_in_words(found.as_dict(), unit_of(place.in_metres)))


def _checked(args: argparse.Namespace) -> bool:
    """Whether to look along the domain's own axis. Raises UsageError for options that contradict
    each other."""
    from vomstudio.products.ortho.requests import check_direction

    given = (args.trend, args.plunge, args.plane, args.fold)
    own_axis = args.domain is not None and all(word is None for word in given)
    if not own_axis:
        check_direction(*given)
    for word, field in ((args.show, "--show"), (args.domain, "--domain")):
        if word is not None and args.draw is None:
            raise UsageError(
                tr("{option} is for the features of a project, --draw PROJECT.", option=field),
                field=field,
            )
    return own_axis


class _Place(NamedTuple):
    """How the model stands in World. placed : north is known; metric : the unit is, too
    in_metres : as of `WorldModel`"""

    to_world: Matrix
    crs: str | None
    placed: bool
    metric: bool
    in_metres: bool
    findings: tuple[Finding, ...]


def _place(args: argparse.Namespace, loaded: LoadedModel) -> _Place:
    from vomstudio.io.gis.crs import world_crs
    from vomstudio.io.models.frames import establish_frame
    from vomstudio.io.photos.cameras_file import scale_known
    from vomstudio.workspace.world_models import model_in

    if args.project is not None:
        model = model_in(args.project, loaded)
        frame = model.frame
        crs = world_crs(frame.crs, frame.unit_m)
        metric = frame.has_metres
        return _Place(model.to_world, crs, frame.has_north, metric, metric, ())
    options = frame_options(args)
    established = establish_frame(loaded, options)
    frame = established.frame
    registration = established.registration
    if registration is not None:
        placed, metric = frame.has_north, frame.has_metres
        return _Place(
            established.to_world(), world_crs(frame.crs, frame.unit_m), placed, metric, metric,
            established.findings,
        )  # fmt: skip
    placed = frame.crs is not None or scale_known(loaded.path) is not False
    return _Place(
        frame.to_world(),
        world_crs(frame.crs, frame.unit_m),
        placed,
        frame.unit_m != 1.0,
        placed or options.unit is not None,
        established.findings,
    )


def _fold(args: argparse.Namespace) -> TableFold:
    from vomstudio.geology.table_folds import table_fold
    from vomstudio.io.text.orientation_reading import read_orientations

    return table_fold(read_orientations(args.fold, args.azimuth))


def _in_words(result: dict[str, Any], unit: str) -> str:
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
                reason=result["sense_reason"],
            ),
            *([] if cost is None or cost in result["warnings"] else [cost]),
            *(str(file) for file in files if file is not None),
            *(result["drawing"] or {}).values(),
        ]
    )
