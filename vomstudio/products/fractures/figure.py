"""Figure of a fracture map: map, rose, lengths, nodes, and intensity by window size."""

from __future__ import annotations

import math
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.words import to_translate, tr
from vomstudio.geology.fractures.length_laws import LengthFit, find_law
from vomstudio.geology.fractures.network import MappedNetwork, TraceLengths
from vomstudio.geology.fractures.nodes import NodeCounts
from vomstudio.geology.fractures.pieces import line_segments
from vomstudio.geology.fractures.trace_plane import trace_azimuths_deg
from vomstudio.geology.notation import format_wind
from vomstudio.geology.roses import count_rose
from vomstudio.products.net.contents import OKABE_ITO
from vomstudio.products.net.figure_file import size_settings, write_figure
from vomstudio.products.net.rose import choose_rings
from vomstudio.products.net.rose_drawing import draw_rose
from vomstudio.products.net.style import PRINT, NetStyle

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIZE_MM = (170.0, 128.0)
BIN_DEG = 10.0
MAX_SHORT_NAME = 12
"""Maximum length of set names for a two-column legend below the map."""
_LAWS = {
    "exponential": to_translate("exponential"),
    "lognormal": to_translate("lognormal"),
    "weibull": to_translate("Weibull"),
    "power_law": to_translate("power law"),
}


def write_fractures(
    target: str | Path | IO[bytes],
    mapped: MappedNetwork,
    *,
    format: str,
    style: NetStyle = PRINT,
    dpi: float = 300.0,
) -> None:
    """Write the figure as SVG, PDF or PNG; text remains editable in SVG and PDF."""
    write_figure(
        target,
        lambda figure: draw_fractures(figure, mapped, style),
        format=format,
        size_mm=SIZE_MM,
        paper=style.paper,
        dpi=dpi,
        settings=size_settings(style),
    )


def draw_fractures(figure: Figure, mapped: MappedNetwork, style: NetStyle = PRINT) -> list[Axes]:
    """Draw the map, rose, nodes, lengths and intensity, and return their axes."""
    figure.set_facecolor(style.paper)
    places = {
        "a": (0.02, 0.47, 0.33, 0.47),
        "b": (0.36, 0.47, 0.29, 0.47),
        "c": (0.68, 0.49, 0.30, 0.41),
        "d": (0.09, 0.09, 0.38, 0.31),
        "e": (0.60, 0.09, 0.37, 0.31),
    }
    if not mapped.found.P21_by_size:
        del places["e"]
        places["d"] = (0.09, 0.09, 0.88, 0.31)
    axes = [figure.add_axes(place) for place in places.values()]
    draw = (_draw_map, _draw_rose, _draw_triangle, _draw_lengths, _draw_sizes)
    for letter, ax, one in zip(places, axes, draw, strict=False):
        one(ax, mapped, style)
        x = places[letter][0]
        is_lower_row = letter in "de"
        figure.text(
            max(x - 0.07, 0.008) if is_lower_row else x,
            0.425 if is_lower_row else 0.96,
            letter,
            fontsize=1.25 * style.font_pt,
            weight="bold",
            color=style.ink,
            va="bottom",
        )
    return axes


def _color(i: int, style: NetStyle) -> str:
    return style.color(OKABE_ITO[i % len(OKABE_ITO)])


