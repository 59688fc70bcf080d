"""Printable sheet of an orthophoto, true to scale on paper.

It has a frame with ticks, a scale bar, directions, and the interpretation over the picture. In PDF,
text and lines are vectors. PNG and JPEG contain the same page in pixels, at the resolution that the
scale requires.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.files.extensions import check_extension
from vomstudio.core.words import tr
from vomstudio.geometry.units import round_length, scale_bar_text
from vomstudio.products.net.figure_file import write_figure
from vomstudio.products.ortho.legend_entries import create_entries
from vomstudio.products.ortho.sheet_legend import LETTER_MM, SheetLegend
from vomstudio.products.ortho.vector_drawing import (
    DIP_TICK_MM,
    INK,
    MARGIN_MM,
    Drawing,
    DrawingShape,
    choose_ticks,
    format_number,
    left_margin_mm,
    paper_scale,
    place_labels,
)
from vomstudio.products.ortho.view_description import (
    direction_text,
    end_labels,
    unknown_direction_text,
)
from vomstudio.products.ortho.view_directions import ViewDirection

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


FORMATS = {".png": "png", ".jpg": "jpeg", ".jpeg": "jpeg", ".pdf": "pdf"}
DPI = 300.0

_TOP_MM = 16.0
_MM_PER_PT = 0.353
_MIN_WIDTH_MM = 130.0
"""Minimum width of the area below a narrow picture."""
_FONT_PT, _LABEL_PT, _LINE_PT = 8.0, 7.0, 0.9
_ROW_MM = 4.6
_BAR_MM, _TEXT_MM = 14.5, 20.5
"""Positions of the scale bar and of the first row of text below the picture."""


def format_from_path(path: str | Path) -> str:
    """Return the format for an extension, one of the values of FORMATS.

    Raises
    ------
    UsageError
    """
    return FORMATS[check_extension(path, FORMATS, "--sheet")]


def write_sheet(
    path: Path, drawing: Drawing, view: ViewDirection, format: str, *, legend: bool = True
) -> None:
    """Write a sheet.

    Parameters
    ----------
    path : Path
    drawing : Drawing
        Drawing with its picture, in metres in its plane.
    view : ViewDirection
    format : str
        One of the values of FORMATS.
    legend : bool
        Whether to explain colours and symbols.
    """
    low, high = drawing.bounds
    scale = paper_scale(drawing.bounds)
    width, height = (1000.0 * (high - low) / scale).tolist()
    page = max(width, _MIN_WIDTH_MM)
    texts = _description_lines(view, page)
    text_height = _TEXT_MM + _ROW_MM * len(texts)
    sheet_legend = SheetLegend(create_entries(drawing.shapes) if legend else [], page, _FONT_PT)
    size = (page + 2 * MARGIN_MM, height + _TOP_MM + text_height + sheet_legend.height_mm + 6.0)
    x_left, y_bottom = 0.5 * (size[0] - width), size[1] - _TOP_MM - height

    def draw(figure: Figure) -> None:
        ax = figure.add_axes(
            (x_left / size[0], y_bottom / size[1], width / size[0], height / size[1])
        )
        ax.set_xlim(float(low[0]), float(high[0]))
        ax.set_ylim(float(low[1]), float(high[1]))
        # Keep the picture's own pixels on paper: nearest-neighbour resampling to the pixels of the
        # page would omit or double whole rows.
        _draw_contents(ax, drawing, scale, "none" if format == "pdf" else "auto")
        _draw_frame(ax, drawing, scale, x_left)
        page_axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        page_axes.set_xlim(0.0, size[0])
        page_axes.set_ylim(0.0, size[1])
        page_axes.set_axis_off()
        _draw_ends(page_axes, drawing, view, (x_left, y_bottom, width, height))
        _draw_bar(page_axes, drawing, scale, (x_left, y_bottom, width))
        margin = min(x_left, 0.5 * (size[0] - page))
        sheet_legend.draw(page_axes, margin, y_bottom - text_height)
        for k, line in enumerate(texts):
            page_axes.text(
                margin,
                y_bottom - _TEXT_MM - _ROW_MM * k,
                line,
                fontsize=_FONT_PT,
                color=INK,
                va="top",
                parse_math=False,
            )

    write_figure(path, draw, format=format, size_mm=size, paper="#ffffff", dpi=DPI)


def _description_lines(view: ViewDirection, width_mm: float) -> list[str]:
    import textwrap

    unknown_text = unknown_direction_text(view)
    letters_per_line = round(width_mm / (LETTER_MM * _FONT_PT))
    # A direction that was given needs no reason.
    is_given = view.reason.code == "view.as-given"
    reason = [] if is_given else textwrap.wrap(view.reason.message, letters_per_line)
    return [direction_text(view), *reason, *([unknown_text] if unknown_text else [])]


def _draw_contents(ax: Axes, drawing: Drawing, scale: int, interpolation: str) -> None:
    """Draw the picture, its interpretation, and non-overlapping labels."""
    low, high = drawing.bounds
    if drawing.picture is not None:
        extent = (float(low[0]), float(high[0]), float(low[1]), float(high[1]))
        ax.imshow(
            drawing.picture, extent=extent, interpolation=interpolation, aspect="auto", zorder=0
        )
    _draw_shapes(ax, drawing.shapes, scale)
    for label in place_labels(drawing, scale, _MM_PER_PT * _LABEL_PT):
        if label.is_separate:
            ends = np.array([label.anchor, (label.x, label.y)])
            ax.plot(ends[:, 0], ends[:, 1], color=label.shape.color, linewidth=0.5, zorder=3)
        ax.text(
            label.x,
            label.y,
            label.shape.label,
            fontsize=_LABEL_PT,
            va="center",
            zorder=4,
            ha="right" if label.is_on_right else "left",
            color=label.color,
            parse_math=False,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.9, "pad": 0.8},
        )


def _draw_shapes(ax: Axes, shapes: Sequence[DrawingShape], scale: int) -> None:
    """Draw all lines of a colour as one path, since thousands of paths would be slow."""
    lines: dict[tuple[str, float, int], list[FloatArray]] = {}
    dots: dict[str, list[FloatArray]] = {}
    for shape in shapes:
        if len(shape.points) == 1:
            dots.setdefault(shape.color, []).append(shape.points)
        if shape.is_filled:
            ax.fill(
                shape.points[:, 0],
                shape.points[:, 1],
                color=shape.color,
                alpha=0.5,
                linewidth=0.0,
                zorder=1,
            )
        # A light line underneath makes the line visible on dark rock.
        for width, color, z_order in ((2.2, "white", 1), (1.0, shape.color, 2)):
            for line in _shape_lines(shape, scale):
                lines.setdefault((color, width, z_order), []).append(line)
    gap = np.full((1, 2), math.nan)
    for (color, width, z_order), color_lines in lines.items():
        x, y = np.concatenate([part for line in color_lines for part in (line, gap)][:-1]).T
        ax.plot(
            x, y, color=color, linewidth=width * _LINE_PT, zorder=z_order, solid_joinstyle="round"
        )
    for color, positions in dots.items():
        x, y = np.concatenate(positions).T
        ax.plot(x, y, "o", markersize=3.0, color=color, zorder=3)


def _shape_lines(shape: DrawingShape, scale: int) -> list[FloatArray]:
    """Return the polylines (n, 2) of a line, outline or plane symbol; none for other points."""
    points = shape.points
    if len(points) > 1:
        return [np.vstack([points, points[:1]]) if shape.is_closed else points]
    return shape.marks(0.001 * scale * DIP_TICK_MM)


def _draw_frame(ax: Axes, drawing: Drawing, scale: int, left: float) -> None:
    """Draw the frame and ticks, with upright tick labels if space is short.

    Tick labels are upright if they would otherwise push the axis label off the page. `left` is the
    space beside the frame in mm.
    """
    low, high = drawing.bounds
    x_ticks = choose_ticks(float(low[0]), float(high[0]))
    width = (
        LETTER_MM
        * _FONT_PT
        * (max((len(format_number(x_tick)) for x_tick in x_ticks), default=0) + 2)
    )
    ax.set_xticks(_thin_ticks(x_ticks, 0.001 * scale * width))
    y_ticks = choose_ticks(float(low[1]), float(high[1]))
    is_upright = left_margin_mm(drawing.bounds, _MM_PER_PT * _FONT_PT) > left
    max_length = max((len(format_number(y_tick)) for y_tick in y_ticks.tolist()), default=0)
    height = LETTER_MM * _FONT_PT * (max_length + 2) if is_upright else _ROW_MM
    if is_upright:
        # Keep clear of the tick labels below the corner of the frame.
        y_ticks = y_ticks[y_ticks >= float(low[1]) + 0.0005 * scale * height]
    ax.set_yticks(_thin_ticks(y_ticks, 0.001 * scale * height))
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter(lambda value, _: format_number(value))
    ax.tick_params(labelsize=_FONT_PT, width=0.6, length=3.0, color=INK, labelcolor=INK)
    if is_upright:
        ax.tick_params(axis="y", labelrotation=90)
        for text in ax.get_yticklabels():
            text.set_verticalalignment("center")
    for spine in ax.spines.values():
        spine.set_linewidth(0.6)
        spine.set_color(INK)
    ax.set_xlabel(drawing.axes[0], fontsize=_FONT_PT, color=INK)
    ax.set_ylabel(drawing.axes[1], fontsize=_FONT_PT, color=INK)


def _thin_ticks(ticks: FloatArray, min_distance: float) -> FloatArray:
    """Thin the ticks of a narrow picture so that their labels do not overlap."""
    if len(ticks) < 2:
        return ticks
    return ticks[:: max(1, math.ceil(min_distance / float(ticks[1] - ticks[0])))]


def _draw_ends(
    ax: Axes, drawing: Drawing, view: ViewDirection, frame: tuple[float, float, float, float]
) -> None:
    """Draw the upward arrow above the picture, and the directions at both ends beside it."""
    x_left, y_bottom, width, height = frame
    text_top, centre = y_bottom + height + 3.0, x_left + 0.5 * width
    half_width = max(0.5 * width, 12.0 + LETTER_MM * _FONT_PT * max(map(len, drawing.ends)))
    text_style: dict[str, Any] = {"fontsize": _FONT_PT + 1.0, "weight": "bold", "color": INK}
    ax.text(centre - half_width, text_top, drawing.ends[0], ha="left", va="bottom", **text_style)
    ax.text(centre + half_width, text_top, drawing.ends[1], ha="right", va="bottom", **text_style)
    arrow = {"arrowstyle": "-|>", "color": INK, "linewidth": 0.9, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", (centre, text_top + 7.0), (centre, text_top - 0.5), arrowprops=arrow)
    ax.text(centre + 2.0, text_top + 3.0, end_labels(view)[2], va="center", **text_style)


def _draw_bar(ax: Axes, drawing: Drawing, scale: int, position: tuple[float, float, float]) -> None:
    from matplotlib.patches import Rectangle

    x_left, y_bottom, _ = position
    low, high = drawing.bounds
    length = round_length(0.25 * float(high[0] - low[0]))
    width, y = 1000.0 * length / scale, y_bottom - _BAR_MM
    for part, color in ((0.0, INK), (0.5, "white")):
        ax.add_patch(
            Rectangle(
                (x_left + part * width, y),
                0.5 * width,
                1.3,
                facecolor=color,
                edgecolor=INK,
                linewidth=0.6,
            )
        )
    text = scale_bar_text(length, is_metric=drawing.is_metric)
    if drawing.is_metric:
        text = tr("{length}, 1 : {scale}", length=text, scale=f"{scale:,}".replace(",", " "))
    ax.text(x_left + width + 2.0, y + 0.65, text, va="center", fontsize=_FONT_PT, color=INK)
