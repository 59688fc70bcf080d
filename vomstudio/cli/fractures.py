"""`vomstudio fractures`: a map of fracture traces in figures."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import Subparsers, add_command
from vomstudio.cli.common.output import Output
from vomstudio.words import tr, tr_n


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers, "fractures", run,
        help_=tr("Number, length, nodes and spacing of the fractures of a trace map"),
    )  # fmt: skip
    parser.add_argument(
        "traces", metavar="TRACES",
        help=tr("lines in metres: GeoPackage, GeoJSON, shapefile or DXF"),
    )  # fmt: skip
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--area", metavar="POLYGON", help=tr("file with the area in which traces were mapped")
    )
    where.add_argument(
        "--circle", metavar="X,Y,R", help=tr("count in a circle: centre and radius in metres")
    )
    where.add_argument(
        "--scanline", metavar="LINE", help=tr("file with one line or several to count along")
    )
    parser.add_argument(
        "--snap", type=float, default=0.0, metavar="M",
        help=tr("how far ends may miss a trace that they abut on, in metres (default 0)"),
    )  # fmt: skip
    sets = parser.add_mutually_exclusive_group()
    sets.add_argument(
        "--set", metavar="COLUMN", dest="set_column",
        help=tr("the attribute that names the sets (default: set, where there is one)"),
    )  # fmt: skip
    sets.add_argument(
        "--strikes", metavar="A-B,...", help=tr("sets by ranges of strike, such as 340-020,060-100")
    )
    parser.add_argument(
        "--terzaghi-cap", type=float, metavar="W",
        help=tr("the largest Terzaghi weight (default: none)"),
    )  # fmt: skip
    parser.add_argument("--layer", metavar="NAME", help=tr("the layer of TRACES"))
    parser.add_argument(
        "--plot", metavar="FILE", help=tr("a picture, by its ending: .svg, .pdf or .png")
    )
    parser.add_argument(
        "--force", action="store_true", help=tr("replace FILE if it is there already")
    )


def run(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.files.atomic import atomic_write, check_target
    from vomstudio.products.fractures.mapping import (
        FractureOrder,
        map_fractures,
        parse_circle,
        parse_strikes,
    )  # fmt: skip
    from vomstudio.products.net.figure import picture_format

    order = FractureOrder(
        traces=Path(args.traces),
        area=None if args.area is None else Path(args.area),
        circle=None if args.circle is None else parse_circle(args.circle),
        scanline=None if args.scanline is None else Path(args.scanline),
        snap_m=args.snap,
        set_column=args.set_column,
        strikes=parse_strikes(args.strikes),
        terzaghi_cap=args.terzaghi_cap,
        layer=args.layer,
    )
    format_ = None
    if args.plot is not None:
        format_ = picture_format(args.plot, "--plot")
        inputs = [p for p in (args.traces, args.area, args.scanline) if p is not None]
        check_target(args.plot, force=args.force, inputs=inputs)
    mapped = map_fractures(order)
    if format_ is not None:
        from vomstudio.products.fractures.figure import write_fractures

        with atomic_write(args.plot, args.force) as temporary:
            write_fractures(temporary, mapped, format=format_)
    result = {**mapped.found.as_dict(), "image": args.plot}
    out.result(result)
    out.warn(mapped.found.warnings)
    out.text(_in_words(result))
    for note in mapped.found.notes:
        out.note(note)


def _in_words(found: dict[str, Any]) -> str:
    number, figures = text_tables.number, text_tables.figures
    nodes, length = found["nodes"], found["length"]
    rows = [
        (tr("traces"), tr("{traces:,}, in {pieces:,} pieces", traces=found["traces"],
                          pieces=found["pieces"])),
    ]  # fmt: skip
    error = found["error95"]
    if error is not None:
        rows += [
            (tr("area"), tr("{size} m2", size=number(found["area_m2"], 1))),
            ("P20", _with_error(found["P20_1_per_m2"], error["P20_1_per_m2"], "1/m2")),
            (
                tr("P20 by nodes"),
                _with_error(found["P20_nodes_1_per_m2"], error["P20_nodes_1_per_m2"], "1/m2"),
            ),
            ("P21", _with_error(found["P21_1_per_m"], error["P21_1_per_m"], "1/m")),
        ]
    if found["scanline"] is not None:
        line = found["scanline"]
        rows += [
            (tr("scanline"), tr_n(
                "{count} crossing on {length} m", "{count} crossings on {length} m", line["n"],
                length=number(found["scanline_m"], 2))),
            ("P10", tr("{value} 1/m", value=figures(found["P10_1_per_m"]))),
            (tr("  by Terzaghi"), tr("P21 {value} 1/m, cap: {cap}",
                                   value=figures(line["P21_1_per_m"]),
                                   cap=found["terzaghi_cap"] or tr("none"))),
            (tr("  spacing"), tr("{mean} m along the line, {true} m across the traces, cv {cv}",
                               mean=figures(line["mean_m"]), true=figures(line["true_mean_m"]),
                               cv=number(line["cv"], 2))),
        ]  # fmt: skip
    rows.append((
        tr("nodes"),
        tr("I {i:,}, Y {y:,}, X {x:,} (tolerance {snap:g} m, {mended} ends mended)",
           i=nodes["I"], y=nodes["Y"], x=nodes["X"], snap=found["snap_m"],
           mended=len(found["mended"])),
    ))  # fmt: skip
    low, high = length["mean_95_m"]
    rows += [
        (tr("mean length"), tr("{mean} m (95 %: {low} to {high}), of the pieces {naive} m",
                               mean=figures(length["mean_m"]), low=figures(low),
                               high=figures(high), naive=figures(length["naive_mean_m"]))),
        (tr("  cut off"), tr("{share} % of the pieces by the edge of the area",
                           share=number(100 * (length["censored_share"] or 0.0), 1))),
        (tr("  distribution"), _law_in_words(length)),
    ]  # fmt: skip
    for of_set in found["sets"] if len(found["sets"]) > 1 else ():
        rows.append((tr("set {name}", name=of_set["name"]), _set_in_words(of_set)))
    width = max(len(label) for label, _ in rows)
    return "\n".join(f"{label:<{width}}  {value}" for label, value in rows)


def _with_error(value: float, error: float, unit: str) -> str:
    return tr(
        "{value} +- {error} {unit} (95 %, of traces placed independently)",
        value=text_tables.figures(value), error=text_tables.figures(error, 2), unit=unit,
    )  # fmt: skip


def _law_in_words(length: dict[str, Any]) -> str:
    if length["distribution"] is None:
        return tr("none: {reason}", reason=length["reason"])
    parameters = ", ".join(
        f"{name} {text_tables.figures(value)}" for name, value in length["parameters"].items()
    )
    name = length["distribution"].replace("_", " ")
    if len(length["fits"]) < 2:
        return f"{name} ({parameters})"
    second = length["fits"][1]
    return tr(
        "{name} ({parameters}); the next, {second}, has an AIC {delta} higher",
        name=name, parameters=parameters, second=second["distribution"].replace("_", " "),
        delta=text_tables.number(second["delta_aic"], 1),
    )  # fmt: skip


def _set_in_words(of_set: dict[str, Any]) -> str:
    said = tr_n(
        "{count} piece, strike {strike}", "{count} pieces, strike {strike}", of_set["n"],
        strike=text_tables.azimuth(of_set["strike_deg"], 0),
    )  # fmt: skip
    if of_set["P21_1_per_m"] is not None:
        said += tr(", P21 {value} 1/m", value=text_tables.figures(of_set["P21_1_per_m"]))
    if of_set["spacing"] is not None:
        said += tr(
            ", spacing {mean} m, across the traces {true} m",
            mean=text_tables.figures(of_set["spacing"]["mean_m"]),
            true=text_tables.figures(of_set["spacing"]["true_mean_m"]),
        )
    return said
