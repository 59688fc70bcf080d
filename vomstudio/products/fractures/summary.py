"""Summary of a fracture map as text."""

from __future__ import annotations

from typing import Any

from vomstudio.core.words import to_translate, tr, tr_n
from vomstudio.geology.coverage.face_coverage import FaceCoverage
from vomstudio.geology.fractures.network import FractureNetwork
from vomstudio.geology.fractures.trace_plane import TracePlane
from vomstudio.project.tables.number_format import azimuth, figures, number

PARAMETER_TEXTS = {
    "exponent": to_translate("exponent {value}"),
    "mean_m": to_translate("mean {value} m"),
    "median_m": to_translate("median {value} m"),
    "minimum_m": to_translate("minimum {value} m"),
    "scale_m": to_translate("scale {value} m"),
    "shape": to_translate("shape {value}"),
    "sigma_log": to_translate("standard deviation of ln length {value}"),
}


def figure_rows(network: FractureNetwork) -> list[tuple[str, str]]:
    """Return the name of each figure, and its value with error and unit, as text."""
    values = network.to_dict()
    nodes, length = values["nodes"], values["length"]
    rows = [
        (
            tr("traces"),
            tr(
                "{traces:,}, in {pieces:,} pieces", traces=values["traces"], pieces=values["pieces"]
            ),
        ),
    ]
    if network.plane is not None:
        rows.append((tr("plane"), _plane_text(network.plane)))
    if values["area_m2"] is not None:
        rows += [
            (tr("area"), tr("{size} m2", size=number(values["area_m2"], 1))),
            ("P20", _format_interval(values["P20_1_per_m2"], values["P20_95_1_per_m2"], "1/m2")),
            (
                tr("P20 by nodes"),
                _format_interval(
                    values["P20_nodes_1_per_m2"], values["P20_nodes_95_1_per_m2"], "1/m2"
                ),
            ),
            ("P21", _format_interval(values["P21_1_per_m"], values["P21_95_1_per_m"], "1/m")),
            (tr("  dispersion"), _dispersion_text(values["dispersion"])),
        ]
    if values["scanline"] is not None:
        line = values["scanline"]
        rows += [
            (
                tr("scanline"),
                tr_n(
                    "{count} crossing on {length} m",
                    "{count} crossings on {length} m",
                    line["n"],
                    length=number(values["scanline_m"], 2),
                ),
            ),
            ("P10", _format_interval(values["P10_1_per_m"], values["P10_95_1_per_m"], "1/m")),
            (
                tr("  Terzaghi correction"),
                tr(
                    "P21 {value}, weight cap: {cap}",
                    value=_format_interval(line["P21_1_per_m"], line["P21_95_1_per_m"], "1/m"),
                    cap=values["terzaghi_cap"] or tr("none"),
                ),
            ),
            (
                tr("  spacing"),
                tr(
                    "{mean} along the line, {true} across the traces, cv {cv}",
                    mean=_format_interval(line["mean_m"], line["mean_95_m"], "m"),
                    true=_format_interval(line["true_mean_m"], line["true_mean_95_m"], "m"),
                    cv=number(line["cv"], 2),
                ),
            ),
            (tr("  dispersion"), _dispersion_text(line["dispersion"])),
        ]
    rows.append(
        (
            tr("nodes"),
            tr(
                "I {i:,}, Y {y:,}, X {x:,} (tolerance {snap:g} m, {mended} ends snapped)",
                i=nodes["I"],
                y=nodes["Y"],
                x=nodes["X"],
                snap=values["snap_m"],
                mended=len(values["mended"]),
            ),
        )
    )
    low, high = length["mean_95_m"]
    rows += [
        (
            tr("mean length"),
            tr(
                "{mean} m (95 %: {low} to {high}); mean of the pieces {naive} m",
                mean=figures(length["mean_m"]),
                low=figures(low),
                high=figures(high),
                naive=figures(length["naive_mean_m"]),
            ),
        ),
        (
            tr("  cut off"),
            tr(
                "{share} % of the pieces by the edge of the area",
                share=number(100 * (length["censored_share"] or 0.0), 1),
            ),
        ),
        (tr("  distribution"), _law_text(length)),
    ]
    for set_figures in values["sets"] if len(values["sets"]) > 1 else ():
        rows.append(
            (tr("set {name}", name=set_figures["name"]), _set_text(set_figures, network.plane))
        )
    return rows


