"""`vomstudio fit`: planes from points in a text table."""

from __future__ import annotations

import argparse
from typing import Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import Subparsers, add_command, add_output
from vomstudio.cli.common.output import Output
from vomstudio.errors import GeometryError
from vomstudio.words import tr


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(subparsers, "fit", run, help_=tr("Fit planes to points and judge them"))
    parser.add_argument("points", metavar="POINTS", help=tr("text table with x, y, z"))
    parser.add_argument(
        "--by",
        metavar="COLUMN",
        help=tr(
            "name or number of the column that tells the planes apart (segment: the "
            "parts between --- lines)"
        ),
    )
    parser.add_argument("--method", choices=["pca", "regression"], default="pca")
    parser.add_argument(
        "--axis", choices=["auto", "x", "y", "z"], default="auto",
        help=tr("that a regression minimises (auto, the default: the one nearest the normal)"),
    )  # fmt: skip
    parser.add_argument(
        "--profile", choices=["error", "textbook"], default="error",
        help=tr("judge planes by how far they may be off, or by the shape of their points"),
    )  # fmt: skip
    add_output(parser, tr("write the orientation table as CSV"))


def run(args: argparse.Namespace, out: Output) -> None:
    """Raises GeometryError where no plane at all can be fitted."""
    from vomstudio.files.atomic import check_target
    from vomstudio.geology.profiles import PROFILES
    from vomstudio.io.text.tables import read_points
    from vomstudio.tables.fitted_planes import fitted_planes
    from vomstudio.tables.orientation_table import write_orientation_csv

    if args.output is not None:
        check_target(args.output, force=args.force, inputs=[args.points])
    limits = PROFILES[args.profile]
    groups = read_points(args.points, args.by)
    fitted = fitted_planes(
        groups.ids, groups.points, groups.offsets, method=args.method, axis=args.axis,
        thresholds=limits, words=groups.words,
    )  # fmt: skip
    rows, skipped = fitted.rows, fitted.skipped
    if not rows:
        raise _nothing_fitted(args.points, args.by, skipped)
    result: dict[str, Any] = {
        "planes": rows,
        "skipped": skipped,
        "dropped_lines": list(groups.dropped),
        "warnings": list(groups.warnings),
    }
    if args.output is not None:
        write_orientation_csv(args.output, rows, limits=limits, force=args.force)
        result["table"] = args.output
    out.result(result)
    out.warn(groups.warnings)
    out.warn(
        [
            tr("Plane {plane} was left out: {reason}", plane=item["id"], reason=item["reason"])
            for item in skipped
        ]
    )
    out.text(f"{_in_words(rows)}\n{limits.in_words}")


def _nothing_fitted(path: str, by: str | None, skipped: list[dict[str, str]]) -> GeometryError:
    first = skipped[0]
    if by is None:
        return GeometryError(
            tr("No plane can be fitted: {reason}.", reason=first["reason"]), file=path
        )
    return GeometryError(
        tr(
            "None of the {count} planes can be fitted. The first: {reason}.",
            count=len(skipped),
            reason=first["reason"],
        ),
        file=path,
        field=f"{by} {first['id']}",
    )


def _in_words(rows: list[dict[str, Any]]) -> str:
    heads = [
        tr("id"),
        tr("n"),
        tr("strike"),
        tr("dip"),
        tr("dip dir"),
        tr("95 % conf."),
        tr("ang. error"),
        tr("rms"),
        tr("extent"),
        tr("quality"),
    ]
    largest = tr("deg max/min")
    units = ["", "", tr("deg RHR"), tr("deg"), tr("deg"), largest, largest, "m", "m", ""]
    body = [
        [
            str(row["id"]),
            str(row["n_points"]),
            text_tables.azimuth(row["strike_rhr_deg"], 3),
            text_tables.inclination(row["dip_deg"], 3),
            tr("undefined")
            if row["undefined"]
            else text_tables.azimuth(row["dip_direction_deg"], 3),
            _pair(row, "confidence95"),
            _pair(row, "angular_error"),
            text_tables.figures(row["rms_m"]),
            text_tables.figures(row["extent_m"]),
            row["quality"],
        ]
        for row in rows
    ]
    reasons = [
        tr(
            "{plane} is {verdict}: {reasons}",
            plane=row["id"],
            verdict=row["quality"],
            reasons=row["quality_reason"],
        )
        for row in rows
        if row["quality_reason"]
    ]
    return "\n".join([text_tables.table(heads, units, body), *reasons])


def _pair(row: dict[str, Any], name: str) -> str:
    largest, smallest = row[f"max_{name}_deg"], row[f"min_{name}_deg"]
    return f"{text_tables.number(largest, 4)}/{text_tables.number(smallest, 4)}"
