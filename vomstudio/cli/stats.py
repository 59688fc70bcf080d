"""`vomstudio stats`: statistics of sets of orientations."""

from __future__ import annotations

import argparse
from typing import Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import (
    Subparsers,
    add_command,
    report_reading,
)
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.orientation_tables import add_table_options, read_table_picks
from vomstudio.cli.common.output import Output
from vomstudio.core.words import tr, tr_n
from vomstudio.geology.populations.statistics_options import StatisticsOptions


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``stats`` command."""
    parser = add_command(
        subparsers,
        "stats",
        run,
        help_=tr("Compute orientation tensor, Fisher mean and shape of each set"),
    )
    parser.add_argument("table", metavar="TABLE", help=tr("table of planes or lines, or a project"))
    add_options(parser, StatisticsOptions)
    add_table_options(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio stats``.

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
    from vomstudio.geology.populations.table_statistics import table_statistics

    options = parse_options(args, StatisticsOptions)
    progress = report_reading(args, args.table)
    table = read_table_picks(args, args.table)
    progress.stage(tr("Computing statistics"))
    statistics = table_statistics(table, options)
    result = statistics.to_dict()
    out.result(result)
    out.note(tr("read {convention}", convention=statistics.convention))
    out.warn(statistics.warnings)
    out.text("\n\n".join(_result_text(name, figures) for name, figures in result["sets"].items()))


def _result_text(name: str, statistics: dict[str, Any]) -> str:
    number = text_tables.number
    tensor, woodcock, vollmer = statistics["tensor"], statistics["woodcock"], statistics["vollmer"]
    s1, s2, s3 = tensor["eigenvalues"]
    axes = ", ".join(map(text_tables.line, tensor["axes"]))
    rows = [
        *_fisher_rows(statistics),
        (tr("tensor"), f"S1 {s1:.4f}, S2 {s2:.4f}, S3 {s3:.4f}"),
        (tr("axes"), tr("{axes}  (trend/plunge, deg)", axes=axes)),
        ("Woodcock", f"K {number(woodcock['K'], 4)}, C {number(woodcock['C'], 4)}"),
        ("Vollmer", f"P {vollmer['P']:.4f}, G {vollmer['G']:.4f}, R {vollmer['R']:.4f}"),
        ("Bingham", _bingham_text(statistics)),
        ("Kent", _kent_text(statistics)),
        (tr("uniformity"), _uniformity_text(statistics["uniformity"])),
        *_weight_rows(statistics["weights"]),
    ]
    return f"{_heading(name, statistics)}\n{text_tables.label_lines(rows, 15, '  ')}"


def _fisher_rows(statistics: dict[str, Any]) -> list[tuple[str, str]]:
    fisher, number = statistics["fisher"], text_tables.number
    if fisher is None:
        return [
            (tr("Fisher mean"), tr("none: {reason}", reason=statistics["fisher_reason"]["message"]))
        ]
    text = (
        f"{text_tables.line(fisher)}  alpha95 {number(fisher['alpha95_deg'], 2)} deg, "
        f"kappa {number(fisher['kappa'], 2)}, R {number(fisher['R'], 4)}"
        f"{_fit_text(fisher['fit_p'])}"
    )
    if fisher["alpha95_deg"] is None and statistics["fisher_reason"]:
        text += f" ({statistics['fisher_reason']['message']})"
    rows = [(tr("Fisher mean"), text)]
    if fisher["registration_error_deg"] is not None:
        text = tr(
            "{registration} deg (95 %); combined with alpha95: {total} deg",
            registration=number(fisher["registration_error_deg"], 2),
            total=number(fisher["total95_deg"], 2),
        )
        rows.append((tr("registration"), text))
    return rows


def _uniformity_text(test: dict[str, Any]) -> str:
    if test["p"] is None:
        return tr("undefined")
    return tr("{test}: p {p}", test=test["test"], p=_probability_text(test["p"]))


def _weight_rows(weights: dict[str, Any] | None) -> list[tuple[str, str]]:
    if weights is None:
        return []
    text = tr(
        "by error ({column}), natural scatter {scatter:.1f} deg; equivalent to {n:.1f} equal"
        " weights",
        column=weights["column"],
        scatter=weights["natural_scatter_deg"],
        n=weights["effective_n"],
    )
    if count := weights["without_error"]:
        text = tr("{text}; missing errors ({count}) replaced by the median", text=text, count=count)
    return [(tr("weights"), text)]


def _bingham_text(statistics: dict[str, Any]) -> str:
    bingham = statistics["bingham"]
    if bingham is None:
        return tr("none: {reason}", reason=statistics["bingham_reason"]["message"])
    text = f"k1 {bingham['k1']:.2f}, k2 {bingham['k2']:.2f}"
    regions = [
        "-" if confidence is None else f"{confidence['max_deg']:.1f} x {confidence['min_deg']:.1f}"
        for confidence in bingham["confidence95"]
    ]
    text = tr(
        "{text}; axes within {regions} deg (joint 95 %)", text=text, regions=", ".join(regions)
    )
    return text + _fit_text(bingham["fit_p"])


def _kent_text(statistics: dict[str, Any]) -> str:
    kent = statistics["kent"]
    if kent is None:
        return tr("none: {reason}", reason=statistics["kent_reason"]["message"])
    text = tr(
        "{mean} within {largest:.2f} x {smallest:.2f} deg (joint 95 %), longest toward {major}; "
        "kappa {kappa:.2f}, beta {beta:.2f}",
        mean=text_tables.line(kent),
        largest=kent["max_confidence95_deg"],
        smallest=kent["min_confidence95_deg"],
        major=text_tables.line(kent["major"]),
        kappa=kent["kappa"],
        beta=kent["beta"],
    )
    return text + _fit_text(kent["fit_p"])


def _fit_text(p: float | None) -> str:
    return "" if p is None else tr("; fit p {p}", p=_probability_text(p))


def _probability_text(p: float) -> str:
    return "< 0.001" if p < 0.001 else f"{p:.3f}"


def _heading(name: str, statistics: dict[str, Any]) -> str:
    count = statistics["n"]
    if statistics["of"] == "poles":
        return tr_n("{set}: {count} pole, axial", "{set}: {count} poles, axial", count, set=name)
    if statistics["axial"]:
        return tr_n("{set}: {count} line, axial", "{set}: {count} lines, axial", count, set=name)
    return tr_n("{set}: {count} line, directed", "{set}: {count} lines, directed", count, set=name)