def _format_interval(
    value: float | None, interval: tuple[float | None, float | None], unit: str
) -> str:
    low, high = interval
    return tr(
        "{value} {unit} (95 %: {low} to {high})",
        value=figures(value),
        unit=unit,
        low=figures(low, 3),
        high=figures(high, 3),
    )


def _dispersion_text(dispersion: float) -> str:
    return tr(
        "{ratio} times the variance of independently placed traces", ratio=number(dispersion, 1)
    )


def _law_text(length: dict[str, Any]) -> str:
    if length["distribution"] is None:
        return tr("none: {reason}", reason=length["reason"]["message"])
    parameters = ", ".join(
        tr(PARAMETER_TEXTS[name], value=figures(value))
        for name, value in length["parameters"].items()
    )
    name = length["distribution"].replace("_", " ")
    if len(length["fits"]) < 2:
        return f"{name} ({parameters})"
    second = length["fits"][1]
    return tr(
        "{name} ({parameters}); AIC of the second best, {second}, is {delta} higher",
        name=name,
        parameters=parameters,
        second=second["distribution"].replace("_", " "),
        delta=number(second["delta_aic"], 1),
    )


def _plane_text(plane: TracePlane) -> str:
    text = tr(
        "{plane}, scatter {scatter} m (maximum {largest} m), lengths {percent} % shorter than in"
        " three dimensions",
        plane=plane.name,
        scatter=figures(plane.scatter_m, 2),
        largest=figures(plane.max_distance_m, 2),
        percent=number(plane.shortening_percent, 1),
    )
    if plane.azimuths_from == "north":
        return text
    return tr("{plane}; trace angles are clockwise from up on this plane", plane=text)


def _set_text(values: dict[str, Any], plane: TracePlane | None) -> str:
    strike = azimuth(values["strike_deg"], 0)
    if plane is None or plane.azimuths_from == "north":
        text = tr_n(
            "{count} piece, strike {strike}",
            "{count} pieces, strike {strike}",
            values["n"],
            strike=strike,
        )
    else:
        text = tr_n(
            "{count} piece, angle {strike} from up",
            "{count} pieces, angle {strike} from up",
            values["n"],
            strike=strike,
        )
    if values["P21_1_per_m"] is not None:
        text += tr(
            ", P21 {value}",
            value=_format_interval(values["P21_1_per_m"], values["P21_95_1_per_m"], "1/m"),
        )
    if values["spacing"] is not None:
        text += tr(
            ", spacing {mean} along the line, {true} across the traces",
            mean=_format_interval(values["spacing"]["mean_m"], values["spacing"]["mean_95_m"], "m"),
            true=_format_interval(
                values["spacing"]["true_mean_m"], values["spacing"]["true_mean_95_m"], "m"
            ),
        )
    return text


def coverage_rows(coverage: FaceCoverage) -> list[str]:
    """Describe the coverage of a face in lines of text."""
    parts = (coverage.done, coverage.empty, coverage.unmeasurable, coverage.not_looked_at)
    names = (tr("done"), tr("empty"), tr("unmeasurable"), tr("not inspected"))
    lines = [
        tr_n(
            "{mark}: {cells} cell, {area:.4g} m2, {share:.0f} %",
            "{mark}: {cells} cells, {area:.4g} m2, {share:.0f} %",
            part.cells,
            mark=name,
            cells=part.cells,
            area=part.covered_m2,
            share=100.0 * (part.share or 0.0),
        )
        for name, part in zip(names, parts, strict=True)
    ]
    if coverage.P21_1_per_m is not None and coverage.density_1_per_m2 is not None:
        lines.append(
            tr(
                "in {area:.4g} m2 done or empty: {density:.3g} 1/m2, P21 {p21:.3g} 1/m",
                area=coverage.counted_m2,
                density=coverage.density_1_per_m2,
                p21=coverage.P21_1_per_m,
            )
        )
    return [*lines, *map(str, coverage.reasons)]
