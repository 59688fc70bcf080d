"""The sheet of an orthophoto: true to scale on paper, with ticks at its frame, the scale bar, which
way is which, and the interpretation over the picture. As PDF its words are text and its lines are
lines; as PNG or JPEG it is the same page in pixels, with the resolution at which it is to scale."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.files.extensions import check_extension
from vomstudio.core.words import tr
from vomstudio.geometry.units import bar_text, round_length
from vomstudio.products.net.figure_file import write_figure
from vomstudio.products.ortho.legend_entries import entries_of
from vomstudio.products.ortho.sheet_legend import LETTER_MM, Legend
from vomstudio.products.ortho.vector_drawing import (
    DIP_TICK_MM,
    INK,
    MARGIN_MM,
    Drawing,
    Shape,
    left_margin_mm,
    number_text,
    paper_scale,
    placed_labels,
    ticks_over,
)
from vomstudio.products.ortho.view_description import (
    direction_text,
    end_labels,
    unknown_direction_text,
)
from vomstudio.products.ortho.view_directions import View

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


FORMATS = {".png": "png", ".jpg": "jpeg", ".jpeg": "jpeg", ".pdf": "pdf"}
DPI = 300.0

_TOP_MM = 16.0
_PT_MM = 0.353
_LEAST_WIDTH_MM = 130.0
"""Of what stands below the picture, beside a narrow one."""
_FONT_PT, _LABEL_PT, _LINE_PT = 8.0, 7.0, 0.9
_ROW_MM = 4.6
_BAR_MM, _WORDS_MM = 14.5, 20.5
"""Below the picture: the scale bar, and the first row of words."""


def format_of(path: str | Path) -> str:
    """The format that the ending asks for, a value of FORMATS. Raises UsageError."""
    return FORMATS[check_extension(path, FORMATS, "--sheet")]


def write_sheet(
    path: Path, drawing: Drawing, view: View, format: str, *, legend: bool = True
) -> None:
    """drawing : with its picture, in metres of its plane; format : of FORMATS; legend : what the
    colours and symbols of its shapes mean"""
    low, high = drawing.bounds
    scale = paper_scale(drawing.bounds)
    wide, tall = (1000.0 * (high - low) / scale).tolist()
    page = max(wide, _LEAST_WIDTH_MM)
    words = _words(view, page)
    below = _WORDS_MM + _ROW_MM * len(words)
    key = Legend(entries_of(drawing.shapes) if legend else [], page, _FONT_PT)
    size = (page + 2 * MARGIN_MM, tall + _TOP_MM + below + key.height_mm + 6.0)
    left, bottom = 0.5 * (size[0] - wide), size[1] - _TOP_MM - tall

    def draw(figure: Figure) -> None:
        ax = figure.add_axes((left / size[0], bottom / size[1], wide / size[0], tall / size[1]))
        ax.set_xlim(float(low[0]), float(high[0]))
        ax.set_ylim(float(low[1]), float(high[1]))
        # Paper keeps the picture's own pixels; the page's pixels are others, next to which nearest
        # neighbours would leave out or double whole rows of them.
        _draw_plane(ax, drawing, scale, "none" if format == "pdf" else "auto")
        _draw_frame(ax, drawing, scale, left)
        page_axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        page_axes.set_xlim(0.0, size[0])
        page_axes.set_ylim(0.0, size[1])
        page_axes.set_axis_off()
        _draw_ends(page_axes, drawing, view, (left, bottom, wide, tall))
        _draw_bar(page_axes, drawing, scale, (left, bottom, wide))
        side = min(left, 0.5 * (size[0] - page))
        key.draw(page_axes, side, bottom - below)
        for k, line in enumerate(words):
            page_axes.text(
                side,
                bottom - _WORDS_MM - _ROW_MM * k,
                line,
                fontsize=_FONT_PT,
                color=INK,
                va="top",
                parse_math=False,
            )

    write_figure(path, draw, format=format, size_mm=size, paper="#ffffff", dpi=DPI)


def _words(view: View, width_mm: float) -> list[str]:
    import textwrap

    unknown = unknown_direction_text(view)
    letters = round(width_mm / (LETTER_MM * _FONT_PT))
    reason = textwrap.wrap(view.reason.message, letters)
    return [direction_text(view), *reason, *([unknown] if unknown else [])]


def _draw_plane(ax: Axes, drawing: Drawing, scale: int, between: str) -> None:
    """The picture, what is interpreted on it, and labels that cover no other."""
    low, high = drawing.bounds
    if drawing.picture is not None:
        extent = (float(low[0]), float(high[0]), float(low[1]), float(high[1]))
        ax.imshow(drawing.picture, extent=extent, interpolation=between, aspect="auto", zorder=0)
    _draw_shapes(ax, drawing.shapes, scale)
    for label in placed_labels(drawing, scale, _PT_MM * _LABEL_PT):
        if label.apart:
            ends = np.array([label.named, (label.x, label.y)])
            ax.plot(ends[:, 0], ends[:, 1], color=label.shape.color, linewidth=0.5, zorder=3)
        ax.text(
            label.x,
            label.y,
            label.shape.label,
            fontsize=_LABEL_PT,
            va="center",
            zorder=4,
            ha="right" if label.right else "left",
            color=label.color,
            parse_math=False,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8},
        )


def _draw_shapes(ax: Axes, shapes: Sequence[Shape], scale: int) -> None:
    """All lines of a colour are one path with gaps: thousands of paths would take long."""
    lines: dict[tuple[str, float, int], list[FloatArray]] = {}
    dots: dict[str, list[FloatArray]] = {}
    for shape in shapes:
        if len(shape.points) == 1:
            dots.setdefault(shape.color, []).append(shape.points)
        if shape.filled:
            ax.fill(
                shape.points[:, 0],
                shape.points[:, 1],
                color=shape.color,
                alpha=0.5,
                linewidth=0.0,
                zorder=1,
            )
        # Light below, so that a line is seen on dark rock too.
        for width, color, above in ((2.2, "white", 1), (1.0, shape.color, 2)):
            for line in _lines_of(shape, scale):
                lines.setdefault((color, width, above), []).append(line)
    gap = np.full((1, 2), math.nan)
    for (color, width, above), own in lines.items():
        x, y = np.concatenate([part for line in own for part in (line, gap)][:-1]).T
        ax.plot(
            x, y, color=color, linewidth=width * _LINE_PT, zorder=above, solid_joinstyle="round"
        )
    for color, places in dots.items():
        x, y = np.concatenate(places).T
        ax.plot(x, y, "o", markersize=3.0, color=color, zorder=3)


def _lines_of(shape: Shape, scale: int) -> list[FloatArray]:
    """(n, 2) of a line or outline, or those by which a plane is drawn; none of any other point."""
    points = shape.points
    if len(points) > 1:
        return [np.vstack([points, points[:1]]) if shape.closed else points]
    return shape.marks(0.001 * scale * DIP_TICK_MM)


def _draw_frame(ax: Axes, drawing: Drawing, scale: int, left: float) -> None:
    """left : beside the frame, in millimetres; where the numbers would push the name of the axis
    off the page they stand upright, as those of a map's grid."""
    low, high = drawing.bounds
    beside = ticks_over(float(low[0]), float(high[0]))
    wide = LETTER_MM * _FONT_PT * (max((len(number_text(v)) for v in beside), default=0) + 2)
    ax.set_xticks(_with_room(beside, 0.001 * scale * wide))
    above = ticks_over(float(low[1]), float(high[1]))
    upright = left_margin_mm(drawing.bounds, _PT_MM * _FONT_PT) > left
    longest = max((len(number_text(v)) for v in above.tolist()), default=0)
    tall = LETTER_MM * _FONT_PT * (longest + 2) if upright else _ROW_MM
    if upright:
        # Clear of the numbers below the frame's corner.
        above = above[above >= float(low[1]) + 0.0005 * scale * tall]
    ax.set_yticks(_with_room(above, 0.001 * scale * tall))
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter(lambda value, _: number_text(value))
    ax.tick_params(labelsize=_FONT_PT, width=0.6, length=3.0, color=INK, labelcolor=INK)
    if upright:
        ax.tick_params(axis="y", labelrotation=90)
        for text in ax.get_yticklabels():
            text.set_verticalalignment("center")
    for spine in ax.spines.values():
        spine.set_linewidth(0.6)
        spine.set_color(INK)
    ax.set_xlabel(drawing.axes[0], fontsize=_FONT_PT, color=INK)
    ax.set_ylabel(drawing.axes[1], fontsize=_FONT_PT, color=INK)


