"""`vomstudio trace`: lines on a model: one that follows a contact, or those of a drawing."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from vomstudio.cli.common import text_tables, trace_drawing
from vomstudio.cli.common.arguments import Subparsers, add_command, add_output, progress_of
from vomstudio.cli.common.frames_of_models import declared_of
from vomstudio.cli.common.output import Output
from vomstudio.errors import GeometryError, InputError, UsageError
from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.extraction.followed_trace import FollowedTrace
    from vomstudio.extraction.surface_graph import SurfaceGraph


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers, "trace", run, help_=tr("Lines on a model: through way-points, or of a drawing")
    )
    parser.add_argument("model", metavar="MODEL", help=tr("mesh or point cloud"))
    parser.add_argument(
        "--through",
        metavar="POINTS",
        help=tr("text table with x, y, z of the way-points, in World, in their order"),
    )
    parser.add_argument(
        "--cost",
        metavar="COST",
        default="colour",
        help=tr(
            "what is followed: colour (like that at the way-points, the default), dark, light, "
            "gradient, curvature, or low values of a field"
        ),
    )
    add_output(parser, tr("write every vertex of the lines as CSV"), required=True)
    trace_drawing.add_options(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Raises UsageError, InputError, GeometryError or TargetError."""
    if (args.through is None) == (args.from_ortho is None):
        raise UsageError(
            tr("Give way-points, --through POINTS, or a drawing, --from-ortho DRAWING."),
            field="--through",
        )
    if args.from_ortho is not None:
        trace_drawing.run(args, out)
    else:
        _follow(args, out)


def _follow(args: argparse.Namespace, out: Output) -> None:
    """Raises UsageError, InputError, GeometryError or TargetError."""
    from vomstudio.extraction.followed_trace import followed_trace, write_path
    from vomstudio.extraction.surface_graph import SurfaceGraph
    from vomstudio.files.atomic import check_target
    from vomstudio.io.models.opening import resolution
    from vomstudio.io.text.tables import read_points
    from vomstudio.workspace.world_models import read_in_world

    check_target(args.output, force=args.force, inputs=[args.model, args.through])
    given = read_points(args.through)
    if len(given.points) < 2:
        raise InputError(
            tr("A trace is followed between at least two way-points."), file=args.through
        )
    model = read_in_world(args.model, progress_of(args), declared_of(args))
    spacing = resolution(model.data)
    try:
        surface = SurfaceGraph(model.data)
        _require_on_model(args.through, given.points, surface, spacing)
        found = followed_trace(
            surface, given.points, cost=args.cost, resolution=spacing,
            model=Path(args.model).name, frame=model.crs or "local",
        )  # fmt: skip
    except GeometryError as error:
        raise GeometryError(str(error), file=args.through) from error
    notes = [tr("followed over {model}", model=Path(args.model).name), f"cost: {args.cost}"]
    write_path(args.output, found.points, crs=model.crs, notes=notes, force=args.force)
    result: dict[str, Any] = {**found.as_dict(), "table": args.output}
    result["warnings"] = [*model.warnings, *given.warnings, *found.warnings]
    out.result(result)
    out.warn(result["warnings"])
    out.text(in_words(found))


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


def in_words(found: FollowedTrace) -> str:
    """How long it is, and its plane."""
    said = [
        tr(
            "The trace has {count} vertices and is {length:.3g} m long; the farthest way-point "
            "lies {snap:.3g} m from it.",
            count=found.vertices,
            length=found.length_m,
            snap=found.snap_m,
        )
    ]
    if found.plane is not None:
        said.append(
            tr(
                "Plane {plane}, 95 % {error} deg, {quality}.",
                plane=f"{text_tables.azimuth(found.plane['dip_direction_deg'], 1)}/"
                f"{text_tables.inclination(found.plane['dip_deg'], 1)}",
                error=text_tables.number(found.plane["total95_deg"], 2),
                quality=found.plane["quality"],
            )
        )
        if found.plane["quality_reason"]:
            said.append(str(found.plane["quality_reason"]))
    return "\n".join(said)
