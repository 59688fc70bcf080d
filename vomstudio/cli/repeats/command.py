"""`vomstudio repeats`: repeatability of picks compared with their stated errors."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import (
    Subparsers,
    add_command,
    report_reading,
)
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.orientation_tables import add_table_options, read_table_picks
from vomstudio.cli.common.output import Output
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr, tr_n
from vomstudio.geology.coverage.repeat_options import RepeatOptions

if TYPE_CHECKING:
    from vomstudio.geology.coverage.table_repeats import TableRepeats


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``repeats`` command."""
    parser = add_command(
        subparsers,
        "repeats",
        run,
        help_=tr("Compare the spread of repeated picks with their stated errors"),
    )
    parser.add_argument(
        "table",
        metavar="TABLE|PROJECT",
        help=tr("table of planes or lines with repeats, or a project"),
    )
    add_options(parser, RepeatOptions)
    add_table_options(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio repeats``.

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
    from vomstudio.geology.coverage.table_repeats import table_repeats

    progress = report_reading(args, args.table)
    table = read_table_picks(args, args.table, repeats=True)
    progress.stage(tr("Comparing repeated picks"))
    options = parse_options(args, RepeatOptions)
    repeats = table_repeats(table, options.by, options.interpreter)
    out.result(repeats.to_dict())
    out.note(tr("read {convention}", convention=repeats.convention))
    out.warn(repeats.warnings)
    out.text(_result_text(repeats))


def _result_text(repeats: TableRepeats) -> str:
    lines = [
        tr_n(
            "{count} pick, {structures} of them repeated",
            "{count} picks, {structures} of them repeated",
            repeats.n,
            structures=repeats.structures,
        )
    ]
    rows = [
        [
            p.first,
            p.repeat,
            " / ".join(p.by) if any(p.by) else "",
            f"{p.angle_deg:.1f}",
            text_tables.number(p.stated95_deg, 1),
            "" if p.within95 is None else tr("yes") if p.within95 else tr("no"),
        ]
        for p in repeats.pairs
    ]
    if rows:
        headers = [
            tr("first"),
            tr("repeat"),
            tr("by"),
            tr("angle"),
            tr("stated 95 %"),
            tr("within"),
        ]
        lines.append(text_tables.table(headers, ["", "", "", "deg", "deg", ""], rows))
    if repeats.spread is not None:
        lines.append(
            tr(
                "95 % error of a pick: {error} deg from repeats, {stated} deg as stated",
                error=text_tables.number(repeats.spread.error95_deg, 2),
                stated=text_tables.number(repeats.stated95_deg, 2),
            )
        )
    if repeats.test is not None:
        lines.append(
            tr(
                "within the stated errors: {within} of {count} (expected: 95 %)",
                within=repeats.test.within95,
                count=repeats.test.n,
            )
        )
    lines += [
        tr_n(
            "{name}: {error:.2f} deg (95 %), {count} repeat",
            "{name}: {error:.2f} deg (95 %), {count} repeats",
            interpreter.spread.n,
            name=interpreter.name or tr("unknown"),
            error=interpreter.spread.error95_deg,
        )
        for interpreter in repeats.interpreters
    ]
    skipped_picks = [
        Finding("feature.left-out", feature=item.id, reason=item.reason)
        for item in repeats.left_out
    ]
    return "\n".join([*lines, *map(str, skipped_picks), *map(str, repeats.reasons)])