def _draw_map(ax: Axes, mapped: MappedNetwork, style: NetStyle) -> None:
    import shapely
    from matplotlib.collections import LineCollection

    ax.set_aspect("equal")
    ax.set_axis_off()
    lines = mapped.pieces.lines
    thin = float(np.clip(12.0 / math.sqrt(max(len(lines), 1)), 0.15, 0.8)) * style.line_pt
    for i, name in enumerate(mapped.sets):
        mine = lines[mapped.set_of == i]
        color = _color(i, style) if len(mapped.sets) > 1 else style.ink
        paths = [shapely.get_coordinates(line) for line in mine]
        ax.add_collection(
            LineCollection(paths, colors=color, linewidths=thin, label=f"{name} ({len(mine):,})")
        )
    counted = mapped.counted
    edges = [] if counted.area is None else list(shapely.get_parts(shapely.boundary(counted.area)))
    edges += [] if counted.scanlines is None else list(counted.scanlines)
    ax.add_collection(
        LineCollection(
            [shapely.get_coordinates(e) for e in edges],
            linewidths=1.2 * style.line_pt,
            colors=style.ink if len(mapped.sets) > 1 else _color(1, style),
        )
    )
    shapes = [*lines, *edges]
    if not shapes:
        return
    low_x, low_y, high_x, high_y = shapely.total_bounds(shapes)
    span = max(high_x - low_x, high_y - low_y) or 1.0
    ax.set_xlim(low_x - 0.02 * span, high_x + 0.02 * span)
    rows = min(len(mapped.sets), 8) if len(mapped.sets) > 1 else 0
    ax.set_ylim(low_y - (0.12 + 0.07 * max(rows - 1, 0)) * span, high_y + 0.24 * span)
    bar = _round_length(0.3 * span)
    ax.plot(
        [low_x, low_x + bar],
        [low_y - 0.05 * span] * 2,
        color=style.ink,
        linewidth=2 * style.line_pt,
        solid_capstyle="butt",
    )
    ax.text(
        low_x + bar / 2,
        low_y - 0.07 * span,
        f"{bar:g} m",
        ha="center",
        va="top",
        fontsize=style.font_pt,
        color=style.ink,
    )
    left_name, right_name, up = _orientation(mapped)
    for x, name, side in ((low_x, left_name, "left"), (high_x, right_name, "right")):
        ax.text(
            x,
            high_y + 0.04 * span,
            name,
            ha=side,
            va="bottom",
            weight="bold",
            fontsize=0.85 * style.font_pt,
            color=style.ink,
        )
    middle = 0.5 * (low_x + high_x)
    ax.annotate(
        up,
        (middle, high_y + 0.02 * span),
        (middle, high_y + 0.14 * span),
        ha="center",
        va="bottom",
        fontsize=0.85 * style.font_pt,
        weight="bold",
        color=style.ink,
        arrowprops={"arrowstyle": "<-", "color": style.ink, "linewidth": style.line_pt},
    )
    is_short = max((len(name) for name in mapped.sets), default=0) <= MAX_SHORT_NAME
    if 1 < len(mapped.sets) <= 8:
        ax.legend(
            loc="lower right",
            fontsize=0.85 * style.font_pt,
            frameon=False,
            handlelength=1.2,
            labelcolor=style.ink,
            borderaxespad=0.0,
            ncols=2 if len(mapped.sets) > 4 and is_short else 1,
        )
    network = mapped.found
    title, separator = tr("{count:,} traces", count=network.traces), ", "
    if network.plane is not None and not network.plane.is_horizontal:
        title = tr("{count:,} traces on {plane}", count=network.traces, plane=network.plane.name)
        # If it includes the plane, the text is wider than the map.
        separator = "\n"
    if network.P21_1_per_m is not None:
        title += separator + tr("P21 = {p21:.3g} 1/m", p21=network.P21_1_per_m)
    ax.set_title(title, fontsize=style.font_pt, weight="bold", color=style.ink, pad=4)


def _orientation(mapped: MappedNetwork) -> tuple[str, str, str]:
    """Return the compass directions to the left, right and top of the map, or ""."""
    plane = mapped.found.plane
    is_map = plane is None or plane.is_horizontal
    if mapped.y_axis != "N":
        return "", "", tr(mapped.y_axis) if is_map else tr("up")
    if plane is None or plane.is_horizontal:
        return format_wind(270.0), format_wind(90.0), "N"
    azimuth = math.degrees(math.atan2(plane.right[0], plane.right[1]))
    return format_wind(azimuth + 180.0), format_wind(azimuth), tr("up")


