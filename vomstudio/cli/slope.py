"""`vomstudio slope`: whether planes and their intersections let a rock slope fail."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import Subparsers, add_azimuth, add_command
from vomstudio.cli.common.output import Output
from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.geology.table_slopes import Mode, TableSlope


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers, "slope", run, help_=tr("Kinematic analysis of a rock slope: sliding, toppling")
    )
    parser.add_argument("table", metavar="TABLE", help=tr("table of planes"))
    parser.add_argument(
        "--face", metavar="DD/D", required=True, help=tr("dip direction and dip of the slope")
    )
    parser.add_argument(
        "--friction", type=float, metavar="DEG", required=True, help=tr("the friction angle")
    )
    parser.add_argument(
        "--lateral",
        type=float,
        metavar="DEG",
        help=tr("how far from the slope's direction planes and toppling count (default 20)"),
    )
    parser.add_argument(
        "--limits",
        choices=["curved", "straight"],
        default="curved",
        help=tr("lateral limits of planes: small circles, or of the dip direction"),
    )
    parser.add_argument(
        "--plot", metavar="FILE", help=tr("also the nets as a picture, .svg, .pdf or .png")
    )
    parser.add_argument(
        "--force", action="store_true", help=tr("replace FILE if it is there already")
    )
    add_azimuth(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.files.atomic import atomic_write, check_target
    from vomstudio.geology.table_slopes import slope_face, table_slope
    from vomstudio.io.text.orientation_reading import read_orientations
    from vomstudio.products.net.figure import picture_format

    face = slope_face(args.face, args.friction, args.lateral, args.limits)
    if args.plot is not None:
        format_ = picture_format(args.plot, "--plot")
        check_target(args.plot, force=args.force, inputs=[args.table])
    table = read_orientations(args.table, args.azimuth)
    found = table_slope(table, face)
    if args.plot is not None:
        from vomstudio.products.net.slope_figure import write_slope_figure

        with atomic_write(args.plot, args.force) as temporary:
            write_slope_figure(temporary, table, face, found, format=format_)
    out.result({**found.as_dict(), "image": args.plot})
    out.note(tr("read as {convention}", convention=found.convention))
    out.warn(found.warnings)
    out.text(_in_words(found))


def _in_words(found: TableSlope) -> str:
    face = found.face
    head = tr(
        "face {face} (dip direction/dip), friction {friction:g} deg, lateral limit {lateral:g} deg",
        face=f"{text_tables.azimuth(face.dip_direction_deg, 0)}/"
        f"{text_tables.inclination(face.dip_deg, 0)}",
        friction=found.friction_deg,
        lateral=found.lateral_deg,
    )
    rows = [
        _row(tr("planar sliding"), tr("planes"), found.planar),
        _row(tr("wedge sliding"), tr("intersections"), found.wedge),
        _row(tr("flexural toppling"), tr("planes"), found.flexural_toppling),
        _row(tr("direct toppling"), tr("intersections"), found.direct_toppling),
        _row("  " + tr("its bases"), tr("planes"), found.direct_toppling.bases),
    ]
    heads = [tr("mode"), tr("of"), tr("critical"), tr("all"), tr("share"), tr("with errors")]
    return head + "\n" + text_tables.table(heads, ["", "", "", "", "%", "%"], rows)


def _row(name: str, of: str, mode: Mode) -> list[str]:
    share, expected = (
        None if value is None else 100.0 * value for value in (mode.share, mode.probability)
    )
    return [
        name, of, str(mode.critical), str(mode.of),
        text_tables.number(share, 1), text_tables.number(expected, 1),
    ]  # fmt: skip
