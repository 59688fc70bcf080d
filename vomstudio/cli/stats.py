"""`vomstudio stats`: the statistics of sets of orientations."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from vomstudio.cli import text_tables
from vomstudio.cli.arguments import Subparsers, add_azimuth, add_command
from vomstudio.cli.output import Output
from vomstudio.words import tr

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from vomstudio.io.text.orientation_reading import OrientationTable

UNNAMED = "unassigned"


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
    from vomstudio.geology.statistics import set_statistics
    from vomstudio.io.text.orientation_reading import read_orientations

    table = read_orientations(args.table, args.azimuth)
    warnings = list(table.warnings)
    vectors = table.vectors()
    found: dict[str, dict[str, Any]] = {}
    for name, members in _sets(table, args.set_column, warnings).items():
        of = "poles" if table.is_plane[members[0]] else "lines"
        found[name] = set_statistics(vectors[members], of=of, directed=args.directed)
    out.result(
        {
            "n": len(table),
            "sets": found,
            "convention": table.convention,
            "dropped_lines": list(table.dropped),
            "warnings": warnings,
        }
    )
    out.note(f"read as {table.convention}")
    out.warn(warnings)
    out.text("\n\n".join(_in_words(name, of_set) for name, of_set in found.items()))


def _sets(
    table: OrientationTable, column: str | None, warnings: list[str]
) -> dict[str, NDArray[np.int64]]:
    """Rows of each set, in order of appearance. Poles and lines are not averaged together: a set
    of both becomes two."""
    import numpy as np

    names = ["all"] * len(table) if column is None else table.column(column)
    if column is not None and not all(names):
        warnings.append(f"rows with nothing in column '{column}' make the set '{UNNAMED}'")
        names = [name or UNNAMED for name in names]
    rows: dict[str, list[int]] = {}
    for i, name in enumerate(names):
        rows.setdefault(name, []).append(i)
    result: dict[str, NDArray[np.int64]] = {}
    for name, members in rows.items():
        where = np.asarray(members, dtype=np.int64)
        plane = table.is_plane[where]
        kinds = {} if table.kinds is None else dict.fromkeys(table.kinds[i] for i in members)
        if len(kinds) > 1:
            said = ", ".join(kind or "no kind" for kind in kinds)
            warnings.append(
                f"set '{name}' pools planes or lines of {len(kinds)} kinds ({said}); "
                "use --set to describe them apart"
            )
        if plane.all() or not plane.any():
            result[name] = where
            continue
        warnings.append(f"set '{name}' has planes and lines; they are described apart")
        result[f"{name} (poles)"] = where[plane]
        result[f"{name} (lines)"] = where[~plane]
    return result


def _in_words(name: str, found: dict[str, Any]) -> str:
    axial = "axial" if found["axial"] else "directed"
    s1, s2, s3 = found["tensor"]["eigenvalues"]
    lines = [f"{name}: {found['n']} {found['of']}, {axial}"]
    fisher = found["fisher"]
    if fisher is None:
        lines.append(f"  Fisher mean     none: {found['fisher_reason']}")
    else:
        lines.append(
            f"  Fisher mean     {text_tables.line(fisher)}  "
            f"alpha95 {text_tables.number(fisher['alpha95_deg'], 2)} deg, "
            f"kappa {text_tables.number(fisher['kappa'], 2)}, "
            f"R {text_tables.number(fisher['R'], 4)}"
        )
    lines.append(f"  tensor          S1 {s1:.4f}, S2 {s2:.4f}, S3 {s3:.4f}")
    axes = ", ".join(text_tables.line(axis) for axis in found["tensor"]["axes"])
    lines.append(f"  axes            {axes}  (trend/plunge, deg)")
    shape, vollmer = found["woodcock"], found["vollmer"]
    lines.append(
        f"  Woodcock        K {text_tables.number(shape['K'], 4)}, "
        f"C {text_tables.number(shape['C'], 4)}"
    )
    lines.append(
        f"  Vollmer         P {vollmer['P']:.4f}, G {vollmer['G']:.4f}, R {vollmer['R']:.4f}"
    )
    return "\n".join(lines)
