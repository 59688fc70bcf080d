"""`vomstudio extend`: a plane carried on through a model, with how far off it may be."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import Subparsers, add_command, add_output, progress_of
from vomstudio.cli.common.frames_of_models import add_frame, frame_options
from vomstudio.cli.common.labelled_models import write_labelled
from vomstudio.cli.common.lengths import named_by_unit, unit_of
from vomstudio.cli.common.output import Output
from vomstudio.core.findings import Message
from vomstudio.errors import GeometryError, UsageError
from vomstudio.words import tr, tr_n

if TYPE_CHECKING:
    from vomstudio.geology.beds.extended import PlaneBelief
    from vomstudio.products.section.extension import ExtendedPlane
    from vomstudio.workspace.world_models import WorldModel

_SHOWN = 20


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers,
        "extend",
        run,
        help_=tr("Carry a plane on through a model, with the error of its position"),
    )
    parser.add_argument("model", metavar="MODEL", help=tr("mesh or point cloud"))
    parser.add_argument(
        "points", metavar="POINTS", nargs="?", help=tr("points of the plane, a table x, y, z")
    )
    parser.add_argument("--plane", metavar="DD/D", help=tr("or its dip direction and dip"))
    parser.add_argument("--through", metavar="X,Y,Z", help=tr("with a point of World on it"))
    parser.add_argument(
        "--error", metavar="DEG", type=float, help=tr("95 %% error of --plane, to all sides")
    )
    parser.add_argument(
        "--through-error", metavar="M", type=float, help=tr("95 %% error of --through (0)")
    )
    add_output(parser, tr("its traces on the model, .csv or .gpkg"), required=True)
    parser.add_argument(
        "--thickness", metavar="M", type=float, help=tr("repeat it at this thickness of the beds")
    )
    parser.add_argument(
        "--thickness-error", metavar="M", type=float, help=tr("95 %% error of --thickness (0)")
    )
    parser.add_argument(
        "--labels",
        metavar="OUT.ply",
        help=tr("write the model with the distance from the plane, its error, and the band"),
    )
    add_frame(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Raises UsageError, InputError, GeometryError or TargetError."""
    from vomstudio.files.atomic import check_target
    from vomstudio.geometry.mesh import Mesh
    from vomstudio.io.models.opening import point_spacing
    from vomstudio.io.models.writing import choose_writer
    from vomstudio.products.section.extension import extend, format_of, write_traces
    from vomstudio.workspace.world_models import read_in_world

    format_of(args.output)
    inputs = [args.model, *([args.points] if args.points else [])]
    check_target(args.output, force=args.force, inputs=inputs)
    if args.labels is not None:
        choose_writer(Path(args.labels))
        check_target(args.labels, force=args.force, inputs=[*inputs, args.output])
    if args.thickness is None and args.thickness_error is not None:
        raise UsageError(tr("--thickness-error is for --thickness."), field="--thickness-error")
    _check_plane(args)
    progress = progress_of(args)
    model = read_in_world(args.model, progress, frame_options(args))
    belief, said = _belief(args, model)
    progress.stage(tr("Extending the plane"))
    spacing = 0.0 if isinstance(model.data, Mesh) else point_spacing(model.data)
    found = extend(
        model.data,
        belief,
        thickness_m=args.thickness,
        thickness_error_m=args.thickness_error or 0.0,
        spacing=spacing,
    )
    progress.stage(tr("Writing the results"))
    write_traces(
        args.output, found, crs=model.crs, model=Path(args.model).name, force=args.force,
        axes=model.axes,
    )  # fmt: skip
    warnings = [*model.warnings, *said, *found.warnings]
    result: dict[str, Any] = {"file": args.output, **found.as_dict()}
    if args.labels is not None:
        warnings += write_labelled(args, model, found.as_fields())
        result["labels"] = args.labels
    result["warnings"] = warnings
    out.result(named_by_unit(result, metric=model.in_metres))
    out.warn(warnings)
    out.text(in_words(found, unit_of(model.in_metres)))


def _check_plane(args: argparse.Namespace) -> None:
    """Raise UsageError if the plane is given twice or in part."""
    typed = [args.plane, args.through, args.error, args.through_error]
    if args.points is not None and any(value is not None for value in typed):
        raise UsageError(tr("Give the points of the plane, or --plane with --through."))
    if args.points is None and None in typed[:3]:
        raise UsageError(
            tr(
                "Give the points of the plane, or --plane DD/D with --through X,Y,Z and "
                "--error DEG."
            ),
            field="--error" if args.plane and args.through else "--plane",
        )


def _belief(args: argparse.Namespace, model: WorldModel) -> tuple[PlaneBelief, tuple[Message, ...]]:
    """Return the plane with its error, in World."""
    from vomstudio.geology.beds.extended import belief_of_attitude, belief_of_fit
    from vomstudio.geometry.planes import fit_plane
    from vomstudio.io.gate.point_tables import read_points
    from vomstudio.io.gate.points import ModelFrame
    from vomstudio.products.section.curtain import parse_section_plane, parse_through

    if args.points is not None:
        read = read_points(args.points, model=ModelFrame(model.crs))
        given = read.groups
        try:
            return belief_of_fit(fit_plane(given.points)), given.warnings
        except GeometryError as error:
            raise GeometryError(error.message, file=args.points) from error
    plane = parse_section_plane(args.plane)
    through = parse_through(args.through)
    return belief_of_attitude(plane, through, args.error, args.through_error or 0.0), ()


def in_words(found: ExtendedPlane, unit: str) -> str:
    """The planes that meet the model, and how well their place is known."""
    rows = [
        [
            str(bed.bed),
            text_tables.figures(bed.offset_m),
            text_tables.figures(bed.length_m),
            text_tables.figures(bed.least_error95_m),
            text_tables.figures(bed.most_error95_m),
        ]
        for bed in found.beds[:_SHOWN]
    ]
    heads = [tr("bed"), tr("offset"), tr("length"), tr("95 % least"), tr("95 % most")]
    said = [
        tr(
            "Plane {plane} (95 %), carried on over the model.",
            plane=text_tables.measured_plane(vars(found), "max_error95_deg"),
        ),
        text_tables.table(heads, ["", *[unit] * 4], rows),
    ]
    more = len(found.beds) - _SHOWN
    if more > 0:
        said.append(tr_n("{count} more is in the file.", "{count} more are in the file.", more))
    return "\n".join(said)