def _round_length(length: float) -> float:
    """Round a length down to 1, 2 or 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(length))
    return next(power * step for step in (5.0, 2.0, 1.0) if power * step <= length * (1 + 1e-9))


def _draw_rose(ax: Axes, mapped: MappedNetwork, style: NetStyle) -> None:
    start, end, _ = line_segments(mapped.pieces.lines)
    plane = mapped.found.plane
    directions = end - start
    rose = count_rose(
        trace_azimuths_deg(directions, plane),
        axial=True,
        bin_deg=BIN_DEG,
        weights=np.hypot(*directions.T),
    )
    ax.set_xlim(-1.25, 1.25)
    ax.set_ylim(-1.14, 1.3)
    ax.set_aspect("equal")
    ax.set_axis_off()
    if rose.total <= 0:
        return
    is_from_y = plane is None or plane.azimuths_from == "north"
    y_axis = mapped.y_axis if is_from_y else "up"
    rings = choose_rings(float(rose.shares.max()))
    draw_rose(ax, rose, rings, True, _color(1, style), style, up=tr(y_axis))
    counted = tr("% of {length:,.0f} m in {step:g}°", length=rose.total, step=BIN_DEG)
    ax.set_title(
        # On a single line, the text would overlap the map.
        tr("pitch on the face,\n{counted}", counted=counted)
        if y_axis == "up"
        else tr("strike, {counted}", counted=counted),
        fontsize=style.font_pt,
        weight="bold",
        color=style.ink,
        pad=4,
    )


def triangle_place(i: float, y: float, x: float) -> tuple[float, float]:
    """Return the position of given I, Y and X node shares in a triangle of side 1.

    The I corner is at the top, Y at the left and X at the right.
    """
    total = i + y + x
    return (0.5 * i + x) / total, math.sqrt(0.75) * i / total


def _draw_triangle(ax: Axes, mapped: MappedNetwork, style: NetStyle) -> None:
    ax.set_aspect("equal")
    ax.set_axis_off()
    ax.set_xlim(-0.14, 1.14)
    ax.set_ylim(-0.16, 1.0)
    corners = [triangle_place(*row) for row in np.eye(3)]
    ax.plot(*zip(*corners, corners[0], strict=True), color=style.ink, linewidth=1.2 * style.line_pt)
    for share in (0.2, 0.4, 0.6, 0.8):
        remainder = 1 - share
        for one, other in (
            ((share, remainder, 0), (share, 0, remainder)),
            ((remainder, share, 0), (0, share, remainder)),
            ((remainder, 0, share), (0, remainder, share)),
        ):
            ends = [triangle_place(*row) for row in (one, other)]
            ax.plot(*zip(*ends, strict=True), color=style.soft, linewidth=0.35 * style.line_pt)
    for per_branch in (1.0, 1.5):
        _draw_connections(ax, per_branch, style)
    for (x, y), label, ha, va in zip(
        corners, ("I", "Y", "X"), ("center", "right", "left"), ("bottom", "top", "top"), strict=True
    ):
        ax.text(
            x,
            y + (0.03 if va == "bottom" else -0.03),
            label,
            ha=ha,
            va=va,
            weight="bold",
            fontsize=1.15 * style.font_pt,
            color=style.ink,
        )
    nodes = mapped.found.nodes
    if nodes.I + nodes.Y + nodes.X:
        ax.plot(
            *triangle_place(nodes.I, nodes.Y, nodes.X),
            marker="o",
            markersize=5.5,
            color=_color(1, style),
            markeredgecolor=style.ink,
            markeredgewidth=0.6 * style.line_pt,
        )
    ax.set_title(_node_words(nodes), fontsize=style.font_pt, weight="bold", color=style.ink, pad=8)


def _node_words(nodes: NodeCounts) -> str:
    return tr("nodes: I {i:,}, Y {y:,}, X {x:,}", i=nodes.I, y=nodes.Y, x=nodes.X)


def _draw_connections(ax: Axes, per_branch: float, style: NetStyle) -> None:
    """Draw a line of equal connections per branch, (3 Y + 4 X) / ((I + 3 Y + 4 X) / 2)."""
    # With I + Y + X = 1: I = (2 - c) / c * (3 Y + 4 X).
    ends = []
    for weight, which in ((3.0, 1), (4.0, 2)):
        ratio = (2.0 - per_branch) / per_branch * weight
        isolated = 1.0 / (1.0 + ratio)
        row = [1.0 - isolated, 0.0, 0.0]
        row[which] = isolated
        ends.append(triangle_place(*row))
    ax.plot(
        *zip(*ends, strict=True),
        color=style.soft,
        linewidth=0.9 * style.line_pt,
        linestyle=(0, (4, 2)),
    )
    x, y = ends[1]
    ax.text(
        x + 0.02,
        y,
        f"C$_B$ {per_branch:.1f}",
        fontsize=0.85 * style.font_pt,
        va="center",
        ha="left",
        color=style.soft,
    )


def _draw_lengths(ax: Axes, mapped: MappedNetwork, style: NetStyle) -> None:
    from scipy.stats import CensoredData, ecdf

    _plain_axes(ax, style)
    ax.set_xlabel(tr("trace length, m"), fontsize=style.font_pt, color=style.ink)
    ax.set_ylabel(tr("share that is longer"), fontsize=style.font_pt, color=style.ink)
    lengths, cut = mapped.pieces.lengths(), mapped.pieces.cut.any(axis=1)
    length = mapped.found.length
    if length.mean_m is not None:
        ax.set_title(
            tr(
                "mean length {mean:.3g} m, of the pieces {naive:.3g} m",
                mean=length.mean_m,
                naive=length.naive_mean_m,
            ),
            fontsize=style.font_pt,
            weight="bold",
            color=style.ink,
            pad=4,
        )
    if not len(lengths) or cut.all():
        return
    survival = ecdf(CensoredData.right_censored(lengths, cut)).sf
    is_positive = survival.probabilities > 0
    x, s = survival.quantiles[is_positive], survival.probabilities[is_positive]
    ax.step(
        np.concatenate([[x[0]], x]),
        np.concatenate([[1.0], s]),
        where="post",
        color=style.soft,
        linewidth=1.6 * style.line_pt,
        label=tr("pieces as seen (Kaplan-Meier)"),
    )
    at = np.sort(lengths[cut])
    if len(at):
        ax.plot(
            at,
            np.interp(at, x, s, left=1.0),
            linestyle="none",
            marker="|",
            markersize=4,
            markeredgewidth=0.5,
            color=style.ink,
            label=tr("cut off ({share:.0f} %)", share=100 * float(cut.mean())),
        )
    grid = np.geomspace(
        max(float(lengths.min()), 1e-3 * float(lengths.max())), float(lengths.max()), 200
    )
    _draw_fits(ax, length, grid, style)
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_ylim(0.5 / len(lengths), 1.5)
    ax.set_xlim(grid[0], 1.3 * grid[-1])
    ax.legend(
        loc="lower left",
        fontsize=0.85 * style.font_pt,
        frameon=False,
        labelcolor=style.ink,
        handlelength=1.6,
        borderaxespad=0.2,
    )


def _draw_fits(ax: Axes, length: TraceLengths, grid: Any, style: NetStyle) -> None:
    if not length.fits:
        return
    best = length.fits[0]
    name = tr(_LAWS[best.distribution])
    ax.plot(
        grid,
        _survival(best, grid),
        color=_color(1, style),
        linewidth=1.6 * style.line_pt,
        label=tr("{law}, whole traces", law=name) if length.uncorrected else name,
    )
    same = [f for f in length.uncorrected if f.distribution == best.distribution]
    if same:
        ax.plot(
            grid,
            _survival(same[0], grid),
            color=style.ink,
            linewidth=style.line_pt,
            linestyle=(0, (3, 2)),
            label=tr("{law}, edge taken as chance", law=name),
        )


def _survival(fit: LengthFit, x: Any) -> Any:
    law, u = find_law(fit)
    return np.exp(law.log_s(x, u))


def _draw_sizes(ax: Axes, mapped: MappedNetwork, style: NetStyle) -> None:
    _plain_axes(ax, style)
    ax.set_xlabel(tr("radius of circular windows, m"), fontsize=style.font_pt, color=style.ink)
    ax.set_ylabel("P21, 1/m", fontsize=style.font_pt, color=style.ink)
    sizes = mapped.found.P21_by_size
    r = np.array([s.radius_m for s in sizes])
    mean = np.array([s.P21_1_per_m for s in sizes])
    low, high = (np.array([getattr(s, f"{w}_1_per_m") for s in sizes]) for w in ("min", "max"))
    std = np.array([s.std_1_per_m for s in sizes])
    color = _color(1, style)
    ax.fill_between(
        r, low, high, color=style.soft, alpha=0.18, linewidth=0, label=tr("all windows")
    )
    ax.fill_between(
        r,
        np.maximum(mean - std, 0),
        mean + std,
        color=color,
        alpha=0.25,
        linewidth=0,
        label=tr("one standard deviation"),
    )
    ax.plot(
        r,
        mean,
        color=color,
        marker="o",
        markersize=3,
        linewidth=1.2 * style.line_pt,
        label=tr("mean"),
    )
    if mapped.found.P21_1_per_m is not None:
        ax.axhline(
            mapped.found.P21_1_per_m,
            color=style.ink,
            linewidth=0.8 * style.line_pt,
            linestyle=(0, (4, 2)),
            label=tr("whole area"),
        )
    ax.set_xscale("log")
    ax.set_ylim(bottom=0)
    _round_ticks(ax, r)
    ax.legend(
        loc="upper right",
        fontsize=0.85 * style.font_pt,
        frameon=False,
        labelcolor=style.ink,
        handlelength=1.6,
        borderaxespad=0.2,
    )
    ax.set_title(
        tr("intensity by size of the window"),
        fontsize=style.font_pt,
        weight="bold",
        color=style.ink,
        pad=4,
    )


def _round_ticks(ax: Axes, values: Any) -> None:
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter

    powers = 10.0 ** np.arange(-6.0, 7.0)
    ticks = np.sort(np.outer(powers, [1.0, 2.0, 5.0]).ravel())
    ax.xaxis.set_major_locator(
        FixedLocator(ticks[(ticks >= values.min() * 0.9) & (ticks <= values.max() * 1.1)])
    )
    ax.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
    ax.xaxis.set_minor_formatter(NullFormatter())


def _plain_axes(ax: Axes, style: NetStyle) -> None:
    ax.set_facecolor(style.net)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        ax.spines[side].set_color(style.ink)
    ax.tick_params(labelsize=0.9 * style.font_pt, colors=style.ink, width=0.8 * style.line_pt)
