"""Rose diagrams and histograms of dip as a figure: one for each set, all to the same scale."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING

import numpy as np

from vomstudio.core.words import to_translate, tr
from vomstudio.geology.roses import HISTOGRAM_OF, Histogram, Rose
from vomstudio.products.net.contents import OKABE_ITO
from vomstudio.products.net.figure_file import font_of, write_figure
from vomstudio.products.net.legend import shortened, text_width, wrapped
from vomstudio.products.net.rose_contents import RoseContents
from vomstudio.products.net.rose_drawing import (
    CEILING,
    FLOOR,
    LEFT,
    RIGHT,
    draw_histogram,
    draw_rose,
    petal_radius,
)
from vomstudio.products.net.style import PRINT, NetStyle

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLES = {
    "strike": to_translate("Strikes, both ends"),
    "dip-direction": to_translate("Dip directions"),
    "trend": to_translate("Trends"),
    "dip": to_translate("Dips"),
    "plunge": to_translate("Plunges"),
}
WIDTH_MM = 170.0
_ROOM = 1.25
"""Half the width of a rose's panel, in radii of the rose."""
_UP, _DOWN = 1.3, 1.14
"""From the middle of a rose to the upper and lower edge of its panel, in radii."""
_HEAD, _FOOT = 3.9, 3.2
"""Height over each panel and under all of them, in letters."""
_WIDEST_MM = 105.0


def rings_of(top: float) -> list[float]:
    """Two or three round shares, the last one not below the largest petal."""
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
    """Writes the figure as svg, pdf or png (text stays text in svg and pdf)."""
    width, height = figure_size(contents, style, width_mm)
    write_figure(
        target,
        lambda figure: draw_roses(figure, contents, style),
        format=format,
        size_mm=(25.4 * width, 25.4 * height),
        paper=style.paper,
        dpi=dpi,
        settings=font_of(style),
    )


def figure_size(
    contents: RoseContents, style: NetStyle = PRINT, width_mm: float = WIDTH_MM
) -> tuple[float, float]:
    """Width and height in inches of a figure with all roses."""
    columns = min(len(contents.roses), 3)
    side = min(width_mm / columns, _WIDEST_MM)
    rows = math.ceil(len(contents.roses) / columns)
    letter = style.font_pt / 72.0 * 25.4
    foot = _FOOT * letter + 1.45 * letter * (len(contents.notes) + bool(contents.title))
    return width_mm / 25.4, (rows * (_tall(side) + _HEAD * letter) + foot) / 25.4


def _tall(side: float) -> float:
    """Height of a rose's panel of this width."""
    return side * (_UP + _DOWN) / (2 * _ROOM)


@dataclass(frozen=True)
class _Grid:
    """Columns, and the width of a panel."""

    columns: int
    side: float

    @classmethod
    def of(cls, count: int, width: float, height: float, head: float, foot: float) -> _Grid:
        """The largest panels that have room."""
        best = cls(1, 0.0)
        for columns in range(1, count + 1):
            rows = math.ceil(count / columns)
            tall = (height - foot) / rows - head
            side = min(width / columns, tall * 2 * _ROOM / (_UP + _DOWN))
            if side >= best.side - 1e-6:
                best = cls(columns, side)
        return cls(best.columns, max(best.side, 1.0))


