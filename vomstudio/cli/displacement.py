"""`vomstudio displacement`: what pairs of points on both sides of a fault tell."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.angles import line_of, plane_of
from vomstudio.cli.common.arguments import Subparsers, add_command, report_reading
from vomstudio.cli.common.frames_of_models import add_frame, frame_options
from vomstudio.cli.common.naming import numbers_of
from vomstudio.cli.common.output import Output
from vomstudio.words import tr


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers,
        "displacement",
        run,
        help_=tr("Net slip, throw and heave of a fault, with errors"),
    )
    parser.add_argument(
        "pairs", metavar="PAIRS", help=tr("table of a point on each side, in metres")
    )
    parser.add_argument("--fault", metavar="DD/D", required=True, help=tr("attitude of the fault"))
    parser.add_argument(
        "--bed",
        metavar="DD/D",
        help=tr("attitude of the bed, where the points are cut-offs of one"),
    )
    slip = parser.add_mutually_exclusive_group()
    slip.add_argument("--rake", type=float, metavar="DEG", help=tr("rake of the slip lineation"))
    slip.add_argument("--slip", metavar="T/P", help=tr("trend and plunge of the slip lineation"))
    for option, of in (
        ("--sigma", tr("standard deviation of each coordinate, in metres")),
        ("--fault-error", tr("half-angle of the fault's 95 %% cone, in degrees")),
        ("--bed-error", tr("half-angle of the bed's 95 %% cone, in degrees")),
        ("--rake-error", tr("95 %% error of the rake, in degrees")),
    ):
        parser.add_argument(option, type=float, default=0.0, metavar="N", help=of)
    add_frame(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.geology.faults.displacement import Errors
    from vomstudio.geology.faults.displacement_pairs import displacements
    from vomstudio.io.gate.point_tables import read_pairs

    fault = plane_of(args.fault, "--fault")
    bed = None if args.bed is None else plane_of(args.bed, "--bed")
    slip = None if args.slip is None else line_of(args.slip, "--slip")
    progress = report_reading(args, args.pairs)
    pairs = read_pairs(args.pairs, frame_options(args))
    names, points = pairs.names, pairs.points
    progress.stage(tr("Computing displacements"))
    with numbers_of(args.pairs):
        found = displacements(
            names, points[:, :3], points[:, 3:], fault, bed=bed, rake_deg=args.rake,
            slip=slip,
            errors=Errors(args.sigma, args.fault_error, args.bed_error, args.rake_error),
        )  # fmt: skip
    found = replace(found, warnings=(*pairs.warnings, *found.warnings))
    result = found.as_dict()
    out.result(result)
    out.warn(found.warnings)
    out.warn([f"{each['id']}: {each['reason']}" for each in found.skipped])
    out.text(_in_words(result))


def _in_words(result: dict[str, Any]) -> str:
    heads = [tr("pair"), tr("net"), "+-", tr("throw"), "+-", tr("heave"), "+-", tr("strike slip"),
             tr("slip rake")]  # fmt: skip
    rows = []
    for pair in result["pairs"]:
        d = pair["displacement"] or pair["separations"]["dip"]
        if d is None:
            continue
        cells = [pair["name"]]
        for name in ("net_m", "throw_m", "heave_m"):
            cells += [text_tables.number(d[name]["value"], 3),
                      text_tables.number(d[name]["error95"], 3)]  # fmt: skip
        cells += [text_tables.number(d["strike_slip_m"]["value"], 3),
                  text_tables.number(d["slip_rake_deg"], 0)]  # fmt: skip
        rows.append(cells)
    title = (
        tr("Net slip, metres, errors 95 %")
        if result["what"] == "net slip"
        else tr("Dip separation, metres, errors 95 %; the slip is unknown, so this is no slip")
    )
    return f"{title}\n" + text_tables.table(heads, [""] * len(heads), rows)
