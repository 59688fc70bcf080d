"""Figure of the deviations of a patch: a signed map, and profiles along and across."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.words import to_translate, tr
from vomstudio.geology.notation import format_azimuth
from vomstudio.geometry.units import length_text
from vomstudio.products.surface.analysis import SurfaceFigures

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PALETTE = "RdBu_r"
"""Colour map with blue below and red above the plane, as for signed fields on models."""
_COLORS = {"along": "#0072b2", "across": "#d55e00"}
_NAMES = {
    "along": (to_translate("along the smoothest direction"), to_translate("down dip")),
    "across": (to_translate("across the smoothest direction"), to_translate("along strike")),
}
"""Names of the profiles with and without a smoothest direction."""
_ARROW_SHARE = 0.3


def draw_surface(figure: Figure, figures: SurfaceFigures, *, is_metric: bool = True) -> None:
    """Draw the deviations on an empty figure, in model units unless `is_metric`."""
    unit = "m" if is_metric else tr("units")
    figure.set_layout_engine("constrained")
    grid = figure.add_gridspec(1, 2, width_ratios=(5, 4))
    _draw_map(figure, figure.add_subplot(grid[0]), figures, unit)
    _draw_profiles(figure.add_subplot(grid[1]), figures, unit)


def _draw_map(figure: Figure, axes: Axes, figures: SurfaceFigures, unit: str) -> None:
    from matplotlib.ticker import MaxNLocator

    values = figures.deviations
    rows, columns = values.shape
    cell = figures.cell_m
    known_magnitudes = np.abs(values[np.isfinite(values)])
    max_deviation = max(float(np.percentile(known_magnitudes, 98.0)), 1e-12)
    extent = (0.0, columns * cell, rows * cell, 0.0)
    image = axes.imshow(
        values,
        cmap=_PALETTE,
        vmin=-max_deviation,
        vmax=max_deviation,
        extent=extent,
        interpolation="nearest",
    )
    bar = figure.colorbar(image, ax=axes, location="bottom", shrink=0.8, ticks=MaxNLocator(4))
    bar.set_label(tr("deviation ({unit})", unit=unit))
    axes.set_xlabel(tr("along strike ({unit})", unit=unit))
    axes.set_ylabel(tr("down dip ({unit})", unit=unit))
    if figures.plan is not None and figures.plan.is_map:
        axes.set_xlabel(tr("to the east ({unit})", unit=unit))
        axes.set_ylabel(tr("to the south ({unit})", unit=unit))
    line = figures.smoothest
    if line is not None and figures.plan is not None:
        trend, plunge = np.radians([line.trend_deg, line.plunge_deg])
        vector = np.array(
            [np.sin(trend) * np.cos(plunge), np.cos(trend) * np.cos(plunge), -np.sin(plunge)]
        )
        arrow = np.array([vector @ figures.plan.frame.right, vector @ figures.plan.frame.down])
        arrow *= _ARROW_SHARE * min(rows, columns) * cell / np.linalg.norm(arrow)
        centre = np.array([columns, rows]) * cell / 2
        axes.annotate(
            "",
            xy=tuple(centre + arrow),
            xytext=tuple(centre - arrow),
            arrowprops={"arrowstyle": "<->", "color": "black", "linewidth": 2.0},
        )


def _draw_profiles(axes: Axes, figures: SurfaceFigures, unit: str) -> None:
    for profile in figures.profiles:
        name = tr(_NAMES[profile.name][0 if figures.smoothest is not None else 1])
        axes.plot(
            profile.distance_m,
            profile.deviation_m,
            color=_COLORS[profile.name],
            linewidth=1.2,
            label=name,
        )
    axes.axhline(0.0, color="0.6", linewidth=0.8)
    axes.set_xlabel(tr("distance from the centre ({unit})", unit=unit))
    axes.set_ylabel(tr("deviation ({unit})", unit=unit))
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False)


def describe_figures(figures: SurfaceFigures, *, is_metric: bool = True) -> list[str]:
    """Describe the figures in sentences; `is_metric` as in `draw_surface`."""

    def length(value: float) -> str:
        return length_text(value, is_metric=is_metric)

    sentences = [
        tr(
            "Deviations from {low} to {high}, RMS {rms}. Noise of the model: {noise}.",
            low=length(figures.lowest_m),
            high=length(figures.highest_m),
            rms=length(figures.rms_m),
            noise=length(figures.noise_m),
        )
    ]
    if figures.noise_from == "mesh":
        sentences[-1] += " " + tr(
            "The noise was estimated as a quarter of the mesh edge length. Specify it if known."
        )
    if figures.hurst is None:
        sentences.append(tr("No Hurst exponent: {reason}", reason=figures.hurst_reason))
    else:
        sentences.append(
            tr(
                "Hurst exponent {H:.2f} ± {error:.2f} (95 %) over {from_} to {to}.",
                H=figures.hurst.H,
                error=figures.hurst.error95,
                from_=length(figures.hurst.from_m),
                to=length(figures.hurst.to_m),
            )
        )
    line = figures.smoothest
    if line is None:
        sentences.append(tr("No smoothest direction: {reason}", reason=figures.smoothest_reason))
    else:
        sentences.append(
            tr(
                "Smoothest along {trend}/{plunge:02.0f}, rake {rake:.0f}° ± {error:.0f}° (95 %);"
                " {ratio:.1f} times as rough across it. On a fault this may be the slip"
                " direction.",
                trend=format_azimuth(line.trend_deg),
                plunge=line.plunge_deg,
                rake=line.rake_deg,
                error=line.error95_deg,
                ratio=line.ratio,
            )
        )
    if figures.trim is None:
        sentences.append(tr("The plane fits the whole patch."))
    return [*sentences, *map(str, figures.warnings)]
