"""The figure of a patch's deviations: the signed map, and profiles along and across."""

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
"""Blue below, red above: that of signed fields on models."""
_COLORS = {"along": "#0072b2", "across": "#d55e00"}
_NAMES = {
    "along": (to_translate("along the smoothest direction"), to_translate("down the dip")),
    "across": (to_translate("across it"), to_translate("along the strike")),
}
"""Of profiles where there is a smoothest direction, and where there is none."""
_ARROW = 0.3


def draw_surface(figure: Figure, found: SurfaceFigures, *, metric: bool = True) -> None:
    """On an empty figure. metric : lengths are metres, else units of the model"""
    unit = "m" if metric else tr("units")
    figure.set_layout_engine("constrained")
    grid = figure.add_gridspec(1, 2, width_ratios=(5, 4))
    _draw_map(figure, figure.add_subplot(grid[0]), found, unit)
    _draw_profiles(figure.add_subplot(grid[1]), found, unit)


def _draw_map(figure: Figure, axes: Axes, found: SurfaceFigures, unit: str) -> None:
    values = found.deviations
    rows, columns = values.shape
    cell = found.cell_m
    known = np.abs(values[np.isfinite(values)])
    reach = max(float(np.percentile(known, 98.0)), 1e-12)
    extent = (0.0, columns * cell, rows * cell, 0.0)
    shown = axes.imshow(
        values, cmap=_PALETTE, vmin=-reach, vmax=reach, extent=extent, interpolation="nearest"
    )
    bar = figure.colorbar(shown, ax=axes, location="bottom", shrink=0.8)
    bar.set_label(tr("deviation ({unit})", unit=unit))
    axes.set_xlabel(tr("along the strike ({unit})", unit=unit))
    axes.set_ylabel(tr("down the dip ({unit})", unit=unit))
    if found.plan is not None and found.plan.is_map:
        axes.set_xlabel(tr("to the east ({unit})", unit=unit))
        axes.set_ylabel(tr("to the south ({unit})", unit=unit))
    line = found.smoothest
    if line is not None and found.plan is not None:
        trend, plunge = np.radians([line.trend_deg, line.plunge_deg])
        vector = np.array(
            [np.sin(trend) * np.cos(plunge), np.cos(trend) * np.cos(plunge), -np.sin(plunge)]
        )
        way = np.array([vector @ found.plan.frame.right, vector @ found.plan.frame.down])
        way *= _ARROW * min(rows, columns) * cell / np.linalg.norm(way)
        middle = np.array([columns, rows]) * cell / 2
        axes.annotate(
            "",
            xy=tuple(middle + way),
            xytext=tuple(middle - way),
            arrowprops={"arrowstyle": "<->", "color": "black", "linewidth": 2.0},
        )


def _draw_profiles(axes: Axes, found: SurfaceFigures, unit: str) -> None:
    for one in found.profiles:
        name = tr(_NAMES[one.name][0 if found.smoothest is not None else 1])
        axes.plot(
            one.distance_m, one.deviation_m, color=_COLORS[one.name], linewidth=1.2, label=name
        )
    axes.axhline(0.0, color="0.6", linewidth=0.8)
    axes.set_xlabel(tr("distance from the middle ({unit})", unit=unit))
    axes.set_ylabel(tr("deviation ({unit})", unit=unit))
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False)


def in_lines(found: SurfaceFigures, *, metric: bool = True) -> list[str]:
    """What the figure shows, in sentences. metric : as in `draw_surface`"""

    def length(value: float) -> str:
        return length_text(value, metric=metric)

    said = [
        tr(
            "Deviations from {low} to {high}, RMS {rms}. The model's own noise: {noise}.",
            low=length(found.lowest_m),
            high=length(found.highest_m),
            rms=length(found.rms_m),
            noise=length(found.noise_m),
        )
    ]
    if found.noise_from == "mesh":
        said[-1] += " " + tr(
            "It was taken as a quarter of the mesh's edges, since a mesh smooths; state it where "
            "it is known."
        )
    if found.hurst is None:
        said.append(tr("No Hurst exponent: {reason}", reason=found.hurst_reason))
    else:
        said.append(
            tr(
                "Hurst exponent {H:.2f} ± {error:.2f} (95 %) over {from_} to {to}.",
                H=found.hurst.H,
                error=found.hurst.error95,
                from_=length(found.hurst.from_m),
                to=length(found.hurst.to_m),
            )
        )
    line = found.smoothest
    if line is None:
        said.append(tr("No smoothest direction: {reason}", reason=found.smoothest_reason))
    else:
        said.append(
            tr(
                "Smoothest along {trend}/{plunge:02.0f}, rake {rake:.0f}° ± {error:.0f}° "
                "(95 %): across it {ratio:.1f} times as rough. On a fault this may be the line of "
                "slip.",
                trend=format_azimuth(line.trend_deg),
                plunge=line.plunge_deg,
                rake=line.rake_deg,
                error=line.error95_deg,
                ratio=line.ratio,
            )
        )
    if found.trim is None:
        said.append(tr("The plane holds all over the patch."))
    return [*said, *map(str, found.warnings)]
