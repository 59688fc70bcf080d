"""`vomstudio register`: a model placed by what is known of its place."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import Parser, Subparsers, add_command, add_output, progress_of
from vomstudio.cli.common.output import Output
from vomstudio.core.findings import Finding
from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.registration.attitude_evidence import AttitudeMiss
    from vomstudio.registration.results import Placed
    from vomstudio.workspace.placing.reference_fitting import ReferenceFit
    from vomstudio.workspace.placing.register_order import Registered

BESIDE = "beside the model"


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers,
        "register",
        run,
        help_=tr("Place a model by points, cameras, compass readings or lengths"),
    )
    parser.add_argument(
        "model",
        metavar="MODEL",
        help=tr("model or cloud in any format that is read; - solves for the placement alone"),
    )
    for option, said in (
        ("--pairs", tr("table: label, model_x, model_y, model_z, x, y, z[, use, sigma_x, …]")),
        ("--scale-bars", tr("table: from, to, length_m[, sigma_m, use]; labels of the pairs")),
        ("--horizon", tr("table: photo, x1, y1, x2, y2: pixels of a level line")),
        ("--orientations", tr("orientation table with model_x, model_y, model_z (normals, lines)")),
        ("--gcp", tr("control points with coordinates; their marks are in it, or beside it")),
        ("--marks", tr("where the control points are marked in the photos")),
    ):
        parser.add_argument(option, metavar="FILE", help=said)
    parser.add_argument(
        "--model-cameras",
        metavar="FILE",
        help=tr("where the model's own cameras are: cameras.json, a sparse model of COLMAP, "
                "Metashape XML, reconstruction.json, shots.geojson (default: beside the model)"),
    )  # fmt: skip
    parser.add_argument(
        "--cameras",
        metavar="FILE",
        nargs="?",
        const=BESIDE,
        help=tr("table: photo, x, y, z (or longitude, latitude, altitude), geo.txt, or a folder of "
                "photos with GPS; without FILE the photos where they are found"),
    )  # fmt: skip
    parser.add_argument(
        "--attitudes",
        metavar="FILE",
        nargs="?",
        const=BESIDE,
        help=tr("table: photo, yaw, pitch, roll[, sigma_yaw, …, north], or a folder of photos that "
                "say how they were held; without FILE the photos where they are found"),
    )  # fmt: skip
    parser.add_argument(
        "--north",
        choices=("grid", "true", "magnetic"),
        default="grid",
        help=tr("what azimuths are counted from where a table does not say (default: grid)"),
    )
    parser.add_argument("--date", metavar="DAY", help=tr("of compass readings, for declination"))
    parser.add_argument(
        "--declination", metavar="DEG", help=tr("of magnetic north, east positive (default: IGRF)")
    )
    parser.add_argument(
        "--north-sigma",
        metavar="DEG",
        help=tr("how far a compass may be off for all its readings alike, one sigma (default: 10 "
                "for photos, 2 for other azimuths from magnetic north, else 0)"),
    )  # fmt: skip
    parser.add_argument(
        "--click-sigma",
        metavar="M",
        help=tr("error of the click on the model, one sigma, beside the accuracy of the points "
                "(default: half the resolution of the model; 0 without a model)"),
    )  # fmt: skip
    _add_lines(parser)
    parser.add_argument(
        "--without",
        metavar="LABEL",
        action="append",
        default=[],
        help=tr("leave out the point, reading, photo or line of this label; may be repeated"),
    )
    parser.add_argument(
        "--robust",
        action="store_true",
        help=tr("leave out what cannot be right beside the others, and name it"),
    )
    parser.add_argument(
        "--keep-scale",
        action="store_true",
        help=tr("the scale of the model is right as it is: only turn and shift it"),
    )
    _add_reference(parser)
    parser.add_argument("--crs", metavar="EPSG", help=tr("the projected CRS that it is placed in"))
    add_output(parser, tr("write the placed model"))


def _add_lines(parser: Parser) -> None:
    parser.add_argument(
        "--scale",
        metavar="X1,Y1,Z1,X2,Y2,Z2,METRES[,SIGMA]",
        action="append",
        default=[],
        help=tr("two places on the model, the metres between them, and where wanted the error of "
                "these, one sigma (default: 0.5 %%)"),
    )  # fmt: skip
    parser.add_argument(
        "--bearing",
        metavar="X1,Y1,Z1,X2,Y2,Z2,DEG[,SIGMA]",
        action="append",
        default=[],
        help=tr("two places on the model, the azimuth from the first to the second, and where "
                "wanted its error, degrees, one sigma (default: 3)"),
    )  # fmt: skip
    for option, said in (
        ("--level", tr("two places on the model that are at one height, and the error of that, "
                       "degrees, one sigma (default: 0.5)")),
        ("--plumb", tr("two places on the model that are one above the other, and the error of "
                       "that, degrees, one sigma (default: 0.5)")),
    ):  # fmt: skip
        parser.add_argument(
            option, metavar="X1,Y1,Z1,X2,Y2,Z2[,SIGMA]", action="append", default=[], help=said
        )


def _add_reference(parser: Parser) -> None:
    parser.add_argument(
        "--reference",
        metavar="MODEL",
        help=tr("fit it to this mesh or cloud of the same rock, which stands where it should"),
    )
    parser.add_argument(
        "--stable",
        metavar="MASK",
        help=tr("polygons, or a cloud, of the part of the reference that has not moved"),
    )


def run(args: argparse.Namespace, out: Output) -> None:
    """Raises UsageError, InputError, GeometryError or TargetError."""
    from vomstudio.files.atomic import check_target
    from vomstudio.workspace.placing.register_order import RegisterOrder, register_model

    if args.output is not None:
        if args.model != "-":
            from vomstudio.io.models.writing import choose_writer

            choose_writer(Path(args.output))
        check_target(
            args.output, force=args.force, inputs=[] if args.model == "-" else [args.model]
        )
    order = RegisterOrder(**{each.name: getattr(args, each.name) for each in fields(RegisterOrder)})
    found = register_model(order, progress_of(args))
    result = found.as_dict()
    warnings = list(found.placed.warnings)
    if args.output is not None:
        warnings += _written(args, found, result)
    result["warnings"] = warnings
    out.result(result)
    out.warn(warnings)
    if found.fitted is not None:
        out.text(_fit_in_words(found.fitted))
    out.text(in_words(found.placed))
    if found.attitudes:
        out.text(_of_photos(found.attitudes))


def _of_photos(photos: Sequence[AttitudeMiss]) -> str:
    rows = [
        [p.photo, *(text_tables.figures(v) for v in (p.yaw_deg, p.pitch_deg, p.roll_deg))]
        for p in photos
    ]
    heads = [tr("photo"), tr("yaw"), tr("pitch"), tr("roll")]
    return "\n" + text_tables.table(heads, ["", "°", "°", "°"], rows)


def _fit_in_words(fitted: ReferenceFit) -> str:
    from vomstudio.registration.remarks import reference_fit_finding

    found = fitted.fitted
    return reference_fit_finding(
        found.places, found.overlap, found.rms_m, found.blocks, found.block_m
    ).message


def _written(args: argparse.Namespace, made: Registered, result: dict[str, Any]) -> list[Finding]:
    loaded = made.loaded
    if loaded is None:
        from vomstudio.cli.common.output import to_json
        from vomstudio.files.atomic import write_bytes

        write_bytes(Path(args.output), (to_json(result) + "\n").encode(), force=args.force)
        return []
    from vomstudio.geometry.moving import moved
    from vomstudio.geometry.units import Axes
    from vomstudio.io.models.model_copy import companions
    from vomstudio.io.models.writing import write_model

    known = made.placed.known
    warnings = write_model(
        moved(loaded.data, made.placed.matrix),
        made.crs if known.all else None,
        args.output,
        force=args.force,
        inputs=[loaded.path, *companions(loaded.path)],
        progress=progress_of(args),
        axes=Axes(metric=known.scale, north=known.north and known.vertical),
        registration=made.registration_in_world,
    )
    result["out"] = args.output
    return warnings


def in_words(found: Placed) -> str:
    """Two tables and sentences."""
    from vomstudio.registration.remarks import worst_axis_findings

    blocks = []
    for title, points in ((tr("control"), found.control), (tr("check"), found.check)):
        if points:
            rows = [
                [title, p.label, *(text_tables.figures(v) for v in (p.dx, p.dy, p.dz, p.error_m))]
                for p in points
            ]
            heads = [tr("use"), tr("label"), "dx", "dy", "dz", tr("error")]
            blocks.append(text_tables.table(heads, ["", "", "m", "m", "m", "m"], rows))
    if found.without:
        rows = [
            [w.label, *(text_tables.figures(v) for v in (
                w.error_deg, w.turned_deg, w.others_deg, w.weakest_95_deg))]
            for w in found.without
        ]  # fmt: skip
        heads = [tr("without"), tr("it is off"), tr("model turns"), tr("others agree"),
                 tr("worst 95 %")]  # fmt: skip
        blocks.append(text_tables.table(heads, ["", "°", "°", "°", "°"], rows))
    return "\n".join([*blocks, *map(str, worst_axis_findings(found))])
