"""`vomstudio ortho`: a scale-true picture of a model along any direction."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from vomstudio.cli.arguments import (
    Subparsers,
    add_azimuth,
    add_command,
    add_output,
    progress_of,
)
from vomstudio.cli.output import Output
from vomstudio.cli.text_tables import azimuth
from vomstudio.errors import InputError, UsageError
from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.io.models.reader import LoadedModel
    from vomstudio.products.ortho.view_directions import View


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
    add_output(parser, "the picture, NAME.tif; NAME_depth.tif and NAME.json beside", required=True)
    parser.add_argument("--gsd", type=float, metavar="M", help=tr("metres per pixel"))
    parser.add_argument("--flip", action="store_true", help=tr("look from the other side"))
    parser.add_argument(
        "--sheet",
        metavar="FILE",
        help=tr("also a picture with scale bar and orientation (.png, .pdf)"),
    )
    parser.add_argument(
        "--up",
        choices=["y", "z"],
        default="z",
        help=tr("the model's axis that points up (default z)"),
    )
    parser.add_argument(
        "--unit", type=float, metavar="M", default=1.0, help=tr("metres per unit of the model")
    )
    add_azimuth(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.document.records import Frame
    from vomstudio.files.atomic import check_target
    from vomstudio.io.models.opening import read_model
    from vomstudio.io.photos.cameras_file import scale_known
    from vomstudio.products.ortho import orthophoto, planning, view_directions
    from vomstudio.products.ortho.sheet import format_of

    _one_direction(args)
    if args.unit <= 0 or args.unit != args.unit or args.unit == float("inf"):
        raise UsageError(tr("a unit has a length in metres, such as 0.001 for mm."), field="--unit")
    if args.gsd is not None and not 0 < args.gsd < float("inf"):
        raise UsageError(tr("the size of a pixel must be a length in metres."), field="--gsd")
    if args.sheet is not None:
        format_of(args.sheet)
    for target in (args.output, *orthophoto.outputs_of(args.output)[:2], args.sheet):
        if target is not None:
            check_target(target, force=args.force)
    fixed = _fixed_view(args)
    fold, warnings = (None, []) if args.fold is None else _fold(args)
    progress = progress_of(args)
    loaded = read_model(args.model, progress)
    to_world = Frame(unit_m=args.unit, up_axis=args.up).to_world()
    view = fixed or _fold_view(fold, loaded, to_world)
    if args.flip:
        view = view.flipped()
    unknown = loaded.crs is None and scale_known(loaded.path) is False
    if unknown:
        view = replace(view, north_known=False, metric=args.unit != 1.0)
    try:
        plan = planning.plan(loaded.data, view, to_world=to_world, gsd=args.gsd)
    except InputError as error:
        raise InputError(error.message, file=args.model) from error
    made = orthophoto.write_orthophoto(
        loaded.data,
        plan,
        args.output,
        # Other axes or units than the file's are no longer coordinates of its CRS.
        crs=loaded.crs if args.up == "z" and args.unit == 1.0 else None,
        model=str(loaded.path),
        content_hash=loaded.content_hash,
        sheet=args.sheet,
        force=args.force,
        progress=progress,
    )
    if fold is not None:
        deep = float(plan.points[:, 2].max() - plan.points[:, 2].min())
        fold["cost"] = view_directions.cost_of_direction(
            fold["beta"]["max_confidence95_deg"], deep, metric=view.metric
        )
        warnings.append(fold["cost"])
    if unknown:
        warnings.append(
            "the model was made of photos without control or GPS: north is not known, nor the "
            "unit, unless --unit says it"
        )
    warnings = [*loaded.warnings, *warnings, *made.warnings]
    facts = made.facts
    result = {
        "image": args.output,
        "sidecar": str(made.sidecar),
        "depth": str(made.depth),
        "world_file": None if made.world_file is None else str(made.world_file),
        "sheet": args.sheet,
        **{
            key: facts[key]
            for key in (
                "width", "height", "gsd_m", "trend_deg", "plunge_deg", "right", "down",
                "direction", "sense", "sense_reason", "coverage", "reference_point",
                "pixel_to_world", "crs", "holes_filled_px", "holes_filled_up_to_m",
            )
        },
        "fold": fold,
        "warnings": warnings,
    }  # fmt: skip
    out.result(result)
    out.warn(warnings)
    out.text(_in_words(result))


def _one_direction(args: argparse.Namespace) -> None:
    ways = [
        args.trend is not None or args.plunge is not None,
        args.plane is not None,
        args.fold is not None,
    ]
    if sum(ways) != 1:
        raise UsageError(
            tr("say once where to look: --trend T --plunge P, or --plane DD/D, or --fold TABLE.")
        )
    if ways[0] and (args.trend is None or args.plunge is None):
        raise UsageError(
            tr("a direction has both a trend and a plunge."),
            field="--plunge" if args.plunge is None else "--trend",
        )


def _fixed_view(args: argparse.Namespace) -> View | None:
    from vomstudio.geology.notation import parse_plane
    from vomstudio.products.ortho.view_directions import view_along_line, view_of_plane

    if args.fold is not None:
        return None
    if args.plane is None:
        return view_along_line(args.trend, args.plunge)
    try:
        return view_of_plane(parse_plane(args.plane, "dipdir/dip"))
    except InputError as error:
        raise UsageError(error.message, field="--plane") from error


def _fold(args: argparse.Namespace) -> tuple[dict[str, Any], list[str]]:
    from vomstudio.cli.fold import axis_of

    axis, choice = axis_of(args.fold, args.azimuth)
    found = axis.as_dict()
    fold = {
        key: found[key] for key in ("beta", "valid", "verdict", "reasons")
    } | {"used": int(choice.use.sum()), "left_out": choice.left_out}  # fmt: skip
    warnings = list(choice.table.warnings)
    if axis.valid != "yes":
        judged = "only conditionally valid" if axis.valid == "conditional" else "not valid"
        warnings.append(f"a view along this axis is {judged}: {axis.verdict}; see vomstudio fold.")
    return fold, warnings


def _fold_view(fold: dict[str, Any] | None, loaded: LoadedModel, to_world: Any) -> View:
    from vomstudio.products.ortho.view_directions import view_along_axis

    assert fold is not None
    beta = fold["beta"]
    return view_along_axis(beta["trend_deg"], beta["plunge_deg"], loaded.data, to_world)


def _in_words(result: dict[str, Any]) -> str:
    files = [result[key] for key in ("image", "depth", "sidecar", "world_file", "sheet")]
    return "\n".join(
        [
            f"{result['width']} x {result['height']} pixels of {result['gsd_m']:g} m, "
            f"{result['coverage']:.0%} covered",
            f"view toward {azimuth(result['trend_deg'])}/{result['plunge_deg']:.1f} trend/plunge, "
            f"{result['sense']}: {result['sense_reason']}",
            *(str(file) for file in files if file is not None),
        ]
    )
