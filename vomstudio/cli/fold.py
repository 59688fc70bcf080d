"""`vomstudio fold`: pi-plane and fold axis, or the common axis of several sets."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import (
    Subparsers,
    add_command,
    report_reading,
)
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.orientation_tables import add_table_options, read_table_picks
from vomstudio.cli.common.output import Output
from vomstudio.core.words import tr
from vomstudio.geology.fold_options import FoldOptions

if TYPE_CHECKING:
    from vomstudio.geology.domains import DomainFigures
    from vomstudio.geology.table_folds import TableFold


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``fold`` command."""
    parser = add_command(
        subparsers,
        "fold",
        run,
        help_=tr("Compute the pi-plane and the fold axis beta, with a verdict"),
    )
    parser.add_argument("table", metavar="TABLE", help=tr("table of planes, or a project"))
    add_options(parser, FoldOptions)
    add_table_options(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio fold``.

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
    from vomstudio.geology.table_folds import table_fold

    options = parse_options(args, FoldOptions)
    progress = report_reading(args, args.table)
    table = read_table_picks(args, args.table)
    progress.stage(tr("Finding the fold axis"))
    fold_result = table_fold(table, options)
    out.result(fold_result.to_dict())
    out.note(tr("read {convention}", convention=fold_result.convention))
    out.warn(fold_result.warnings)
    out.text(_result_text(fold_result))


def _registration_rows(beta: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the text rows about the registration error of a fold axis, if it is known."""
    if beta["registration_error_deg"] is None:
        return []
    text = tr("{error:.1f} deg (95 %)", error=beta["registration_error_deg"])
    rows = [("  " + tr("registration"), text)]
    if beta["total95_deg"] is not None:
        text = tr(
            "{largest:.1f} x {smallest:.1f} deg (semi-axes, joint 95 %)",
            largest=beta["total95_deg"],
            smallest=beta["total95_min_deg"],
        )
        rows.append(("  " + tr("together"), text))
    return rows


def _limb_rows(limbs: dict[str, Any] | None) -> list[tuple[str, str]]:
    if limbs is None:
        return []
    first_limb, second_limb = (text_tables.plane(plane) for plane in limbs["planes"])
    text = tr(
        "{first} and {second} dip direction/dip, interlimb angle {angle:.0f} ± {error:.0f} deg "
        "(95 %)",
        first=first_limb,
        second=second_limb,
        angle=limbs["interlimb_angle_deg"],
        error=limbs["interlimb_error95_deg"],
    )
    if any(limbs["overturned"]):
        text = tr("{limbs}; overturned beds as flagged in the input", limbs=text)
    axial_text = tr(
        "{plane}  dip direction/dip, joint 95 %",
        plane=text_tables.plane_with_error(
            {**limbs["axial_plane"], "error95_deg": limbs["axial_plane_error95_deg"]},
            "error95_deg",
        ),
    )
    return [(tr("limbs"), text), (tr("axial plane"), axial_text)]


def _pair_rows(pairs: list[dict[str, Any]]) -> list[tuple[str, str]]:
    rows = []
    for pair in pairs:
        error = tr("unknown")
        if pair["max_confidence95_deg"] is not None:
            error = tr(
                "{largest:.1f} x {smallest:.1f} deg",
                largest=pair["max_confidence95_deg"],
                smallest=pair["min_confidence95_deg"],
            )
        text = tr(
            "{first} and {second} intersect in {line}, 95 %: {error}",
            first=pair["sets"][0],
            second=pair["sets"][1],
            line=text_tables.line(pair),
            error=error,
        )
        rows.append((tr("intersection"), text))
    return rows


def _weakest_axis_rows(weakest_axis: dict[str, Any] | None) -> list[tuple[str, str]]:
    if weakest_axis is None:
        return []
    text = tr(
        "beta rotates by up to {turn:.1f} deg if plane {id} is left out",
        turn=weakest_axis["turn_deg"],
        id=weakest_axis["id"],
    )
    return [(tr("leave one out"), text)]


def _domain_rows(domains: Mapping[str, DomainFigures] | None) -> list[tuple[str, str]]:
    from vomstudio.geology.domains import describe_domain

    return [
        (tr("domain {name}", name=name), describe_domain(domain, 1))
        for name, domain in (domains or {}).items()
    ]


def _result_text(fold: TableFold) -> str:
    result = fold.to_dict()
    beta, plane = result["beta"], result["pi_plane"]
    confidence = tr("undefined")
    if beta["max_confidence95_deg"] is not None:
        confidence = tr(
            "{largest:.1f} x {smallest:.1f} deg (semi-axes, joint 95 %)",
            largest=beta["max_confidence95_deg"],
            smallest=beta["min_confidence95_deg"],
        )
    dip = text_tables.inclination(plane["dip_deg"])
    rows = [
        (tr("planes used"), tr("{used} of {all}", used=result["used"], all=result["n"])),
        *(
            []
            if result["not_good"] is None
            else [("  " + tr("not rated good"), tr("{count}", count=result["not_good"]))]
        ),
        *(
            ("  " + tr("left out"), f"{item.n} {item.what}: {item.reason}")
            for item in fold.left_out
        ),
        (tr("beta"), tr("{line}  trend/plunge, 95 %", line=text_tables.line_with_error(beta))),
        ("  " + tr("confidence"), confidence),
        *_registration_rows(beta),
        (
            tr("pi-plane"),
            tr(
                "{dip_direction_dip} dip direction/dip = {strike_dip} strike (RHR)/dip, deg",
                dip_direction_dip=f"{text_tables.azimuth(plane['dip_direction_deg'])}/{dip}",
                strike_dip=f"{text_tables.azimuth(plane['strike_rhr_deg'])}/{dip}",
            ),
        ),
        *_limb_rows(result["limbs"]),
        *_pair_rows(result["pairs"]),
        *_weakest_axis_rows(result["leave_one_out"]),
        *_domain_rows(fold.domains),
        (
            tr("verdict"),
            tr(
                "{verdict}; view along beta valid: {valid}",
                verdict=result["verdict"],
                valid=result["valid"],
            ),
        ),
    ]
    reasons = (f"  - {reason}" for reason in fold.reasons)
    return "\n".join([text_tables.label_lines(rows, 14), *reasons])
