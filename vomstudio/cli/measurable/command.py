"""`vomstudio measurable`: how well a plane could be measured, before anyone picks."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.angles import plane_of
from vomstudio.cli.common.arguments import (
    Subparsers,
    add_azimuth,
    add_command,
    add_output,
    progress_of,
)
from vomstudio.cli.common.frames_of_models import (
    add_frame,
    add_project,
    frame_options,
    unknown_unit,
)
from vomstudio.cli.common.labelled_models import write_labelled
from vomstudio.cli.common.lengths import named_by_unit
from vomstudio.cli.common.output import Output
from vomstudio.core.findings import Message
from vomstudio.errors import UsageError
from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.geology.orientation import Plane
    from vomstudio.products.surface.measurable_map import MeasurableMap
    from vomstudio.workspace.world_models import WorldModel


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers,
        "measurable",
        run,
        help_=tr("Map of how well a plane could be measured on a model"),
    )
    parser.add_argument("model", metavar="MODEL", help=tr("mesh or point cloud"))
    parser.add_argument("--plane", metavar="DD/D", help=tr("dip direction and dip of the plane"))
    parser.add_argument(
        "--mean", metavar="TABLE", help=tr("or the mean plane of this table, see --set")
    )
    parser.add_argument("--set", metavar="NAME", help=tr("of the table, only this set"))
    parser.add_argument(
        "--length",
        metavar="M",
        type=float,
        help=tr("of a trace (100 resolutions of the model)"),
    )
    parser.add_argument(
        "--noise",
        metavar="M",
        type=float,
        help=tr("standard deviation of a trace's vertices across their plane"),
    )
    parser.add_argument(
        "--points", metavar="N", type=int, help=tr("of a trace (one for each resolution)")
    )
    parser.add_argument(
        "--resolution", metavar="M", type=float, help=tr("of the model (by its points)")
    )
    parser.add_argument(
        "--angle",
        metavar="DEG",
        type=float,
        help=tr("within which a face is the plane's own (10)"),
    )
    parser.add_argument(
        "--registration-error",
        metavar="DEG",
        type=float,
        help=tr("95 %% by which the registration can tilt the plane (that of --project, else 0)"),
    )
    add_output(parser, tr("the map, a raster .tif or the model with its fields, .ply"))
    parser.add_argument("--gsd", metavar="M", type=float, help=tr("side of a cell of the raster"))
    add_azimuth(parser)
    add_frame(parser)
    add_project(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Raises UsageError, InputError, GeometryError or TargetError."""
    from vomstudio.cli.common.naming import numbers_of
    from vomstudio.files.atomic import check_target
    from vomstudio.io.models.writing import choose_writer
    from vomstudio.products.surface.measurable_map import (
        RASTER_ENDINGS,
        measurable_map,
        write_raster,
    )
    from vomstudio.workspace.world_models import read_in_world

    plane, said = _plane(args)
    raster = args.output is not None and Path(args.output).suffix.lower() in RASTER_ENDINGS
    if args.output is not None:
        if not raster:
            choose_writer(Path(args.output))
        inputs = [args.model, *([args.mean] if args.mean else [])]
        check_target(args.output, force=args.force, inputs=inputs)
    if args.gsd is not None and not raster:
        raise UsageError(tr("--gsd is for a raster, -o NAME.tif."), field="--gsd")
    progress = progress_of(args)
    model = read_in_world(args.model, progress, frame_options(args), args.project)
    with numbers_of(args.model):
        found = measurable_map(
            model.data,
            plane,
            length_m=args.length,
            resolution_m=args.resolution,
            noise_m=args.noise,
            points=args.points,
            angle_deg=args.angle,
            registration_deg=_registration(args, model, plane),
            progress=progress,
        )
    warnings = [*model.warnings, *said, *unknown_unit(model)]
    warnings += found.warnings
    result: dict[str, Any] = {"file": args.output, **found.as_dict()}
    if raster:
        result["raster"] = write_raster(
            args.output, model.data, found, crs=model.crs, cell_m=args.gsd, force=args.force,
            progress=progress,
        )  # fmt: skip
    elif args.output is not None:
        args.labels = args.output
        warnings += write_labelled(args, model, found.as_fields())
    result["warnings"] = warnings
    out.result(named_by_unit(result, metric=model.in_metres))
    out.warn(warnings)
    out.text(in_words(found))


def _plane(args: argparse.Namespace) -> tuple[Plane, tuple[Message, ...]]:
    """As typed, or the mean of a table's planes, and what is to be said of it."""
    if (args.plane is None) == (args.mean is None):
        raise UsageError(tr("Give the plane as --plane DD/D, or --mean TABLE."), field="--plane")
    if args.plane is not None:
        if args.set is not None:
            raise UsageError(tr("--set is for --mean."), field="--set")
        return plane_of(args.plane, "--plane"), ()
    from vomstudio.geology.populations.table_means import mean_plane
    from vomstudio.io.text.orientation_reading import read_orientations

    table = read_orientations(args.mean, args.azimuth)
    return mean_plane(table, args.set), tuple(table.warnings)


def _registration(args: argparse.Namespace, model: WorldModel, plane: Plane) -> float:
    """95 % by which the plane may be tilted, degrees."""
    if args.registration_error is not None:
        return float(args.registration_error)
    if model.in_project is None:
        return 0.0
    from vomstudio.document.measurement import ToWorld

    return ToWorld.of(model.in_project).tilt_deg(plane.normal()) or 0.0


def in_words(found: MeasurableMap) -> str:
    """How much of the model would tell the plane, and where most."""
    from vomstudio.products.surface.measurable_map import shares_in_words

    figures = text_tables.figures
    plane = (
        f"{text_tables.azimuth(found.plane['dip_direction_deg'], 1)}/"
        f"{text_tables.inclination(found.plane['dip_deg'], 1)}"
    )
    said = [
        tr(
            "Plane {plane}, traces of {length} m, resolution {resolution} m.",
            plane=plane,
            length=figures(found.length_m),
            resolution=figures(found.resolution_m),
        ),
        *shares_in_words(found),
    ]
    if found.best is not None:
        said.append(
            tr(
                "A trace would tell most at {x:.2f}, {y:.2f}, {z:.2f}: within {error} deg.",
                x=found.best["x"],
                y=found.best["y"],
                z=found.best["z"],
                error=text_tables.number(found.best["error95_deg"], 2),
            )
        )
    return "\n".join(said)
