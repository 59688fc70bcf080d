"""`vomstudio section`: where a plane or a vertical curtain cuts a model."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common.arguments import (
    Subparsers,
    add_azimuth,
    add_command,
    add_output,
    progress_of,
)
from vomstudio.cli.common.frames_of_models import add_frame, add_project, frame_options
from vomstudio.cli.common.lengths import named_by_unit, unit_of
from vomstudio.cli.common.output import Output
from vomstudio.core.findings import Message
from vomstudio.errors import InputError, UsageError
from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.products.section.curtain import Curtain
    from vomstudio.products.section.reading import ProfileLine
    from vomstudio.workspace.world_models import WorldModel


DOMAINS = "domains"


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers, "section", run, help_=tr("Section of a model along a plane or a line")
    )
    parser.add_argument("model", metavar="MODEL", help=tr("mesh, point cloud or table x, y, z"))
    parser.add_argument("--plane", metavar="DD/D", help=tr("plane of the section (with --through)"))
    parser.add_argument("--through", metavar="X,Y,Z", help=tr("a point of World on that plane"))
    parser.add_argument(
        "--section-line",
        metavar="LINE",
        help=tr("or vertically along the line in this file: a table x, y, or a GIS layer"),
    )
    add_output(parser, tr("the section, .csv, .dxf or .svg"), required=True)
    parser.add_argument(
        "--slab", type=float, metavar="M", help=tr("of a cloud: thickness of the slab of points")
    )
    parser.add_argument(
        "--features",
        metavar="FILE",
        help=tr("also project the features of this project or orientation table onto it"),
    )
    parser.add_argument(
        "--along",
        metavar="T/P|domains",
        help=tr(
            "project along this trend and plunge (default: at right angles), or with the word "
            "domains each domain along its own axis"
        ),
    )
    parser.add_argument(
        "--within", type=float, metavar="M", help=tr("leave out features farther away than this")
    )
    add_azimuth(parser)
    add_frame(parser)
    add_project(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.geometry.mesh import Mesh
    from vomstudio.io.gate.points import ModelFrame
    from vomstudio.io.models.opening import point_spacing
    from vomstudio.products.section import writing
    from vomstudio.products.section.cutting import cut_model
    from vomstudio.products.section.directions import Directions, by_domain
    from vomstudio.products.section.reading import ReadFeatures, read_features
    from vomstudio.workspace.world_models import read_in_world

    asked = _asked(args)
    for value, field in ((args.slab, "--slab"), (args.within, "--within")):
        if value is not None and not 0 < value < math.inf:
            raise UsageError(tr("A thickness or distance is a length in metres."), field=field)
    if args.features is None and (args.along is not None or args.within is not None):
        raise UsageError(
            tr("--along and --within are for --features."),
            field="--along" if args.along is not None else "--within",
        )
    along = None if args.along == DOMAINS else _direction(args.along)
    writing.check_targets(args.output, args.features is not None, force=args.force)
    model = read_in_world(args.model, progress_of(args), frame_options(args), args.project)
    read = ReadFeatures()
    if args.features is not None:
        read = read_features(args.features, args.azimuth, ModelFrame(model.crs))
    own = args.along == DOMAINS
    directions = by_domain(read.items, "--along") if own else Directions(along)
    if args.slab is not None and isinstance(model.data, Mesh):
        raise UsageError(tr("A mesh is cut exactly. --slab is for clouds."), field="--slab")
    curtain, warnings = _curtain(asked, model)
    grazing = directions.checked(curtain)
    spacing = 0.0 if isinstance(model.data, Mesh) else point_spacing(model.data)
    progress_of(args).stage(tr("Intersecting the model"))
    cut = cut_model(model.data, curtain, args.slab, spacing if math.isfinite(spacing) else 0.0)
    flats, left_out = writing.project_items(read.items, curtain, directions, args.within)
    try:
        figures = writing.figures_of(cut, curtain, flats, left_out, directions)
    except InputError as error:
        raise error.of_file(args.model) from error
    made = writing.write_section(
        args.output,
        cut,
        curtain,
        figures,
        flats,
        crs=model.crs,
        model=str(model.loaded.path),
        metric=model.in_metres,
        north_known=model.placed,
        warnings=(*model.warnings, *read.warnings, *warnings, *grazing),
        force=args.force,
    )
    told = {**made.as_dict(), "convention": read.convention or None}
    out.result(named_by_unit(told, metric=model.in_metres))
    if read.convention:
        out.note(tr("read as {convention}", convention=read.convention))
    out.warn(made.warnings)
    words = writing.projection_words(figures)
    out.text(_in_words(made.as_dict(), unit_of(model.in_metres), words))


def _asked(args: argparse.Namespace) -> Curtain | ProfileLine:
    """The section by a plane, or the line along which it is to run. Raises UsageError,
    InputError."""
    from vomstudio.products.section.curtain import (
        curtain_of_plane,
        parse_section_plane,
        parse_through,
    )
    from vomstudio.products.section.reading import read_profile_line

    by_plane = args.plane is not None or args.through is not None
    if by_plane == (args.section_line is not None):
        raise UsageError(tr("Give --plane DD/D with --through x,y,z, or --section-line LINE."))
    if args.section_line is None:
        if args.plane is None or args.through is None:
            raise UsageError(
                tr("A plane needs its orientation and a point: --plane DD/D --through x,y,z."),
                field="--through" if args.through is None else "--plane",
            )
        plane = parse_section_plane(args.plane)
        return curtain_of_plane(plane, parse_through(args.through))
    return read_profile_line(args.section_line, progress_of(args))


def _curtain(
    asked: Curtain | ProfileLine, model: WorldModel
) -> tuple[Curtain, tuple[Message, ...]]:
    """In World, and what must be said of a line. Raises InputError."""
    import numpy as np

    from vomstudio.products.section.curtain import Curtain, curtain_of_line
    from vomstudio.products.section.reading import profile_in_world

    if isinstance(asked, Curtain):
        return asked, ()
    bounds = np.array(model.data.bounds, np.float64)
    points, warnings = profile_in_world(asked, model.crs, bounds)
    try:
        return curtain_of_line(points), warnings
    except InputError as error:
        raise InputError(error.message, file=asked.path, field=error.field) from error


def _direction(text: str | None) -> Any:
    from vomstudio.geology.notation import parse_line

    if text is None:
        return None
    try:
        return parse_line(text).vector()
    except InputError as error:
        raise UsageError(error.message, field="--along") from error


def _in_words(result: dict[str, Any], unit: str, projected: list[str]) -> str:
    said = [
        tr(
            "{count} lines, {length:.3f} {unit} in all",
            unit=unit,
            count=result["polylines"],
            length=result["length_m"],
        )
    ]
    if result["slab_m"] is not None:
        said.append(
            tr(
                "{count} points of a slab {slab:.3g} {unit} thick",
                unit=unit,
                count=result["points"],
                slab=result["slab_m"],
            )
        )
    if result["features"] or result["left_out"]:
        said.append(
            tr(
                "{count} features projected, {left_out} left out",
                count=result["features"],
                left_out=result["left_out"],
            )
        )
    said += projected
    said += [file for file in (result["file"], result["features_file"]) if file is not None]
    return "\n".join(said)
