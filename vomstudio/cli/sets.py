"""`vomstudio sets`: division of planes into sets."""

from __future__ import annotations

import argparse
from typing import Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import (
    Subparsers,
    add_command,
    add_output,
    report_reading,
)
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.frame_arguments import add_frame, frame_options
from vomstudio.cli.common.orientation_tables import add_table_options, read_table_picks
from vomstudio.cli.common.output import Output
from vomstudio.core.words import tr, tr_n
from vomstudio.geology.sets.set_options import SetOptions


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``sets`` command."""
    parser = add_command(
        subparsers,
        "sets",
        run,
        help_=tr("Divide planes into sets; planes that do not fit any set are not assigned"),
    )
    parser.add_argument("table", metavar="TABLE", help=tr("table of planes"))
    add_output(parser, tr("output table with the set of each plane"), is_required=True)
    add_options(parser, SetOptions)
    add_table_options(parser)
    add_frame(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio sets``.

    Parameters
    ----------
    args : Namespace
        Parsed arguments.
    out : Output
        Object that receives the results, warnings and progress.

    Raises
    ------
    UsageError, InputError, GeometryError, TargetError
    """
    from vomstudio.core.files.atomic import write_bytes
    from vomstudio.core.files.extensions import check_table_target
    from vomstudio.geology.sets.proposals import propose_sets
    from vomstudio.io.gate.point_tables import read_row_positions
    from vomstudio.io.text.set_columns import extract_pieces, table_with_sets

    options = parse_options(args, SetOptions)
    check_table_target(args.output, force=args.force, inputs=[args.table])
    progress = report_reading(args, args.table)
    table = read_table_picks(args, args.table)
    positions = read_row_positions(table, frame_options(args))
    proposal = propose_sets(
        table,
        options,
        pieces=extract_pieces(table, None if positions is None else positions.points),
        progress=progress,
    )
    progress.stage(tr("Writing the results"))
    text = table_with_sets(
        table,
        proposal.rows,
        proposal.assignment,
        proposal.probability,
        discontinuity=proposal.discontinuity,
    )
    write_bytes(args.output, text.encode("utf-8"), force=args.force)
    warnings = [*(() if positions is None else positions.findings), *proposal.warnings]
    result = {**proposal.to_dict(), "table": args.output, "warnings": warnings}
    out.result(result)
    out.note(tr("read {convention}", convention=proposal.convention))
    out.warn(warnings)
    out.text(_result_text(result))


def _result_text(result: dict[str, Any]) -> str:
    number = text_tables.number
    rows = [
        [
            proposed_set["name"],
            str(proposed_set["n"]),
            text_tables.plane_with_error(proposed_set, "cone95_deg"),
            number(proposed_set["kappa"], 1),
            "" if proposed_set["discontinuities"] is None else str(proposed_set["discontinuities"]),
            number(proposed_set["spacing_m"], 3),
            number(proposed_set["persistence_dip_m"], 2),
            number(proposed_set["persistence_strike_m"], 2),
            number(proposed_set["p32_1_per_m"], 2),
        ]
        for proposed_set in result["sets"]
    ]
    headers = [
        tr("set"),
        "n",
        tr("mean plane"),
        "kappa",
        tr("discontinuities"),
        tr("spacing"),
        tr("along dip"),
        tr("along strike"),
        "P32",
    ]
    units = ["", "", tr("dip direction/dip ± 95 %"), "", "", "m", "m", "m", "1/m"]
    lines = [text_tables.table(headers, units, rows)] if rows else []
    lines.append(
        tr_n(
            "{count} of {all} planes has no set.",
            "{count} of {all} planes have no set.",
            result["unassigned"],
            all=result["n"],
        )
    )
    return "\n".join(lines)
