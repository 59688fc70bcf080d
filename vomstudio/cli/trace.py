"""`vomstudio trace`: lines on a model: one that follows a contact, or those of a drawing."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from vomstudio.cli.common import (
    edge_networks,
    straight_traces,
    text_tables,
    trace_drawing,
    trace_proposals,
)
from vomstudio.cli.common.arguments import Subparsers, add_command, add_output, progress_of
from vomstudio.cli.common.frames_of_models import frame_options
from vomstudio.cli.common.lengths import named_by_unit, unit_of
from vomstudio.cli.common.output import Output
from vomstudio.core.findings import Message
from vomstudio.errors import GeometryError, InputError, UsageError
from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.extraction.followed_trace import FollowedTrace
    from vomstudio.extraction.proposals.edge_pictures import Find
    from vomstudio.extraction.surface_graph import SurfaceGraph
    from vomstudio.workspace.world_models import WorldModel


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers, "trace", run, help_=tr("Lines on a model: through way-points, or of a drawing")
    )
    parser.add_argument("model", metavar="MODEL", help=tr("mesh or point cloud"))
    parser.add_argument(
        "--through",
        metavar="POINTS",
        help=tr(
            "text table with x, y, z of the way-points, in World, in their order; or with column, "
            "row of a photo"
        ),
    )
    parser.add_argument(
        "--photo", metavar="PHOTO", help=tr("follow in the pixels of this photo of the model")
    )
    parser.add_argument(
        "--cameras",
        metavar="FILE",
        help=tr(
            "where the photos were taken and through what lens: cameras.json or cameras.csv, a "
            "sparse model of COLMAP, Metashape XML, reconstruction.json, shots.geojson (default: "
            "beside the model)"
        ),
    )
    parser.add_argument(
        "--cost",
        metavar="COST",
        help=tr(
            "what is followed: colour (like that at the way-points, the default), dark, light, "
            "gradient, curvature, low values of a field, auto, whichever tells the plane best, "
            "or onnx, edges of a network"
        ),
    )
    edge_networks.add_option(parser)
    straight_traces.add_sets(parser)
    add_output(parser, tr("write every vertex of the lines as CSV"), required=True)
    trace_drawing.add_options(parser)
    trace_proposals.add_options(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Raises UsageError, InputError, GeometryError or TargetError."""
    if [args.through is not None, args.from_ortho is not None, args.propose].count(True) != 1:
        raise UsageError(
            tr(
                "Give way-points, --through POINTS, or a drawing, --from-ortho DRAWING, or ask for "
                "lines to look at, --propose."
            ),
            field="--through",
        )
    edge_networks.check(args)
    if not args.propose and (args.least_length is not None or args.most is not None):
        raise UsageError(
            tr("A least length and a number of lines are for those that are proposed, --propose."),
            field="--most" if args.least_length is None else "--least-length",
        )
    if args.from_ortho is None:
        for option in trace_drawing.OPTIONS:
            if getattr(args, option):
                raise UsageError(
                    tr("{option} is for lines that were drawn, --from-ortho DRAWING.",
                       option=f"--{option}"),
                    field=f"--{option}",
                )  # fmt: skip
    if args.through is None:
        for option in ("photo", "cameras", "sets-table"):
            if getattr(args, option.replace("-", "_")) is not None:
                raise UsageError(
                    tr("{option} is for a line that is followed, --through POINTS.",
                       option=f"--{option}"),
                    field=f"--{option}",
                )  # fmt: skip
        (trace_proposals if args.propose else trace_drawing).run(args, out)
    else:
        _follow(args, out)


def _follow(args: argparse.Namespace, out: Output) -> None:
    """Raises UsageError, InputError, GeometryError or TargetError."""
    from vomstudio.extraction.followed_trace import write_path
    from vomstudio.extraction.proposals.edge_pictures import wearing_edges
    from vomstudio.extraction.surface_graph import SurfaceGraph
    from vomstudio.files.atomic import check_target
    from vomstudio.io.models.opening import resolution
    from vomstudio.jobs.edge_finding import edges_by
    from vomstudio.workspace.world_models import read_in_world

    if args.cameras is not None and args.photo is None:
        raise UsageError(
            tr("Cameras are for a photo to follow in. Name it with --photo PHOTO."),
            field="--cameras",
        )
    inputs = [args.model, args.through, args.photo, args.cameras, args.onnx_model]
    check_target(args.output, force=args.force, inputs=[i for i in inputs if i is not None])
    model = read_in_world(args.model, progress_of(args), frame_options(args), args.project)
    given, noticed = _way_points(args, model)
    if len(given) < 2:
        raise InputError(
            tr("A trace is followed between at least two way-points."), file=args.through
        )
    spacing = resolution(model.data)
    with ExitStack() as stack:
        edges = None
        if args.onnx_model is not None:
            edges = stack.enter_context(edges_by(args.onnx_model, progress_of(args)))
        try:
            progress_of(args).stage(tr("Following the contact"))
            surface = SurfaceGraph(
                model.data
                if edges is None or args.photo is not None
                else wearing_edges(model.data, spacing, *edges)
            )
            if given.shape[1] == 3:
                _require_on_model(args.through, given, surface, spacing)
            found = _found(args, model, surface, given, spacing, edges)
        except GeometryError as error:
            raise GeometryError(str(error), file=args.through) from error
    notes = [tr("followed over {model}", model=Path(args.model).name), f"cost: {found.cost}"]
    if args.photo is not None:
        notes.append(tr("in the photo {photo}", photo=Path(args.photo).name))
    write_path(args.output, found.points, crs=model.crs, notes=notes, force=args.force)
    result: dict[str, Any] = {**found.as_dict(), "table": args.output}
    result["warnings"] = [*model.warnings, *noticed, *found.warnings]
    out.result(named_by_unit(result, metric=model.in_metres))
    out.warn(result["warnings"])
    out.text(in_words(found, unit_of(model.in_metres)))


