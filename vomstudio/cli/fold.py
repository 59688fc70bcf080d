"""`vomstudio fold`: pi-plane and fold axis, or the axis common to several sets."""

from __future__ import annotations

import argparse
from typing import Any

from vomstudio.cli import text_tables
from vomstudio.cli.arguments import Subparsers, add_azimuth, add_command
from vomstudio.cli.output import Output
from vomstudio.words import tr


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers, "fold", run, help_=tr("Pi-plane, fold axis beta and its verdict")
    )
    parser.add_argument("table", metavar="TABLE", help=tr("table of planes"))
    parser.add_argument(
        "--kind",
        help=tr("use planes of this kind only (default bedding, if the table has kinds)"),
    )
    parser.add_argument(
        "--sets",
        metavar="A,B[,C]",
        help=tr("the axis common to these sets (hanging wall, footwall, fault), by their means"),
    )
    add_azimuth(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.geology.table_folds import set_names, table_fold
    from vomstudio.io.text.orientation_reading import read_orientations

    table = read_orientations(args.table, args.azimuth)
    sets = None if args.sets is None else set_names(args.sets)
    found = table_fold(table, args.kind, sets)
    out.result(found.as_dict())
    out.note(f"read as {found.convention}")
    out.warn(found.warnings)
    out.text(_in_words(found.as_dict()))


def _in_words(result: dict[str, Any]) -> str:
    beta, plane = result["beta"], result["pi_plane"]
    confidence = "undefined"
    if beta["max_confidence95_deg"] is not None:
        confidence = (
            f"{beta['max_confidence95_deg']:.1f} x {beta['min_confidence95_deg']:.1f} deg "
            "(semi-axes, joint 95 %)"
        )
    lines = [
        f"planes used   {result['used']} of {result['n']}",
        *(f"  left out    {o['n']} {o['what']} ({o['reason']})" for o in result["left_out"]),
        f"beta          {text_tables.line(beta)}  trend/plunge, deg",
        f"  confidence  {confidence}",
        f"pi-plane      {text_tables.azimuth(plane['dip_direction_deg'])}/"
        f"{text_tables.inclination(plane['dip_deg'])} dip direction/dip = "
        f"{text_tables.azimuth(plane['strike_rhr_deg'])}/"
        f"{text_tables.inclination(plane['dip_deg'])} "
        "strike (RHR)/dip, deg",
        f"verdict       {result['verdict']}; view along beta valid: {result['valid']}",
        *(f"  - {reason}" for reason in result["reasons"]),
    ]
    return "\n".join(lines)
