"""Drawing of a rose diagram or histogram in its panel."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geology.roses import AngleHistogram, Rose
from vomstudio.products.net.style import NetStyle, layer, mix_colors

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BOTTOM, TOP = -0.92, 1.12
_LABEL_LETTERS = 3.3
"""Width of the label of a share relative to its font size."""
LEFT, RIGHT = -0.82, 1.1
"""Left and right limits of a histogram in its panel."""


def petal_radii(share: FloatArray, outermost_share: float, is_area_scaled: bool) -> FloatArray:
    """Return the radii (k,) that represent shares; the outermost ring has radius 1."""
    return (
        np.sqrt(share / outermost_share) if is_area_scaled else np.asarray(share / outermost_share)
    )


def draw_rose(
    ax: Axes,
    rose: Rose,
    rings: list[float],
    is_area_scaled: bool,
    color: str,
    style: NetStyle,
    up: str = "N",
) -> None:
    """Draw a rose whose outermost ring has radius 1; `up` is the letter at its top."""
    from matplotlib.patches import Circle, Polygon

    radii = petal_radii(np.array(rings), rings[-1], is_area_scaled)
    for radius in radii:
        is_last = radius == radii[-1]
        ring = Circle(
            (0, 0),
            float(radius),
            facecolor="none",
            edgecolor=style.ink if is_last else style.soft,
            linewidth=(1.25 if is_last else 0.5) * style.line_pt,
            zorder=layer("rim" if is_last else "density"),
        )
        ax.add_patch(ring)
    for quarter in np.arange(0.0, 360.0, 90.0):
        ax.plot(
            *_ray(quarter, (0.0, 1.04)),
            color=style.soft,
            linewidth=0.5 * style.line_pt,
            zorder=layer("density"),
        )
    lengths = petal_radii(rose.shares, rings[-1], is_area_scaled)
    for i, length in enumerate(lengths):
        if length > 0:
            azimuth = np.radians(np.linspace(i, i + 1, 13) * rose.bin_deg)
            arc = length * np.stack([np.sin(azimuth), np.cos(azimuth)], axis=1)
            petal = Polygon(
                np.vstack([[0.0, 0.0], arc]),
                closed=True,
                facecolor=mix_colors(color, style.net, 0.25),
                edgecolor=style.outline(mix_colors(color, style.ink, 0.3)),
                linewidth=0.7 * style.line_pt,
                zorder=layer("poles"),
            )
            ax.add_patch(petal)
    if rose.has_preferred_direction and rose.mean_deg is not None:
        for end in (rose.mean_deg, rose.mean_deg + 180.0)[: 2 if rose.axial else 1]:
            ax.plot(
                *_ray(end, (1.0, 1.1)),
                color=style.ink,
                linewidth=3.0 * style.line_pt,
                solid_capstyle="butt",
                zorder=layer("means"),
            )
    ax.text(
        0.0,
        1.13,
        up,
        ha="center",
        va="bottom",
        fontsize=1.15 * style.font_pt,
        weight="bold",
        color=style.ink,
    )
    label_azimuth = _ring_label_azimuth(rose)
    for share, radius in zip(rings, radii, strict=True):
        x, y = _ray(label_azimuth, (float(radius), float(radius)))
        label = ax.text(
            x[0],
            y[0],
            f"{100 * share:g} %",
            ha="center",
            va="center",
            fontsize=0.9 * style.font_pt,
            color=style.ink,
            zorder=layer("words"),
        )
        label.set_bbox({"facecolor": style.net, "edgecolor": "none", "pad": 0.6, "alpha": 0.85})


def _ring_label_azimuth(rose: Rose) -> float:
    """Return the azimuth for ring labels, near north or south where petals are shortest."""
    candidates = np.array([30.0, 330.0, 150.0, 210.0, 20.0, 340.0, 160.0, 200.0, 40.0, 320.0])
    span = np.arange(-15.0, 16.0, 1.0)
    bins = ((candidates[:, None] + span) % 360.0 // rose.bin_deg).astype(np.intp)
    longest_shares = rose.shares[bins % len(rose.shares)].max(axis=1)
    return float(candidates[int(np.argmin(np.round(longest_shares, 9)))])


def draw_histogram(
    ax: Axes, histogram: AngleHistogram, rings: list[float], color: str, style: NetStyle
) -> None:
    """Draw bars from 0 to 90 degrees; the highest tick is at the last value of `rings`."""
    from matplotlib.patches import Rectangle

    top, height, bar_width = rings[-1], TOP - BOTTOM, (RIGHT - LEFT) / 90.0
    label_style: dict[str, Any] = {"fontsize": 0.9 * style.font_pt, "color": style.ink}
    # In a narrow panel, the labels of the shares are smaller.
    figure = ax.get_figure(root=True)
    assert figure is not None
    low, high = ax.get_xlim()
    panel_pt = 72.0 * ax.get_position().width * figure.get_figwidth()
    margin_pt = panel_pt * (LEFT - 0.06 - low) / (high - low)
    label_size = min(0.9 * style.font_pt, margin_pt / _LABEL_LETTERS)
    for share in (0.0, *rings):
        y = BOTTOM + height * share / top
        is_baseline = share == 0.0
        ax.plot(
            [LEFT, RIGHT],
            [y, y],
            color=style.ink if is_baseline else style.soft,
            linewidth=(1.25 if is_baseline else 0.5) * style.line_pt,
            zorder=layer("rim" if is_baseline else "density"),
        )
        if share:
            label = f"{100 * share:g} %"
            ax.text(
                LEFT - 0.04,
                y,
                label,
                ha="right",
                va="center",
                fontsize=label_size,
                color=style.ink,
            )
    for angle in (0, 30, 60, 90):
        x = LEFT + angle * bar_width
        ax.plot([x, x], [BOTTOM, BOTTOM - 0.05], color=style.ink, linewidth=style.line_pt)
        ax.text(x, BOTTOM - 0.08, f"{angle}°", ha="center", va="top", **label_style)
    width = histogram.bin_deg * bar_width
    for i, share in enumerate(histogram.shares):
        if share > 0:
            bar = Rectangle(
                (LEFT + i * width, BOTTOM),
                width,
                height * float(share) / top,
                facecolor=mix_colors(color, style.net, 0.25),
                edgecolor=style.outline(mix_colors(color, style.ink, 0.3)),
                linewidth=0.7 * style.line_pt,
                zorder=layer("poles"),
            )
            ax.add_patch(bar)
    if histogram.mean_deg is not None:
        x = LEFT + histogram.mean_deg * bar_width
        ax.plot(
            [x, x],
            [BOTTOM, TOP],
            color=style.ink,
            linewidth=1.5 * style.line_pt,
            linestyle="--",
            zorder=layer("means"),
        )


def _ray(azimuth_deg: float, radii: tuple[float, float]) -> tuple[list[float], list[float]]:
    a = math.radians(azimuth_deg)
    return [radius * math.sin(a) for radius in radii], [radius * math.cos(a) for radius in radii]
