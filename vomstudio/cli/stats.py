"""`vomstudio stats`: the statistics of sets of orientations."""

from __future__ import annotations

import argparse
from typing import Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import Subparsers, add_azimuth, add_command
from vomstudio.cli.common.output import Output
from vomstudio.words import tr, tr_n


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers, "stats", run, help_=tr("Orientation tensor, Fisher mean and shape of each set")
    )
    parser.add_argument("table", metavar="TABLE", help=tr("table of planes or lines"))
    parser.add_argument(
        "--set", metavar="COLUMN", dest="set_column", help=tr("name or number of the set column")
    )
    parser.add_argument(
        "--directed", action="store_true", help=tr("lines have a head and a tail: don't flip them")
    )
    add_azimuth(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.geology.table_statistics import table_statistics
    from vomstudio.io.text.orientation_reading import read_orientations

    table = read_orientations(args.table, args.azimuth)
    found = table_statistics(table, args.set_column, args.directed)
    result = found.as_dict()
    out.result(result)
    out.note(tr("read as {convention}", convention=found.convention))
    out.warn(found.warnings)
    out.text("\n\n".join(_in_words(name, of_set) for name, of_set in result["sets"].items()))


def _in_words(name: str, found: dict[str, Any]) -> str:
    s1, s2, s3 = found["tensor"]["eigenvalues"]
    lines = [_heading(name, found)]
    fisher = found["fisher"]
    if fisher is None:
        said = tr("none: {reason}", reason=found["fisher_reason"])
    else:
        said = (
            f"{text_tables.line(fisher)}  "
            f"alpha95 {text_tables.number(fisher['alpha95_deg'], 2)} deg, "
            f"kappa {text_tables.number(fisher['kappa'], 2)}, "
            f"R {text_tables.number(fisher['R'], 4)}"
        )
    lines.append(f"  {tr('Fisher mean'):<15} {said}")
    if fisher is not None and fisher["registration_error_deg"] is not None:
        said = tr(
            "{registration} deg (95 %), with alpha95 {total} deg",
            registration=text_tables.number(fisher["registration_error_deg"], 2),
            total=text_tables.number(fisher["total95_deg"], 2),
        )
        lines.append(f"  {tr('registration'):<15} {said}")
    lines.append(f"  {tr('tensor'):<15} S1 {s1:.4f}, S2 {s2:.4f}, S3 {s3:.4f}")
    axes = ", ".join(text_tables.line(axis) for axis in found["tensor"]["axes"])
    lines.append(f"  {tr('axes'):<15} " + tr("{axes}  (trend/plunge, deg)", axes=axes))
    shape, vollmer = found["woodcock"], found["vollmer"]
    lines.append(
        f"  Woodcock        K {text_tables.number(shape['K'], 4)}, "
        f"C {text_tables.number(shape['C'], 4)}"
    )
    lines.append(
        f"  Vollmer         P {vollmer['P']:.4f}, G {vollmer['G']:.4f}, R {vollmer['R']:.4f}"
    )
    return "\n".join(lines)


def _heading(name: str, found: dict[str, Any]) -> str:
    count = found["n"]
    if found["of"] == "poles":
        return tr_n("{set}: {count} pole, axial", "{set}: {count} poles, axial", count, set=name)
    if found["axial"]:
        return tr_n("{set}: {count} line, axial", "{set}: {count} lines, axial", count, set=name)
    return tr_n("{set}: {count} line, directed", "{set}: {count} lines, directed", count, set=name)
