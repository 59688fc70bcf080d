"""`vomstudio stereonet`: the orientations of a table as a picture."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.cli.arguments import Subparsers, add_azimuth, add_command, add_output
from vomstudio.cli.output import Output
from vomstudio.errors import UsageError
from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.io.text.orientation_reading import OrientationTable
    from vomstudio.products.net.contents import NetContents

UNNAMED = "unassigned"


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers,
        "stereonet",
        run,
        help_=tr("Draw a stereonet, lower hemisphere, as SVG, PDF or PNG"),
    )
    parser.add_argument("table", metavar="TABLE", help=tr("table of planes or lines"))
    add_output(parser, "the picture, by its ending: .svg, .pdf or .png", required=True)
    parser.add_argument(
        "--set",
        metavar="COLUMN",
        dest="set_column",
        help=tr("colour by this column (name or number)"),
    )
    parser.add_argument(
        "--contour", metavar="METHOD", help=tr("density: kamb, exponential_kamb ...")
    )
    parser.add_argument(
        "--projection",
        choices=["area", "angle"],
        default="area",
        help=tr("equal area or equal angle"),
    )
    add_azimuth(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.files.atomic import atomic_write, check_target
    from vomstudio.geology.stereonet import DENSITY_METHODS
    from vomstudio.io.text.orientation_reading import read_orientations

    format_ = _format(args.output)
    if args.contour is not None and args.contour not in DENSITY_METHODS:
        raise UsageError(
            tr(
                "'{contour}' is no way to contour; use {DENSITY_METHODS}.",
                contour=args.contour,
                DENSITY_METHODS=", ".join(DENSITY_METHODS),
            ),
            field="--contour",
        )
    check_target(args.output, force=args.force, inputs=[args.table])
    table = read_orientations(args.table, args.azimuth)
    net = _net(table, args)

    from vomstudio.products.net.figure import write_stereonet

    with atomic_write(args.output, args.force) as temporary:
        write_stereonet(temporary, net, format=format_)
    out.result(
        {
            "image": args.output,
            "n": len(table),
            "sets": {s.name: len(s) for s in net.sets},
            "projection": args.projection,
            "hemisphere": "lower",
            "contour": args.contour,
            "convention": table.convention,
            "dropped_lines": list(table.dropped),
            "warnings": list(table.warnings),
        }
    )
    out.note(f"read as {table.convention}")
    out.warn(table.warnings)
    sets = ", ".join(f"{s.name} (n = {len(s)})" for s in net.sets)
    out.text(f"{args.output}: {sets}; equal {args.projection}, lower hemisphere")


def _format(path: str) -> str:
    from vomstudio.products.net.figure import FORMATS

    ending = Path(path).suffix.lower().removeprefix(".")
    if ending not in FORMATS:
        raise UsageError(
            tr("the ending says what to draw: .svg, .pdf or .png."), file=path, field="--output"
        )
    return ending


def _net(table: OrientationTable, args: argparse.Namespace) -> NetContents:
    from vomstudio.geology.statistics import no_fisher_reason
    from vomstudio.products.net.contents import NetContents, make_sets, means_of

    groups: dict[str, tuple[str, Any, Any]] = {}
    for name, members in _members(table, args.set_column).items():
        for kind, wanted in (("plane", True), ("line", False)):
            rows = [i for i in members if table.is_plane[i] == wanted]
            if not rows:
                continue
            both = len(rows) < len(members)
            label = f"{name} ({kind}s)" if both else name
            azimuth, angle = (
                (table.dip_direction_deg, table.dip_deg)
                if wanted
                else (table.trend_deg, table.plunge_deg)
            )
            groups[label] = (kind, azimuth[rows], angle[rows])
    sets = make_sets(groups)
    # A mean of a girdle, or of a scatter, is a mark that means nothing.
    clustered = [s for s in sets if no_fisher_reason(s.vectors(), False) is None]
    return NetContents(
        sets=sets,
        projection=args.projection,
        contour=args.contour,
        means=means_of(clustered),
    )


def _members(table: OrientationTable, column: str | None) -> dict[str, list[int]]:
    """Rows by the column asked for, else by set, else by kind, else all together."""
    if column is not None:
        names = table.column(column)
    elif table.sets is not None and any(table.sets):
        names = list(table.sets)
    elif table.kinds is not None and any(table.kinds):
        names = list(table.kinds)
    else:
        names = ["planes" if plane else "lines" for plane in table.is_plane]
    rows: dict[str, list[int]] = {}
    for i, name in enumerate(names):
        rows.setdefault(name or UNNAMED, []).append(i)
    return rows
