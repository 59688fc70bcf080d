"""Figure of a fracture map: map, rose, lengths, nodes, and intensity by window size."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, Literal

import numpy as np

from vomstudio.core.words import to_translate, tr
from vomstudio.geology.fractures.length_laws import LengthFit, find_law
from vomstudio.geology.fractures.network import MappedNetwork, TraceLengths
from vomstudio.geology.fractures.pieces import line_segments
from vomstudio.geology.fractures.trace_plane import trace_azimuths_deg
from vomstudio.geology.notation import format_compass_point
from vomstudio.geology.roses import count_rose
from vomstudio.geometry.units import round_length
from vomstudio.products.figure_layout import (
    arrange_columns,
    extend_limits_for_legend,
    set_log_ticks,
)
from vomstudio.products.net.contents import OKABE_ITO
from vomstudio.products.net.figure_file import size_settings, write_figure
from vomstudio.products.net.legend import shorten_text, text_width
from vomstudio.products.net.rose import choose_rings
from vomstudio.products.net.rose_drawing import draw_rose
from vomstudio.products.net.style import PRINT, NetStyle

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH_MM = 170.0
BIN_DEG = 10.0
MAX_SETS = 24
"""Maximum number of sets in the legend."""
_MARGIN_MM, _LETTER_MM = 3.0, 6.0
_TITLES_MM, _PANEL_MM, _CURVES_MM = 10.0, 52.0, 42.0
"""Heights of the titles, the upper panels and the curves."""
_AXIS_MM, _LEGEND_ROW_MM = 12.0, 4.4
_LEGEND_LINE_MM, _LEGEND_GAP_MM = 7.0, 5.0
_BAR_MM, _ARROW_MM = 8.0, 9.0
"""Heights for the scale bar below the map and the arrow above it."""
_DASHES = ("-", (0, (4, 1.5)), (0, (1, 1)))
"""Line styles that distinguish sets of the same colour."""
_LAW_NAMES = {
    "exponential": to_translate("exponential"),
    "lognormal": to_translate("lognormal"),
    "weibull": to_translate("Weibull"),
    "power_law": to_translate("power law"),
}


@dataclass(frozen=True)
class FracturePage:
    """Page layout of a fracture figure.

    Parameters
    ----------
    legend_column_widths_mm : tuple of float
        Widths of the legend's columns.
    rows : int
        Number of rows of the legend; 0 without a legend.
    curves : str
        Letters of the panels in the lower row: d for lengths, e for intensity.
    """

    legend_column_widths_mm: tuple[float, ...]
    rows: int
    curves: str

    @property
    def curve_row_height_mm(self) -> float:
        """Height of the row of curves."""
        return _TITLES_MM + _CURVES_MM + _AXIS_MM if self.curves else _MARGIN_MM

    @property
    def legend_height_mm(self) -> float:
        """Height of the legend."""
        return _LEGEND_ROW_MM * self.rows + _MARGIN_MM if self.rows else 0.0

    @property
    def height_mm(self) -> float:
        """Height of the page."""
        return (
            _MARGIN_MM + _TITLES_MM + _PANEL_MM + self.legend_height_mm + self.curve_row_height_mm
        )


def lay_out_page(mapped_network: MappedNetwork, style: NetStyle = PRINT) -> FracturePage:
    """Lay out the figure, without panels that have no data.

    The legend names at most `MAX_SETS` sets; it is omitted for a single set.

    Parameters
    ----------
    mapped_network : MappedNetwork
    style : NetStyle, optional

    Returns
    -------
    FracturePage
    """
    is_cut = np.asarray(mapped_network.pieces.is_cut.any(axis=1))
    panel_letters = ("d" if len(is_cut) and not is_cut.all() else "") + (
        "e" if mapped_network.statistics.P21_by_size else ""
    )
    texts = _legend_texts(mapped_network)
    if not texts:
        return FracturePage((), 0, panel_letters)
    mm_per_pt = 25.4 / 72.0
    widths = [
        _LEGEND_LINE_MM + 1.5 + mm_per_pt * text_width(text, 0.9 * style.font_pt) for text in texts
    ]
    width = WIDTH_MM - 2 * _MARGIN_MM
    columns = arrange_columns(widths, width, _LEGEND_GAP_MM)
    return FracturePage(
        tuple(min(column, width) for column in columns),
        math.ceil(len(texts) / len(columns)),
        panel_letters,
    )


def write_fractures(
    target: str | Path | IO[bytes],
    mapped_network: MappedNetwork,
    *,
    format: str,
    style: NetStyle = PRINT,
    dpi: float = 300.0,
) -> None:
    """Write the figure as SVG, PDF or PNG; text remains editable in SVG and PDF."""
    page = lay_out_page(mapped_network, style)
    write_figure(
        target,
        lambda figure: draw_fractures(figure, mapped_network, page, style),
        format=format,
        size_mm=(WIDTH_MM, page.height_mm),
        paper=style.paper,
        dpi=dpi,
        settings=size_settings(style),
    )


def draw_fractures(
    figure: Figure, mapped_network: MappedNetwork, page: FracturePage, style: NetStyle = PRINT
) -> list[Axes]:
    """Draw the map, rose, nodes, lengths and intensity, and return their axes."""
    figure.set_facecolor(style.paper)
    height = page.height_mm
    bottom = height - _MARGIN_MM - _TITLES_MM - _PANEL_MM
    base = _AXIS_MM
    positions = {
        "a": (_MARGIN_MM, bottom + _BAR_MM, 54.0, _PANEL_MM - _BAR_MM - _ARROW_MM),
        "b": (61.0, bottom, 52.0, _PANEL_MM),
        "c": (117.0, bottom, 50.0, _PANEL_MM),
    }
    if page.curves == "de":
        positions |= {"d": (16.0, base, 66.0, _CURVES_MM), "e": (104.0, base, 63.0, _CURVES_MM)}
    elif page.curves:
        positions[page.curves] = (16.0, base, 151.0, _CURVES_MM)
    draw = {
        "a": _draw_map,
        "b": _draw_rose,
        "c": _draw_triangle,
        "d": _draw_lengths,
        "e": _draw_intensities,
    }
    page_axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), zorder=1)
    page_axes.set_xlim(0.0, WIDTH_MM)
    page_axes.set_ylim(0.0, height)
    page_axes.set_axis_off()
    axes = []
    for letter, (x, y, width, panel_height) in positions.items():
        ax = figure.add_axes(
            (x / WIDTH_MM, y / height, width / WIDTH_MM, panel_height / height), zorder=2
        )
        title = draw[letter](ax, mapped_network, style)
        axes.append(ax)
        letter_x = x - 13.0 if letter in "de" else x
        top = y + panel_height + _TITLES_MM - 1.0
        top += _ARROW_MM if letter == "a" else 0.0
        page_axes.text(
            letter_x,
            top,
            letter,
            fontsize=1.25 * style.font_pt,
            weight="bold",
            color=style.ink,
            va="top",
        )
        page_axes.text(
            letter_x + _LETTER_MM,
            top - 0.5,
            title,
            fontsize=style.font_pt,
            color=style.ink,
            va="top",
            linespacing=1.1,
            parse_math=False,
        )
    _draw_bar(page_axes, axes[0], positions["a"], style)
    _draw_directions(page_axes, positions["a"], mapped_network, style)
    _draw_legend(page_axes, mapped_network, page, bottom, style)
    return axes


def _color(i: int, style: NetStyle) -> str:
    return style.color(OKABE_ITO[i % len(OKABE_ITO)])


def _dash(i: int) -> Any:
    return _DASHES[i // len(OKABE_ITO) % len(_DASHES)]


def _legend_texts(mapped_network: MappedNetwork) -> list[str]:
    """Return the names of the sets with their numbers of pieces; empty for a single set."""
    if len(mapped_network.sets) < 2:
        return []
    counts = np.bincount(
        mapped_network.set_indices[mapped_network.set_indices >= 0],
        minlength=len(mapped_network.sets),
    )
    width = (WIDTH_MM - 2 * _MARGIN_MM - _LEGEND_LINE_MM - 1.5) * 72.0 / 25.4
    texts = [
        shorten_text(f"{name} ({count:,})", PRINT.font_pt, width)
        for name, count in zip(mapped_network.sets, counts.tolist(), strict=True)
    ]
    if len(texts) > MAX_SETS:
        hidden_count = len(texts) - MAX_SETS + 1
        texts[MAX_SETS - 1 :] = [tr("and {count} more", count=hidden_count)]
    return texts


def _draw_legend(
    page_axes: Axes, mapped_network: MappedNetwork, page: FracturePage, top: float, style: NetStyle
) -> None:
    for k, text in enumerate(_legend_texts(mapped_network)):
        row, column = divmod(k, len(page.legend_column_widths_mm))
        x = _MARGIN_MM + sum(page.legend_column_widths_mm[:column]) + _LEGEND_GAP_MM * column
        y = top - _MARGIN_MM - _LEGEND_ROW_MM * (row + 0.5)
        if k < MAX_SETS - 1 or len(mapped_network.sets) <= MAX_SETS:
            page_axes.plot(
                [x, x + _LEGEND_LINE_MM],
                [y, y],
                color=_color(k, style),
                linestyle=_dash(k),
                linewidth=1.4 * style.line_pt,
            )
        page_axes.text(
            x + _LEGEND_LINE_MM + 1.5,
            y,
            text,
            fontsize=0.9 * style.font_pt,
            color=style.ink,
            va="center",
            parse_math=False,
        )


def _draw_map(ax: Axes, mapped_network: MappedNetwork, style: NetStyle) -> str:
    import shapely
    from matplotlib.collections import LineCollection

    ax.set_axis_off()
    lines = mapped_network.pieces.lines
    line_width = float(np.clip(12.0 / math.sqrt(max(len(lines), 1)), 0.15, 0.8)) * style.line_pt
    for i in range(len(mapped_network.sets)):
        set_lines = lines[mapped_network.set_indices == i]
        color = _color(i, style) if len(mapped_network.sets) > 1 else style.ink
        paths = [shapely.get_coordinates(line) for line in set_lines]
        ax.add_collection(
            LineCollection(paths, colors=color, linewidths=line_width, linestyles=_dash(i))
        )
    sampling_region = mapped_network.region
    edges = (
        []
        if sampling_region.area is None
        else list(shapely.get_parts(shapely.boundary(sampling_region.area)))
    )
    edges += [] if sampling_region.scanlines is None else list(sampling_region.scanlines)
    ax.add_collection(
        LineCollection(
            [shapely.get_coordinates(edge) for edge in edges],
            linewidths=1.2 * style.line_pt,
            colors=style.ink if len(mapped_network.sets) > 1 else _color(1, style),
        )
    )
    network = mapped_network.statistics
    title = tr("{count:,} traces", count=network.traces)
    if network.plane is not None and not network.plane.is_horizontal:
        title = tr("{count:,} traces on {plane}", count=network.traces, plane=network.plane.name)
    if network.P21_1_per_m is not None:
        title += "\n" + tr("P21 = {p21:.3g} 1/m", p21=network.P21_1_per_m)
    shapes = [*lines, *edges]
    if shapes:
        low_x, low_y, high_x, high_y = shapely.total_bounds(shapes)
        ax.set_xlim(low_x, high_x)
        ax.set_ylim(low_y, high_y)
        _fill_box(ax)
    return title


def _fill_box(ax: Axes) -> None:
    """Extend the limits of a map to the shape of its box, so that both axes have equal scales."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    position = ax.get_position()
    width, height = position.width * figure.get_figwidth(), position.height * figure.get_figheight()
    (x_left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    length = 1.02 * max((right - x_left) / width, (high - low) / height, 1e-9)
    x, y = 0.5 * (x_left + right), 0.5 * (low + high)
    ax.set_xlim(x - 0.5 * length * width, x + 0.5 * length * width)
    ax.set_ylim(y - 0.5 * length * height, y + 0.5 * length * height)


def _draw_bar(
    page_axes: Axes, ax: Axes, bounds: tuple[float, float, float, float], style: NetStyle
) -> None:
    x_left, bottom, width, _ = bounds
    low, high = ax.get_xlim()
    bar = round_length(0.35 * (high - low))
    length = width * bar / (high - low)
    page_axes.plot(
        [x_left, x_left + length],
        [bottom - 3.0] * 2,
        color=style.ink,
        linewidth=2 * style.line_pt,
        solid_capstyle="butt",
    )
    page_axes.text(
        x_left + length + 1.5,
        bottom - 3.0,
        f"{bar:g} m",
        va="center",
        fontsize=0.9 * style.font_pt,
        color=style.ink,
    )


def _draw_directions(
    page_axes: Axes,
    bounds: tuple[float, float, float, float],
    mapped_network: MappedNetwork,
    style: NetStyle,
) -> None:
    """Draw the arrow to north or up and, for a face, the compass points of its ends."""
    x_left, bottom, width, height = bounds
    top = bottom + height
    left_name, right_name, up = _orientation(mapped_network)
    bold_style: dict[str, Any] = {
        "weight": "bold",
        "fontsize": 0.9 * style.font_pt,
        "color": style.ink,
        "va": "bottom",
    }
    page_axes.text(x_left, top + 1.5, left_name, ha="left", **bold_style)
    page_axes.text(x_left + width, top + 1.5, right_name, ha="right", **bold_style)
    centre = x_left + 0.5 * width
    page_axes.annotate(
        "",
        (centre, top + 5.0),
        (centre, top),
        arrowprops={"arrowstyle": "-|>", "color": style.ink, "linewidth": style.line_pt},
    )
    page_axes.text(centre, top + 5.0, up, ha="center", **bold_style)


def _orientation(mapped_network: MappedNetwork) -> tuple[str, str, str]:
    """Return the labels of the left, right and top of the map; empty if not required."""
    plane = mapped_network.statistics.plane
    if plane is None or plane.is_horizontal:
        return "", "", "N" if mapped_network.y_axis == "N" else tr(mapped_network.y_axis)
    if mapped_network.y_axis != "N":
        return "", "", tr("up")
    azimuth = math.degrees(math.atan2(plane.right[0], plane.right[1]))
    return format_compass_point(azimuth + 180.0), format_compass_point(azimuth), tr("up")


def _draw_rose(ax: Axes, mapped_network: MappedNetwork, style: NetStyle) -> str:
    start, end, _ = line_segments(mapped_network.pieces.lines)
    plane = mapped_network.statistics.plane
    directions = end - start
    rose = count_rose(
        trace_azimuths_deg(directions, plane),
        is_axial=True,
        bin_deg=BIN_DEG,
        weights=np.hypot(*directions.T),
    )
    ax.set_xlim(-1.25, 1.25)
    ax.set_ylim(-1.14, 1.36)
    ax.set_aspect("equal")
    ax.set_axis_off()
    if rose.total <= 0:
        return ""
    is_azimuth_from_y = plane is None or plane.azimuths_from == "north"
    y_axis = mapped_network.y_axis if is_azimuth_from_y else "up"
    rings = choose_rings(float(rose.shares.max()))
    draw_rose(ax, rose, rings, True, _color(1, style), style, up=tr(y_axis))
    count = len(mapped_network.pieces.lines)
    text = (
        tr("Pitch on the face, n = {count:,} pieces", count=count)
        if y_axis == "up"
        else tr("Strike, n = {count:,} pieces", count=count)
    )
    caption = tr("% of {length:,.0f} m per bin of {step:g}°", length=rose.total, step=BIN_DEG)
    return f"{text}\n{caption}"


def triangle_position(i: float, y: float, x: float) -> tuple[float, float]:
    """Return the position of given I, Y and X node shares in a triangle of side 1.

    The I corner is at the top, Y at the left and X at the right.
    """
    node_count = i + y + x
    return (0.5 * i + x) / node_count, math.sqrt(0.75) * i / node_count


def _draw_triangle(ax: Axes, mapped_network: MappedNetwork, style: NetStyle) -> str:
    ax.set_aspect("equal")
    ax.set_axis_off()
    ax.set_xlim(-0.14, 1.14)
    ax.set_ylim(-0.16, 1.0)
    corners = [triangle_position(*row) for row in np.eye(3)]
    ax.plot(*zip(*corners, corners[0], strict=True), color=style.ink, linewidth=1.2 * style.line_pt)
    for fraction in (0.2, 0.4, 0.6, 0.8):
        third_share = 1 - fraction
        for first_corner, second_corner in (
            ((fraction, third_share, 0), (fraction, 0, third_share)),
            ((third_share, fraction, 0), (0, fraction, third_share)),
            ((third_share, 0, fraction), (0, third_share, fraction)),
        ):
            ends = [triangle_position(*row) for row in (first_corner, second_corner)]
            ax.plot(*zip(*ends, strict=True), color=style.soft, linewidth=0.35 * style.line_pt)
    for connections_per_branch in (1.0, 1.5):
        _draw_connections(ax, connections_per_branch, style)
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
    nodes = mapped_network.statistics.nodes
    if nodes.I + nodes.Y + nodes.X:
        ax.plot(
            *triangle_position(nodes.I, nodes.Y, nodes.X),
            marker="o",
            markersize=5.5,
            color=_color(1, style),
            markeredgecolor=style.ink,
            markeredgewidth=0.6 * style.line_pt,
        )
    return tr(
        "Nodes, n = {count:,}\nI {i:,}, Y {y:,}, X {x:,}",
        count=nodes.I + nodes.Y + nodes.X,
        i=nodes.I,
        y=nodes.Y,
        x=nodes.X,
    )


def _draw_connections(ax: Axes, connections_per_branch: float, style: NetStyle) -> None:
    """Draw a line of equal connections per branch, (3 Y + 4 X) / ((I + 3 Y + 4 X) / 2)."""
    # With I + Y + X = 1: I = (2 - c) / c * (3 Y + 4 X).
    ends = []
    for weight, corner_index in ((3.0, 1), (4.0, 2)):
        ratio = (2.0 - connections_per_branch) / connections_per_branch * weight
        connected_share = 1.0 / (1.0 + ratio)
        row = [1.0 - connected_share, 0.0, 0.0]
        row[corner_index] = connected_share
        ends.append(triangle_position(*row))
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
        f"C$_B$ {connections_per_branch:.1f}",
        fontsize=0.85 * style.font_pt,
        va="center",
        ha="left",
        color=style.soft,
    )


