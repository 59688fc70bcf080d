"""`vomstudio displacement`: displacements of a fault from point pairs on both sides."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import Subparsers, add_command, report_reading
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.error_context import name_input_in_errors
from vomstudio.cli.common.frame_arguments import add_frame, frame_options
from vomstudio.cli.common.output import Output
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.faults.displacement_options import DisplacementOptions


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``displacement`` command."""
    parser = add_command(
        subparsers,
        "displacement",
        run,
        help_=tr("Compute net slip, throw and heave of a fault, with errors"),
    )
    parser.add_argument(
        "pairs",
        metavar="PAIRS",
        help=tr("table of point pairs, one point on each side of the fault, in metres"),
    )
    add_options(parser, DisplacementOptions)
    add_frame(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio displacement``.

    Parameters
    ----------
    args : Namespace
        Parsed arguments.
    out : Output
        Object that receives the results, warnings and progress.

    Raises
    ------
    UsageError, InputError, GeometryError
    """
    from vomstudio.geology.faults.displacement_pairs import displacements
    from vomstudio.io.gate.point_tables import read_pairs

    options = parse_options(args, DisplacementOptions)
    progress = report_reading(args, args.pairs)
    pairs = read_pairs(args.pairs, frame_options(args))
    progress.stage(tr("Computing displacements"))
    with name_input_in_errors(args.pairs):
        displacement = displacements(pairs.names, pairs.points[:, :3], pairs.points[:, 3:], options)
    displacement = replace(displacement, warnings=(*pairs.warnings, *displacement.warnings))
    result = displacement.to_dict()
    out.result(result)
    out.warn(displacement.warnings)
    out.warn(
        [
            Finding("feature.left-out", feature=item["id"], reason=item["reason"])
            for item in displacement.skipped
        ]
    )
    out.text(_result_text(result))


def _result_text(result: dict[str, Any]) -> str:
    headers = [
        tr("pair"),
        tr("net"),
        "+-",
        tr("throw"),
        "+-",
        tr("heave"),
        "+-",
        tr("strike slip"),
        tr("slip rake"),
    ]
    rows = []
    for pair in result["pairs"]:
        d = pair["displacement"] or pair["separations"]["dip"]
        if d is None:
            continue
        cells = [pair["name"]]
        for name in ("net_m", "throw_m", "heave_m"):
            cells += [
                text_tables.number(d[name]["value"], 3),
                text_tables.number(d[name]["error95"], 3),
            ]
        cells += [
            text_tables.number(d["strike_slip_m"]["value"], 3),
            text_tables.number(d["slip_rake_deg"], 0),
        ]
        rows.append(cells)
    title = (
        tr("Net slip in metres, with 95 % errors")
        if result["what"] == "net slip"
        else tr("Dip separation in metres, with 95 % errors; the net slip is unknown")
    )
    return f"{title}\n" + text_tables.table(headers, [""] * len(headers), rows)
