"""Figure of a log: a scaled column of beds with thicknesses, lithologies and notes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import tr
from vomstudio.geology.beds.bed_log import BedLog, Interval
from vomstudio.products.net.figure_file import size_settings, write_figure
from vomstudio.products.net.style import PRINT, NetStyle
from vomstudio.products.section.decimals import format_with_error
from vomstudio.products.section.lithology_style import (
    DEFAULT_WIDTH,
    DUNHAM_CLASSES,
    GRAIN_SIZES,
    LithologyStyle,
    find_style,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_MAX_COLUMN_MM = 190.0
"""Maximum height of the column, such that the figure with its text fits on an A4 page."""
_LEFT_MM, _COLUMN_MM = 20.0, 38.0
_THICKNESS_MM, _LITHOLOGY_MM, _NOTES_MM = 64.0, 96.0, 130.0
"""Left edges of the text columns beside the beds."""
_WIDTHS_MM = (100.0, 130.0, 170.0)
"""Widths of a page with thicknesses, with lithologies too, and with notes."""
_TOP_MM, _BOTTOM_MM, _NOTE_ROW_MM = 17.0, 5.0, 6.0
_ROW_MM = 4.0
_MAX_ROWS = 250
"""Maximum number of beds to label; in longer logs, only those as thick as a row are labelled."""
_MAX_LITHOLOGY_LENGTH, _MAX_NOTES_LENGTH = 22, 26
_BRICK_MM = (5.0, 2.2)


@dataclass(frozen=True)
class LogPage:
    """Page layout of a log.

    Parameters
    ----------
    scale : float
        Denominator of the scale.
    column_height_mm : float
        Height of the column.
    label_heights_mm : (n,) array
        Height of the text of each bed above the base of the column; NaN if the text does not fit.
    lowest_mm, highest_mm : float
        Lower and upper limits of the drawing, relative to the base of the column.
    width_mm : float
        Width of the page.
    notes_height_mm : float
        Height of the grain sizes and notes below the column.
    """

    scale: float
    column_height_mm: float
    label_heights_mm: FloatArray
    lowest_mm: float
    highest_mm: float
    width_mm: float
    notes_height_mm: float

    @property
    def base_mm(self) -> float:
        """Lower edge of the page, relative to the base of the column."""
        return self.lowest_mm - _BOTTOM_MM - self.notes_height_mm

    @property
    def height_mm(self) -> float:
        """Height of the page in mm."""
        return self.highest_mm + _TOP_MM - self.base_mm


def lay_out_page(log: BedLog) -> LogPage:
    """Lay out a log at the largest round scale at which its column fits on a page."""
    thickness_m = log.total_m.value
    scale = _round_up(1000.0 * thickness_m / _MAX_COLUMN_MM) if thickness_m > 0 else 1.0
    column = 1000.0 * thickness_m / scale
    centres = [500.0 * (interval.base_m + interval.top_m) / scale for interval in log.intervals]
    heights_mm = [1000.0 * (interval.top_m - interval.base_m) / scale for interval in log.intervals]
    is_labelled = [len(centres) <= _MAX_ROWS or height >= _ROW_MM for height in heights_mm]
    rows = np.full(len(centres), np.nan)
    rows[is_labelled] = _spread(
        [centre for centre, n in zip(centres, is_labelled, strict=True) if n], _ROW_MM
    )
    half_row = 0.5 * _ROW_MM
    low = min(0.0, float(np.nanmin(rows, initial=0.0)) - half_row)
    high = max(column, float(np.nanmax(rows, initial=0.0)) + half_row)
    columns = 2 if any(i.notes for i in log.intervals) else 0
    columns = columns or int(any(i.lithology for i in log.intervals))
    return LogPage(
        scale=scale,
        column_height_mm=column,
        label_heights_mm=rows,
        lowest_mm=low,
        highest_mm=high,
        width_mm=_WIDTHS_MM[columns],
        notes_height_mm=_NOTE_ROW_MM * len(_legend_parts(_bed_styles(log))),
    )


def _bed_styles(log: BedLog) -> list[LithologyStyle]:
    return [find_style(interval.lithology, interval.strabospot) for interval in log.intervals]


def _legend_parts(styles: Sequence[LithologyStyle]) -> list[str]:
    """Return the names of the parts below the column, from top to bottom."""
    parts = []
    if any(style.width is not None and not style.is_dunham for style in styles):
        parts.append("grains")
    if any(style.width is not None and style.is_dunham for style in styles):
        parts += ["dunham", "classes"]
    if any(style.width is None for style in styles):
        parts.append("dashes")
    return parts


def write_log_figure(
    target: str | Path | IO[bytes],
    log: BedLog,
    *,
    format: str,
    description: str = "",
    is_metric: bool = True,
    style: NetStyle = PRINT,
    dpi: float = 300.0,
) -> None:
    """Write the figure of a log to scale; text remains editable in SVG and PDF.

    Parameters
    ----------
    target : str, Path or binary file
    log : BedLog
    format : {"svg", "pdf", "png"}
    description : str
        Description of how the thicknesses were determined.
    is_metric : bool
        Whether lengths are in metres.
    style : NetStyle
    dpi : float

    Raises
    ------
    UsageError
        If the format is not supported.
    """
    page = lay_out_page(log)
    write_figure(
        target,
        lambda figure: draw_log(figure, log, page, description, is_metric, style),
        format=format,
        size_mm=(page.width_mm, page.height_mm),
        paper=style.paper,
        dpi=dpi,
        settings={**size_settings(style), "hatch.linewidth": 0.45 * style.line_pt},
    )


def draw_log(
    figure: Figure, log: BedLog, page: LogPage, description: str, is_metric: bool, style: NetStyle
) -> Axes:
    """Draw a log on a page-sized figure; axes are in mm from the base of the column."""
    ax = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    ax.set_xlim(-_LEFT_MM, page.width_mm - _LEFT_MM)
    ax.set_ylim(page.base_mm, page.highest_mm + _TOP_MM)
    ax.set_axis_off()
    styles = _bed_styles(log)
    for interval, appearance, row in zip(log.intervals, styles, page.label_heights_mm, strict=True):
        low, high = (1000.0 * value / page.scale for value in (interval.base_m, interval.top_m))
        _draw_bed(ax, low, high, appearance, style)
        if np.isfinite(row):
            _write_bed(ax, interval, 0.5 * (low + high), float(row), appearance, style)
    _draw_heights(ax, page, is_metric, style)
    _draw_notes(ax, page.lowest_mm, styles, style)
    _write_headings(ax, log, page, description, is_metric, style)
    return ax


def _draw_bed(
    ax: Axes, low: float, high: float, appearance: LithologyStyle, style: NetStyle
) -> None:
    from matplotlib.patches import Rectangle

    width = _COLUMN_MM * (DEFAULT_WIDTH if appearance.width is None else appearance.width)
    bed = Rectangle(
        (0.0, low),
        width,
        high - low,
        facecolor=style.color(appearance.color),
        edgecolor=style.soft,
        hatch=appearance.hatch or None,
        linewidth=0.0,
        zorder=1,
    )
    ax.add_patch(bed)
    if appearance.ornament == "cross":
        for ends in ((low, high), (high, low)):
            ax.plot([0.0, width], ends, color=style.soft, linewidth=0.6 * style.line_pt, zorder=2)
    elif appearance.ornament:
        _draw_bricks(ax, bed, width, low, high, appearance.ornament == "slanting bricks", style)
    line_options: dict[str, Any] = {"color": style.ink, "linewidth": style.line_pt, "zorder": 3}
    ax.plot([0.0, 0.0], [low, high], **line_options)
    for position in (low, high):
        ax.plot([0.0, width], [position, position], **line_options)
    ax.plot(
        [width, width],
        [low, high],
        linestyle="--" if appearance.width is None else "-",
        **line_options,
    )


def _draw_bricks(
    ax: Axes, bed: object, width: float, low: float, high: float, is_slanting: bool, style: NetStyle
) -> None:
    from matplotlib.collections import LineCollection

    length, course = _BRICK_MM
    course = min(course, max(high - low, 0.2))
    lines: list[list[tuple[float, float]]] = []
    for k in range(math.ceil((high - low) / course)):
        course_base, course_top = low + k * course, min(low + (k + 1) * course, high)
        lines.append([(0.0, course_base), (width, course_base)])
        slant = 0.6 * (course_top - course_base) if is_slanting else 0.0
        x = 0.5 * length if k % 2 else length
        while x < width + length:
            lines.append([(x - slant, course_base), (x + slant, course_top)])
            x += length
    brick_lines = LineCollection(lines, colors=style.soft, linewidths=0.5 * style.line_pt, zorder=2)
    ax.add_collection(brick_lines, autolim=False)
    brick_lines.set_clip_path(bed)  # type: ignore[arg-type]


def _write_bed(
    ax: Axes,
    interval: Interval,
    middle: float,
    row: float,
    appearance: LithologyStyle,
    style: NetStyle,
) -> None:
    width = _COLUMN_MM * (DEFAULT_WIDTH if appearance.width is None else appearance.width)
    x_start = _COLUMN_MM + 2.0
    ax.plot(
        [width + 0.8, x_start, _THICKNESS_MM - _LEFT_MM - 1.0],
        [middle, middle, row],
        color=style.soft,
        linewidth=0.4 * style.line_pt,
        zorder=0,
    )
    thickness = interval.thickness_m
    lines = (
        (_THICKNESS_MM, format_with_error(thickness.value, thickness.error95)),
        (_LITHOLOGY_MM, _shorten(interval.lithology.replace("_", " "), _MAX_LITHOLOGY_LENGTH)),
        (_NOTES_MM, _shorten(interval.notes, _MAX_NOTES_LENGTH)),
    )
    for position, text in lines:
        ax.text(
            position - _LEFT_MM,
            row,
            text,
            ha="left",
            va="center",
            color=style.ink,
            fontsize=0.95 * style.font_pt,
            parse_math=False,
        )


def _draw_heights(ax: Axes, page: LogPage, is_metric: bool, style: NetStyle) -> None:
    """Draw the height axis with ticks at round values."""
    line_options: dict[str, Any] = {
        "color": style.ink,
        "linewidth": style.line_pt,
        "clip_on": False,
    }
    ax.plot([-3.0, -3.0], [0.0, page.column_height_mm], **line_options)
    step = _round_up(0.001 * page.scale * 8.0)
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    count = math.floor(0.001 * page.column_height_mm * page.scale / step + 1e-9)
    for k in range(count + 1):
        y = 1000.0 * k * step / page.scale
        ax.plot([-4.5, -3.0], [y, y], **line_options)
        ax.text(
            -5.2,
            y,
            f"{k * step:.{decimals}f}",
            ha="right",
            va="center",
            color=style.ink,
            fontsize=0.9 * style.font_pt,
        )
    label = tr("height above the oldest boundary ({unit})", unit="m" if is_metric else tr("units"))
    if page.column_height_mm < 60.0:
        label = tr("height ({unit})", unit="m" if is_metric else tr("units"))
    ax.text(
        -_LEFT_MM + 2.0,
        0.5 * page.column_height_mm,
        label,
        rotation=90,
        ha="left",
        va="center",
        color=style.ink,
        fontsize=style.font_pt,
    )


def _draw_notes(ax: Axes, low: float, styles: Sequence[LithologyStyle], style: NetStyle) -> None:
    """Draw the grain sizes below the column, and explain classes and dashed edges."""
    down = low - 3.0
    note_style: dict[str, Any] = {"va": "top", "color": style.ink, "fontsize": 0.8 * style.font_pt}
    for part in _legend_parts(styles):
        if part in ("grains", "dunham"):
            names = GRAIN_SIZES if part == "grains" else tuple(DUNHAM_CLASSES)
            ends = _COLUMN_MM * np.arange(1, len(names) + 1) / len(names)
            ax.plot([0.0, _COLUMN_MM], [down, down], color=style.ink, linewidth=0.6 * style.line_pt)
            for end, name in zip(ends.tolist(), names, strict=True):
                ax.plot(
                    [end, end], [down, down - 1.0], color=style.ink, linewidth=0.6 * style.line_pt
                )
                ax.text(end, down - 1.4, tr(name), ha="center", **note_style)
        elif part == "classes":
            classes = ", ".join(f"{key} {tr(name)}" for key, name in DUNHAM_CLASSES.items())
            ax.text(0.0, down, classes, ha="left", **note_style)
        else:
            ax.text(0.0, down, tr("Dashed edge: grain size unknown"), ha="left", **note_style)
        down -= _NOTE_ROW_MM


def _write_headings(
    ax: Axes, log: BedLog, page: LogPage, description: str, is_metric: bool, style: NetStyle
) -> None:
    unit = "m" if is_metric else tr("units")
    heads = [(_THICKNESS_MM, tr("thickness ({unit})", unit=unit))]
    if any(interval.lithology for interval in log.intervals):
        heads.append((_LITHOLOGY_MM, tr("lithology")))
    if any(interval.notes for interval in log.intervals):
        heads.append((_NOTES_MM, tr("notes")))
    for position, text in heads:
        ax.text(
            position - _LEFT_MM,
            page.highest_mm + 3.0,
            text,
            ha="left",
            va="bottom",
            color=style.ink,
            fontsize=style.font_pt,
            weight="bold",
        )
    scale = tr("1 : {scale}", scale=f"{page.scale:g}") if is_metric else tr("to scale")
    thickness_text = (
        tr("true thickness across the bedding, ± 95 %")
        if log.total_m.error95 is not None
        else tr("true thickness across the bedding")
    )
    ax.text(
        -_LEFT_MM + 2.0,
        page.highest_mm + _TOP_MM - 2.5,
        f"{scale}; {thickness_text}",
        ha="left",
        va="top",
        color=style.ink,
        fontsize=style.font_pt,
    )
    if description:
        ax.text(
            -_LEFT_MM + 2.0,
            page.highest_mm + _TOP_MM - 6.5,
            description,
            ha="left",
            va="top",
            color=style.ink,
            fontsize=0.9 * style.font_pt,
            parse_math=False,
        )


def _shorten(text: str, max_length: int) -> str:
    text = " ".join(text.split())
    return text if len(text) <= max_length else f"{text[: max_length - 1]}…"


def _round_up(value: float) -> float:
    """Return the smallest 1, 2 or 5 times a power of ten that is not less than the value."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(s * power for s in (1.0, 2.0, 5.0, 10.0) if s * power >= value * (1.0 - 1e-9))


def _spread(targets: Sequence[float], distance: float) -> FloatArray:
    """Move positions apart to a minimum distance, minimising the sum of squared shifts.

    The solution is found by pooling adjacent violators.
    """
    blocks: list[tuple[float, int]] = []
    for i, target in enumerate(targets):
        position_sum, count = target - i * distance, 1
        while blocks and blocks[-1][0] / blocks[-1][1] >= position_sum / count:
            previous_sum, previous_count = blocks.pop()
            position_sum, count = position_sum + previous_sum, count + previous_count
        blocks.append((position_sum, count))
    block_means = np.repeat([t / c for t, c in blocks], [c for _, c in blocks])
    return np.asarray(block_means + distance * np.arange(len(targets)), np.float64)
