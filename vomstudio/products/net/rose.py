"""Figure of rose diagrams or dip histograms: one per set, all to the same scale."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING

import numpy as np

from vomstudio.core.words import to_translate, tr
from vomstudio.geology.roses import HISTOGRAM_ANGLES, AngleHistogram, Rose
from vomstudio.products.net.contents import OKABE_ITO
from vomstudio.products.net.figure_file import font_settings, write_figure
from vomstudio.products.net.legend import shorten_text, text_width, wrap_text
from vomstudio.products.net.rose_contents import RoseContents
from vomstudio.products.net.rose_drawing import (
    BOTTOM,
    LEFT,
    RIGHT,
    TOP,
    draw_histogram,
    draw_rose,
    petal_radii,
)
from vomstudio.products.net.style import PRINT, NetStyle
from vomstudio.project import catalogue

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLES = {
    "strike": to_translate("Strikes (bidirectional)"),
    "dip-direction": to_translate("Dip directions"),
    "trend": to_translate("Trends"),
    "dip": to_translate("Dips"),
    "plunge": to_translate("Plunges"),
}
WIDTH_MM = 170.0
_PANEL_HALF_WIDTH = 1.25
"""Half the width of the panel of a rose, in radii."""
_PANEL_TOP, _PANEL_BOTTOM = 1.3, 1.14
"""Distance of the upper and lower edges of a panel from the centre of the rose, in radii."""
_HEADER_LETTERS, _FOOTER_LETTERS = 3.9, 3.2
"""Height above each panel, and height below all panels, in letter heights."""
_LINE_LETTERS = 1.42
"""Distance of the lines above a panel, in letter heights."""
_MIN_TITLE_SIZE = 0.7
"""Minimum size of the texts above a rose relative to other texts; longer titles are wrapped."""
_MIN_PANEL_MM, _MAX_PANEL_MM = 42.0, 105.0


def choose_rings(top: float) -> list[float]:
    """Return two or three round shares for rings; the largest is at least `top`."""
    for step in (0.01, 0.02, 0.05, 0.1, 0.2, 0.25):
        count = math.ceil(top / step - 1e-9)
        if count <= 3:
            return [step * (i + 1) for i in range(max(count, 2))]
    return [0.5, 1.0]


def write_roses(
    target: str | Path | IO[bytes],
    contents: RoseContents,
    *,
    format: str,
    style: NetStyle = PRINT,
    width_mm: float = WIDTH_MM,
    dpi: float = 300.0,
) -> None:
    """Write the figure as SVG, PDF or PNG; text remains editable in SVG and PDF.

    Raises
    ------
    UsageError
        If the format is not supported.
    """
    width, height = figure_size(contents, style, width_mm)
    write_figure(
        target,
        lambda figure: draw_roses(figure, contents, style),
        format=format,
        size_mm=(25.4 * width, 25.4 * height),
        paper=style.paper,
        dpi=dpi,
        settings=font_settings(style),
    )


def figure_size(
    contents: RoseContents, style: NetStyle = PRINT, width_mm: float = WIDTH_MM
) -> tuple[float, float]:
    """Return the width and height of a figure with all roses, in inches."""
    columns = min(len(contents.roses), 3, max(1, int(width_mm / _MIN_PANEL_MM)))
    panel_mm = min(width_mm / columns, _MAX_PANEL_MM)
    rows = math.ceil(len(contents.roses) / columns)
    letter = style.font_pt / 72.0 * 25.4
    footer_height = _FOOTER_LETTERS * letter + 1.45 * letter * (
        len(contents.notes) + bool(contents.title)
    )
    header_letters = _header_letters(contents, style.font_pt, width_mm / columns / 25.4 * 72.0)
    return width_mm / 25.4, (
        rows * (_panel_height(panel_mm) + header_letters * letter) + footer_height
    ) / 25.4


def _header_lines(
    name: str, rose: Rose | AngleHistogram, font: float, width: float
) -> list[tuple[str, str]]:
    """Return the lines above a rose and their weights: its title and its mean."""
    title = tr("{set} (n = {count:,})", set=name, count=rose.n)
    header_lines = []
    for text, weight in ((title, "bold"), (describe_mean(rose), "normal")):
        lines = wrap_text(text, _MIN_TITLE_SIZE * font, 0.94 * width, weight)
        if len(lines) > 1:
            lines = wrap_text(text, font, 0.94 * width, weight)
        header_lines += [(line, weight) for line in lines]
    return header_lines


def _header_letters(contents: RoseContents, font: float, width: float) -> float:
    """Return the height of the texts above the panels, in letter heights."""
    n_lines = [len(_header_lines(name, rose, font, width)) for name, rose in contents.roses.items()]
    return _HEADER_LETTERS + _LINE_LETTERS * (max(n_lines, default=2) - 2)


def _panel_height(width: float) -> float:
    """Return the height of a panel of width `width`."""
    return width * (_PANEL_TOP + _PANEL_BOTTOM) / (2 * _PANEL_HALF_WIDTH)


@dataclass(frozen=True)
class _Grid:
    """Grid of panels: the number of columns, and the width of a panel."""

    columns: int
    panel_width: float

    @classmethod
    def of(cls, contents: RoseContents, font: float, width: float, height: float) -> _Grid:
        """Find the grid with the largest panels that fit below the texts above them."""
        best_grid, count = cls(1, 0.0), len(contents.roses)
        for columns in range(1, count + 1):
            rows, column_width = math.ceil(count / columns), width / columns
            if column_width < best_grid.panel_width:
                break
            panel_height = height / rows - _header_letters(contents, font, column_width) * font
            panel_width = min(
                column_width, panel_height * 2 * _PANEL_HALF_WIDTH / (_PANEL_TOP + _PANEL_BOTTOM)
            )
            if panel_width >= best_grid.panel_width - 1e-6:
                best_grid = cls(columns, panel_width)
        return cls(best_grid.columns, max(best_grid.panel_width, 1.0))


@dataclass(eq=False)
class RoseArtists:
    """Drawn roses, with the data needed for picking.

    Pixels are matplotlib's display pixels, counted from the bottom left corner with y up.
    """

    axes: dict[str, Axes]
    contents: RoseContents
    rings: list[float]

    def features_at(self, x_px: float, y_px: float) -> tuple[str, ...]:
        """Return the ids of the features in the petal or bar under a pixel."""
        for name, ax in self.axes.items():
            x, y = ax.transData.inverted().transform((x_px, y_px))
            counted_set = self.contents.counted_sets.get(name)
            if counted_set is None or not (
                -_PANEL_HALF_WIDTH <= x <= _PANEL_HALF_WIDTH and -_PANEL_BOTTOM <= y <= _PANEL_TOP
            ):
                continue
            rose = self.contents.roses[name]
            bin_range = self._bar_range(rose, x, y) if isinstance(rose, AngleHistogram) else None
            if isinstance(rose, Rose):
                bin_range = self._petal_range(rose, x, y)
            if bin_range is None:
                return ()
            low, period = bin_range
            angles = (counted_set.angles_deg + 1e-7 - low) % period
            if isinstance(rose, AngleHistogram) and low + rose.bin_deg >= 90.0:
                angles = np.where(counted_set.angles_deg >= low, 0.0, np.nan)
            rows = np.flatnonzero(angles < rose.bin_deg)
            return tuple(counted_set.ids[int(i)] for i in rows)
        return ()

    def _petal_range(self, rose: Rose, x: float, y: float) -> tuple[float, float] | None:
        """Return the lower edge of the petal at a position, and the period of the angles.

        Returns None outside the petal.
        """
        bin_index = int((math.degrees(math.atan2(x, y)) % 360.0) // rose.bin_deg) % len(rose.shares)
        petal_length = petal_radii(rose.shares, self.rings[-1], self.contents.is_area_scaled)[
            bin_index
        ]
        if math.hypot(x, y) > float(petal_length):
            return None
        return bin_index * rose.bin_deg, 180.0 if rose.axial else 360.0

    def _bar_range(
        self, histogram: AngleHistogram, x: float, y: float
    ) -> tuple[float, float] | None:
        bin_index = math.floor((x - LEFT) / (RIGHT - LEFT) * 90.0 / histogram.bin_deg)
        if not 0 <= bin_index < len(histogram.shares):
            return None
        top = BOTTOM + (TOP - BOTTOM) * float(histogram.shares[bin_index]) / self.rings[-1]
        return (bin_index * histogram.bin_deg, 360.0) if BOTTOM <= y <= top else None


def draw_roses(figure: Figure, contents: RoseContents, style: NetStyle = PRINT) -> RoseArtists:
    """Draw all roses, as large as the figure allows.

    In print, a panel is at most `_MAX_PANEL_MM` wide. In the axes of a rose, north is up and the
    outermost ring has radius 1.
    """
    width, height = (72.0 * float(v) for v in figure.get_size_inches())
    font = style.font_pt
    figure.set_facecolor(style.paper)
    title = [contents.title] if contents.title else []
    footer_lines = [*title, *contents.notes, *wrap_text(_caption(contents), font, width - 2 * font)]
    footer_height = (_FOOTER_LETTERS + 1.45 * (len(footer_lines) - 1)) * font
    grid = _Grid.of(contents, font, width, height - footer_height)
    panel_width = min(
        grid.panel_width, _MAX_PANEL_MM / 25.4 * 72.0 if style is PRINT else grid.panel_width
    )
    # Low panels are moved apart as far as the texts above them require.
    max_text_width = max(
        text_width(text, font, weight)
        for name, rose in contents.roses.items()
        for text, weight in _header_lines(name, rose, font, width / grid.columns)
    )
    column_width = min(max(panel_width, max_text_width / 0.94), width / grid.columns)
    header_height = _header_letters(contents, font, width / grid.columns) * font
    total_height = _panel_height(panel_width)
    rings = choose_rings(max(float(rose.shares.max()) for rose in contents.roses.values()))
    axes_by_name = {}
    for i, (name, rose) in enumerate(contents.roses.items()):
        row, column = divmod(i, grid.columns)
        x_centre = width / 2 + (column - (grid.columns - 1) / 2) * column_width
        x_left = x_centre - panel_width / 2
        y_low = height - (row + 1) * (total_height + header_height)
        ax = figure.add_axes(
            (x_left / width, y_low / height, panel_width / width, total_height / height)
        )
        _draw_panel(ax, contents, name, rings, style)
        header_lines = _header_lines(name, rose, font, width / grid.columns)
        for k, (text, weight) in enumerate(header_lines):
            baseline = 0.53 + _LINE_LETTERS * (len(header_lines) - 1 - k)
            ratio = 0.94 * column_width / text_width(text, font, weight)
            size = font * min(1.0, max(_MIN_TITLE_SIZE, ratio))
            figure.text(
                x_centre / width,
                (y_low + total_height + baseline * font) / height,
                shorten_text(text, size, column_width, weight),
                ha="center",
                va="bottom",
                fontsize=size,
                weight=weight,
                color=style.ink,
                parse_math=False,
            )
        axes_by_name[name] = ax
    for i, line in enumerate(reversed(footer_lines)):
        figure.text(
            0.5,
            (1.45 + 1.45 * i) * font / height,
            line,
            ha="center",
            va="center",
            fontsize=font,
            color=style.soft,
            parse_math=False,
        )
    return RoseArtists(axes_by_name, contents, rings)


def draw_single_rose(ax: Axes, contents: RoseContents, style: NetStyle = PRINT) -> None:
    """Draw the only rose of the contents on axes, with the title above and the caption below.

    Parameters
    ----------
    ax : Axes
        Rectangular axes; their scale is replaced by that of a rose.
    contents : RoseContents
        Contents with one rose.
    style : NetStyle
    """
    ((name, rose),) = contents.roses.items()
    _draw_panel(ax, contents, name, choose_rings(float(rose.shares.max())), style)
    ax.set_aspect("equal")
    font, ink = style.font_pt, style.ink
    title = tr("{set} (n = {count:,})", set=name, count=rose.n)
    ax.set_title(f"{title}\n{describe_mean(rose)}", fontsize=font, color=ink, parse_math=False)
    ax.text(
        0.5,
        -0.02,
        "\n".join([*contents.notes, *_caption(contents).split("; ")]),
        transform=ax.transAxes,
        ha="center",
        va="top",
        fontsize=font,
        color=style.soft,
        parse_math=False,
    )


def _draw_panel(
    ax: Axes, contents: RoseContents, name: str, rings: list[float], style: NetStyle
) -> None:
    ax.set_xlim(-_PANEL_HALF_WIDTH, _PANEL_HALF_WIDTH)
    ax.set_ylim(-_PANEL_BOTTOM, _PANEL_TOP)
    ax.set_axis_off()
    rose, counted_set = contents.roses[name], contents.counted_sets.get(name)
    panel_index = list(contents.roses).index(name)
    default_color = (
        OKABE_ITO[panel_index % len(OKABE_ITO)] if counted_set is None else counted_set.color
    )
    color = style.color(contents.colors.get(name, default_color))
    if isinstance(rose, AngleHistogram):
        draw_histogram(ax, rose, rings, color, style)
        return
    up = "N" if contents.north else "y"
    draw_rose(ax, rose, rings, contents.is_area_scaled, color, style, up)


def _caption(contents: RoseContents) -> str:
    title, step = tr(TITLES[contents.of]), f"{contents.bin_deg:g}"
    share_text = (
        tr("% of the total number")
        if contents.weight is None
        else tr("% of the total {quantity}", quantity=_quantity_title(contents.weight))
    )
    if contents.of in HISTOGRAM_ANGLES:
        return tr(
            "{title}; bins of {step}°; heights: {share}", title=title, step=step, share=share_text
        )
    if contents.is_area_scaled:
        return tr(
            "{title}; bins of {step}°; rings: {share}; petal areas to scale",
            title=title,
            step=step,
            share=share_text,
        )
    return tr(
        "{title}; bins of {step}°; rings: {share}; petal lengths to scale",
        title=title,
        step=step,
        share=share_text,
    )


def _quantity_title(column: str) -> str:
    """Return the title of an exported column, or the name of any other column."""
    titles = {
        figure.name: tr(figure.title).lower() for figure in (catalogue.EXTENT, catalogue.AREA)
    }
    return titles.get(column, column)


def describe_mean(rose: Rose | AngleHistogram) -> str:
    """Describe the mean of a rose or histogram."""
    if isinstance(rose, Rose) and not rose.has_preferred_direction and rose.rayleigh_p is not None:
        return tr("no preferred direction (Rayleigh p = {p})", p=f"{rose.rayleigh_p:.2g}")
    if rose.mean_deg is None:
        return tr("no mean")
    if isinstance(rose, AngleHistogram):
        if rose.std_deg is None:
            return tr("mean {mean:.0f}°", mean=rose.mean_deg)
        return tr("mean {mean:.0f}°, s {spread:.0f}°", mean=rose.mean_deg, spread=rose.std_deg)
    mean_text = f"{round(rose.mean_deg) % 360:03d}"
    if rose.axial:
        mean_text = f"{round(rose.mean_deg) % 180:03d}-{round(rose.mean_deg) % 180 + 180:03d}"
    return tr("mean {azimuth}, R̄ {length:.2f}", azimuth=mean_text, length=rose.resultant)