def _draw_lengths(ax: Axes, mapped_network: MappedNetwork, style: NetStyle) -> str:
    from scipy.stats import CensoredData, ecdf

    _style_axes(ax, style)
    ax.set_xlabel(tr("trace length, m"), fontsize=style.font_pt, color=style.ink)
    ax.set_ylabel(tr("fraction longer than this"), fontsize=style.font_pt, color=style.ink)
    lengths, is_cut = mapped_network.pieces.lengths(), mapped_network.pieces.is_cut.any(axis=1)
    length = mapped_network.statistics.length
    title = tr("Lengths, n = {count:,} pieces", count=len(lengths))
    if length.mean_m is not None:
        title += "\n" + (
            tr(
                "mean {mean:.3g} m ({naive:.3g} m for clipped pieces)",
                mean=length.mean_m,
                naive=length.naive_mean_m,
            )
            if is_cut.any()
            else tr("mean {mean:.3g} m", mean=length.mean_m)
        )
    survival = ecdf(CensoredData.right_censored(lengths, is_cut)).sf
    is_positive = survival.probabilities > 0
    x, s = survival.quantiles[is_positive], survival.probabilities[is_positive]
    ax.step(
        np.concatenate([[x[0]], x]),
        np.concatenate([[1.0], s]),
        where="post",
        color=style.soft,
        linewidth=1.6 * style.line_pt,
        label=tr("pieces (Kaplan-Meier)"),
    )
    censored_lengths = np.sort(lengths[is_cut])
    if len(censored_lengths):
        ax.plot(
            censored_lengths,
            np.interp(censored_lengths, x, s, left=1.0),
            linestyle="none",
            marker="|",
            markersize=4,
            markeredgewidth=0.5,
            color=style.ink,
            label=tr("censored ({share:.0f} %)", share=100 * float(is_cut.mean())),
        )
    grid = np.geomspace(
        max(float(lengths.min()), 1e-3 * float(lengths.max())), float(lengths.max()), 200
    )
    _draw_fits(ax, length, grid, style)
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_ylim(0.5 / len(lengths), 1.5)
    ax.set_xlim(grid[0], 1.3 * grid[-1])
    _add_legend(ax, "lower left", style)
    for axis in (ax.xaxis, ax.yaxis):
        set_log_ticks(axis, 0.9 * style.font_pt)
    return title


