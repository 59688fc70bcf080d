"""`vomstudio stats`: the statistics of sets of orientations."""

from __future__ import annotations

import argparse
from typing import Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import (
    Subparsers,
    add_azimuth,
    add_command,
    report_reading,
)
from vomstudio.cli.common.declared_options import add_options, options_from
from vomstudio.cli.common.output import Output
from vomstudio.geology.populations.statistics_options import StatisticsOptions
from vomstudio.words import tr, tr_n


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers, "stats", run, help_=tr("Orientation tensor, Fisher mean and shape of each set")
    )
    parser.add_argument("table", metavar="TABLE", help=tr("table of planes or lines"))
    add_options(parser, StatisticsOptions)
    add_azimuth(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.geology.populations.table_statistics import table_statistics
    from vomstudio.io.text.orientation_reading import read_orientations

    options = options_from(args, StatisticsOptions)
    progress = report_reading(args, args.table)
    table = read_orientations(args.table, args.azimuth)
    progress.stage(tr("Computing statistics"))
    found = table_statistics(table, options)
    result = found.to_dict()
    out.result(result)
    out.note(tr("read as {convention}", convention=found.convention))
    out.warn(found.warnings)
    out.text("\n\n".join(_in_words(name, of_set) for name, of_set in result["sets"].items()))


def _in_words(name: str, found: dict[str, Any]) -> str:
    s1, s2, s3 = found["tensor"]["eigenvalues"]
    lines = [_heading(name, found)]
    fisher = found["fisher"]
    if fisher is None:
        said = tr("none: {reason}", reason=found["fisher_reason"]["message"])
    else:
        said = (
            f"{text_tables.line(fisher)}  "
            f"alpha95 {text_tables.number(fisher['alpha95_deg'], 2)} deg, "
            f"kappa {text_tables.number(fisher['kappa'], 2)}, "
            f"R {text_tables.number(fisher['R'], 4)}" + _fit(fisher["fit_p"])
        )
        if fisher["alpha95_deg"] is None and found["fisher_reason"]:
            said += f" ({found['fisher_reason']['message']})"
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
        f"  {'Woodcock':<15} K {text_tables.number(shape['K'], 4)}, "
        f"C {text_tables.number(shape['C'], 4)}"
    )
    lines.append(
        f"  {'Vollmer':<15} P {vollmer['P']:.4f}, G {vollmer['G']:.4f}, R {vollmer['R']:.4f}"
    )
    return "\n".join([*lines, *_models_in_words(found)])


def _models_in_words(found: dict[str, Any]) -> list[str]:
    """Distributions, the test of uniformity and weights."""
    rows = [("Bingham", _bingham_in_words(found)), ("Kent", _kent_in_words(found))]
    test = found["uniformity"]
    said = tr("undefined")
    if test["p"] is not None:
        said = tr("{test}: p {p}", test=test["test"], p=_chance(test["p"]))
    rows.append((tr("uniformity"), said))
    weights = found["weights"]
    if weights is not None:
        said = tr(
            "by error ({column}), natural scatter {scatter:.1f} deg; worth {n:.1f} equal ones",
            column=weights["column"],
            scatter=weights["natural_scatter_deg"],
            n=weights["effective_n"],
        )
        if weights["without_error"]:
            said = tr(
                "{said}; {count} without an error took the median",
                said=said,
                count=weights["without_error"],
            )
        rows.append((tr("weights"), said))
    return [f"  {label:<15} {said}" for label, said in rows]


def _bingham_in_words(found: dict[str, Any]) -> str:
    bingham = found["bingham"]
    if bingham is None:
        return tr("none: {reason}", reason=found["bingham_reason"]["message"])
    said = f"k1 {bingham['k1']:.2f}, k2 {bingham['k2']:.2f}"
    regions = [
        "-" if of is None else f"{of['max_deg']:.1f} x {of['min_deg']:.1f}"
        for of in bingham["confidence95"]
    ]
    said = tr(
        "{said}; axes within {regions} deg (joint 95 %)", said=said, regions=", ".join(regions)
    )
    return said + _fit(bingham["fit_p"])


def _kent_in_words(found: dict[str, Any]) -> str:
    kent = found["kent"]
    if kent is None:
        return tr("none: {reason}", reason=found["kent_reason"]["message"])
    said = tr(
        "{mean} within {largest:.2f} x {smallest:.2f} deg (joint 95 %), longest toward {major}; "
        "kappa {kappa:.2f}, beta {beta:.2f}",
        mean=text_tables.line(kent),
        largest=kent["max_confidence95_deg"],
        smallest=kent["min_confidence95_deg"],
        major=text_tables.line(kent["major"]),
        kappa=kent["kappa"],
        beta=kent["beta"],
    )
    return said + _fit(kent["fit_p"])


def _fit(p: float | None) -> str:
    return "" if p is None else tr("; fit p {p}", p=_chance(p))


def _chance(p: float) -> str:
    return "< 0.001" if p < 0.001 else f"{p:.3f}"


def _heading(name: str, found: dict[str, Any]) -> str:
    count = found["n"]
    if found["of"] == "poles":
        return tr_n("{set}: {count} pole, axial", "{set}: {count} poles, axial", count, set=name)
    if found["axial"]:
        return tr_n("{set}: {count} line, axial", "{set}: {count} lines, axial", count, set=name)
    return tr_n("{set}: {count} line, directed", "{set}: {count} lines, directed", count, set=name)