@dataclass(eq=False)
class RoseArtists:
    """The drawn roses, and what a pointer needs to know of them. Pixels are matplotlib's display
    pixels: from the bottom left corner, y up."""

    axes: dict[str, Axes]
    contents: RoseContents
    rings: list[float]

    def features_at(self, x_px: float, y_px: float) -> tuple[str, ...]:
        """The ids of those that are counted in the petal or bar under a pixel."""
        for name, ax in self.axes.items():
            x, y = ax.transData.inverted().transform((x_px, y_px))
            counted = self.contents.counted.get(name)
            if counted is None or not (-_ROOM <= x <= _ROOM and -_DOWN <= y <= _UP):
                continue
            found = self.contents.roses[name]
            inside = self._bar(found, x, y) if isinstance(found, Histogram) else None
            if isinstance(found, Rose):
                inside = self._petal(found, x, y)
            if inside is None:
                return ()
            low, period = inside
            away = (counted.angles_deg + 1e-7 - low) % period
            if isinstance(found, Histogram) and low + found.bin_deg >= 90.0:
                away = np.where(counted.angles_deg >= low, 0.0, np.nan)
            rows = np.flatnonzero(away < found.bin_deg)
            return tuple(counted.ids[int(i)] for i in rows)
        return ()

    def _petal(self, rose: Rose, x: float, y: float) -> tuple[float, float] | None:
        """Lower edge of the petal at a place, and the period of its angles."""
        place = int((math.degrees(math.atan2(x, y)) % 360.0) // rose.bin_deg) % len(rose.shares)
        reach = petal_radius(rose.shares, self.rings[-1], self.contents.by_area)[place]
        if math.hypot(x, y) > float(reach):
            return None
        return place * rose.bin_deg, 180.0 if rose.axial else 360.0

    def _bar(self, found: Histogram, x: float, y: float) -> tuple[float, float] | None:
        place = math.floor((x - LEFT) / (RIGHT - LEFT) * 90.0 / found.bin_deg)
        if not 0 <= place < len(found.shares):
            return None
        top = FLOOR + (CEILING - FLOOR) * float(found.shares[place]) / self.rings[-1]
        return (place * found.bin_deg, 360.0) if FLOOR <= y <= top else None


def draw_roses(figure: Figure, contents: RoseContents, style: NetStyle = PRINT) -> RoseArtists:
    """Draws all that the contents hold, as large as the figure lets them. In the axes of a rose
    north is up and the outermost ring has the radius 1."""
    width, height = (72.0 * float(v) for v in figure.get_size_inches())
    font = style.font_pt
    figure.set_facecolor(style.paper)
    title = [contents.title] if contents.title else []
    foot = [*title, *contents.notes, *wrapped(_caption(contents), font, width - 2 * font)]
    under = (_FOOT + 1.45 * (len(foot) - 1)) * font
    grid = _Grid.of(len(contents.roses), width, height, _HEAD * font, under)
    side = min(grid.side, _WIDEST_MM / 25.4 * 72.0 if style is PRINT else grid.side)
    tall = _tall(side)
    rings = rings_of(max(float(r.shares.max()) for r in contents.roses.values()))
    drawn = {}
    for i, (name, rose) in enumerate(contents.roses.items()):
        row, column = divmod(i, grid.columns)
        left = (width - grid.columns * side) / 2 + column * side
        low = height - (row + 1) * (tall + _HEAD * font)
        ax = figure.add_axes((left / width, low / height, side / width, tall / height))
        ax.set_xlim(-_ROOM, _ROOM)
        ax.set_ylim(-_DOWN, _UP)
        ax.set_axis_off()
        known = contents.counted.get(name)
        usual = OKABE_ITO[i % len(OKABE_ITO)] if known is None else known.color
        color = style.color(contents.colors.get(name, usual))
        if isinstance(rose, Histogram):
            draw_histogram(ax, rose, rings, color, style)
        else:
            draw_rose(
                ax, rose, rings, contents.by_area, color, style, "N" if contents.north else "y"
            )
        said = mean_words(rose)
        fitting = font * min(1.0, max(0.7, 0.94 * side / text_width(said, font, "normal")))
        for above, text, weight, size in (
            (1.95, tr("{set} (n = {count:,})", set=name, count=rose.n), "bold", font),
            (0.53, said, "normal", fitting),
        ):
            figure.text(
                (left + side / 2) / width,
                (low + tall + above * font) / height,
                shortened(text, size, side, weight),
                ha="center",
                va="bottom",
                fontsize=size,
                weight=weight,
                color=style.ink,
                parse_math=False,
            )
        drawn[name] = ax
    for i, line in enumerate(reversed(foot)):
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
    return RoseArtists(drawn, contents, rings)


def _caption(contents: RoseContents) -> str:
    title, step = tr(TITLES[contents.of]), f"{contents.bin_deg:g}"
    share = (
        tr("% of the number")
        if contents.weight is None
        else tr("% of the sum of {column}", column=contents.weight)
    )
    if contents.of in HISTOGRAM_OF:
        return tr("{title}; bins of {step}°; heights: {share}", title=title, step=step, share=share)
    if contents.by_area:
        return tr(
            "{title}; bins of {step}°; rings: {share}; areas are to scale",
            title=title,
            step=step,
            share=share,
        )
    return tr(
        "{title}; bins of {step}°; rings: {share}; lengths are to scale",
        title=title,
        step=step,
        share=share,
    )


def mean_words(rose: Rose | Histogram) -> str:
    """The mean of a rose or histogram for people."""
    if isinstance(rose, Rose) and not rose.preferred and rose.rayleigh_p is not None:
        return tr("no preferred direction (Rayleigh p = {p})", p=f"{rose.rayleigh_p:.2g}")
    if rose.mean_deg is None:
        return tr("no mean")
    if isinstance(rose, Histogram):
        if rose.std_deg is None:
            return tr("mean {mean:.0f}°", mean=rose.mean_deg)
        return tr("mean {mean:.0f}°, s {spread:.0f}°", mean=rose.mean_deg, spread=rose.std_deg)
    one = f"{round(rose.mean_deg) % 360:03d}"
    if rose.axial:
        one = f"{round(rose.mean_deg) % 180:03d}-{round(rose.mean_deg) % 180 + 180:03d}"
    return tr("mean {azimuth}, R̄ {length:.2f}", azimuth=one, length=rose.resultant)