def _with_room(ticks: FloatArray, apart: float) -> FloatArray:
    """Those of a narrow picture whose words do not meet."""
    if len(ticks) < 2:
        return ticks
    return ticks[:: max(1, math.ceil(apart / float(ticks[1] - ticks[0])))]


def _draw_ends(
    ax: Axes, drawing: Drawing, view: View, frame: tuple[float, float, float, float]
) -> None:
    """Beside a narrow picture the words of its ends keep clear of the arrow."""
    left, bottom, wide, tall = frame
    above, middle = bottom + tall + 3.0, left + 0.5 * wide
    side = max(0.5 * wide, 12.0 + LETTER_MM * _FONT_PT * max(map(len, drawing.ends)))
    look: dict[str, Any] = {"fontsize": _FONT_PT + 1.0, "weight": "bold", "color": INK}
    ax.text(middle - side, above, drawing.ends[0], ha="left", va="bottom", **look)
    ax.text(middle + side, above, drawing.ends[1], ha="right", va="bottom", **look)
    arrow = {"arrowstyle": "-|>", "color": INK, "linewidth": 0.9, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", (middle, above + 7.0), (middle, above - 0.5), arrowprops=arrow)
    ax.text(middle + 2.0, above + 3.0, end_labels(view)[2], va="center", **look)


def _draw_bar(ax: Axes, drawing: Drawing, scale: int, place: tuple[float, float, float]) -> None:
    from matplotlib.patches import Rectangle

    left, bottom, _ = place
    low, high = drawing.bounds
    length = round_length(0.25 * float(high[0] - low[0]))
    wide, y = 1000.0 * length / scale, bottom - _BAR_MM
    for part, color in ((0.0, INK), (0.5, "white")):
        ax.add_patch(
            Rectangle(
                (left + part * wide, y),
                0.5 * wide,
                1.3,
                facecolor=color,
                edgecolor=INK,
                linewidth=0.6,
            )
        )
    said = bar_text(length, metric=drawing.metric)
    if drawing.metric:
        said = tr("{length}, 1 : {scale}", length=said, scale=f"{scale:,}".replace(",", " "))
    ax.text(left + wide + 2.0, y + 0.65, said, va="center", fontsize=_FONT_PT, color=INK)