def _add_legend(ax: Axes, location: Literal["lower left", "upper right"], style: NetStyle) -> None:
    legend = ax.legend(
        *ax.get_legend_handles_labels(),
        loc=location,
        fontsize=0.85 * style.font_pt,
        frameon=False,
        labelcolor=style.ink,
        handlelength=1.6,
        borderaxespad=0.2,
    )
    extend_limits_for_legend(ax, legend)


def _draw_fits(ax: Axes, length: TraceLengths, grid: Any, style: NetStyle) -> None:
    if not length.fits:
        return
    best_fit = length.fits[0]
    name = tr(_LAW_NAMES[best_fit.distribution])
    ax.plot(
        grid,
        _survival(best_fit, grid),
        color=_color(1, style),
        linewidth=1.6 * style.line_pt,
        label=tr("{law}, whole traces", law=name) if length.uncorrected else name,
    )
    matching_fits = [f for f in length.uncorrected if f.distribution == best_fit.distribution]
    if matching_fits:
        ax.plot(
            grid,
            _survival(matching_fits[0], grid),
            color=style.ink,
            linewidth=style.line_pt,
            linestyle=(0, (3, 2)),
            label=tr("{law}, random censoring", law=name),
        )


def _survival(fit: LengthFit, x: Any) -> Any:
    law, u = find_law(fit)
    return np.exp(law.log_survival(x, u))