def _way_points(
    args: argparse.Namespace, model: WorldModel
) -> tuple[npt.NDArray[np.float64], Sequence[Message]]:
    """(n, 3) in World, or (n, 2) pixels where the table has columns and rows of a photo; and what
    was noticed in reading."""
    from vomstudio.io.gate.point_tables import read_points
    from vomstudio.io.gate.points import ModelFrame
    from vomstudio.io.text.pixel_tables import read_pixels

    pixels = None if args.photo is None else read_pixels(args.through)
    if pixels is not None:
        return pixels, ()
    found = read_points(args.through, model=ModelFrame(model.crs)).groups
    return found.points, found.warnings


def _found(
    args: argparse.Namespace,
    model: WorldModel,
    surface: SurfaceGraph,
    way_points: npt.NDArray[np.float64],
    spacing: float,
    edges: tuple[Find, Path] | None,
) -> FollowedTrace:
    from vomstudio.extraction.calibrated_photos import open_photos
    from vomstudio.extraction.followed_trace import followed_trace
    from vomstudio.extraction.photo_trace import photo_trace
    from vomstudio.extraction.proposals.edge_photos import showing_edges
    from vomstudio.extraction.proposals.edge_pictures import DRAWN, ONNX
    from vomstudio.io.photos.cameras_file import FILE_NAME
    from vomstudio.io.photos.own_cameras.reading import find_own_cameras

    asked: dict[str, Any] = {
        "cost": args.cost or "colour" if edges is None else DRAWN,
        "called": "" if edges is None else ONNX,
        "resolution": spacing,
        "model": Path(args.model).name,
        "frame": model.crs or "local",
        "priors": straight_traces.read_sets(args),
    }
    if args.photo is None:
        return followed_trace(surface, way_points, **asked)
    cameras = args.cameras or find_own_cameras(args.model)
    photos = open_photos(
        model.data, spacing, args.photo, cameras or Path(args.model).with_name(FILE_NAME),
        model.to_world,
    )  # fmt: skip
    if edges is not None:
        photos = showing_edges(photos, *edges)
    return photo_trace(surface, photos, way_points, **asked)


def _require_on_model(
    path: str, points: npt.NDArray[np.float64], surface: SurfaceGraph, resolution: float
) -> None:
    """Raises InputError that names the line of a way-point that is not on the model."""
    from vomstudio.extraction.followed_trace import off_the_model, why_off
    from vomstudio.io.text.tables import coordinate_columns, read_table

    row = off_the_model(surface, points, resolution)
    if row is None:
        return
    table = read_table(path)
    kept = np.isfinite(table.numbers(coordinate_columns(table))).all(axis=1)
    line = int(np.asarray(table.line_numbers)[kept][row])
    far = float(surface.snapped(points)[row])
    raise InputError(why_off(row + 1, far, resolution), file=path, line=line)


def in_words(found: FollowedTrace, unit: str) -> str:
    """How long it is, and its plane."""
    said = [
        tr(
            "The trace has {count} vertices and is {length:.3g} {unit} long; the farthest "
            "way-point lies {snap:.3g} {unit} from it.",
            unit=unit,
            count=found.vertices,
            length=found.length_m,
            snap=found.snap_m,
        )
    ]
    if found.plane is not None:
        said.append(
            tr(
                "Plane {plane} (95 %), {quality}.",
                plane=text_tables.measured_plane(found.plane),
                quality=found.plane["quality"],
            )
        )
        if found.plane["quality_reason"]:
            said.append(str(found.plane["quality_reason"]))
    if found.tried:
        said.append(
            tr(
                "Followed by {cost}, which tells the plane best of {tried}.",
                cost=found.cost,
                tried=", ".join(
                    f"{one.cost} ({text_tables.number(one.error95_deg, 1)})" for one in found.tried
                ),
            )
        )
    if found.band is not None:
        said += straight_traces.band_in_words(found.band)
    return "\n".join(said)