def _draw_intensities(ax: Axes, mapped_network: MappedNetwork, style: NetStyle) -> str:
    _style_axes(ax, style)
    ax.set_xlabel(tr("radius of circular windows, m"), fontsize=style.font_pt, color=style.ink)
    ax.set_ylabel("P21, 1/m", fontsize=style.font_pt, color=style.ink)
    sizes = mapped_network.statistics.P21_by_size
    r = np.array([size.radius_m for size in sizes])
    mean = np.array([size.P21_1_per_m for size in sizes])
    low, high = (
        np.array([getattr(size, f"{w}_1_per_m") for size in sizes]) for w in ("min", "max")
    )
    std = np.array([size.std_1_per_m for size in sizes])
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
    if mapped_network.statistics.P21_1_per_m is not None:
        ax.axhline(
            mapped_network.statistics.P21_1_per_m,
            color=style.ink,
            linewidth=0.8 * style.line_pt,
            linestyle=(0, (4, 2)),
            label=tr("whole area"),
        )
    ax.set_xscale("log")
    ax.set_ylim(bottom=0)
    _add_legend(ax, "upper right", style)
    set_log_ticks(ax.xaxis, 0.9 * style.font_pt)
    return tr("Intensity by window size")


def _style_axes(ax: Axes, style: NetStyle) -> None:
    ax.set_facecolor(style.net)
    for spine in ("top", "right"):
        ax.spines[spine].set_visible(False)
    for spine in ("left", "bottom"):
        ax.spines[spine].set_color(style.ink)
    ax.tick_params(labelsize=0.9 * style.font_pt, colors=style.ink, width=0.8 * style.line_pt)
