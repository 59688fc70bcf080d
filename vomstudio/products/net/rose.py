"""Rose diagrams as a figure: one rose for each set, all to the same scale."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING

import numpy as np

from vomstudio.errors import GeometryError
from vomstudio.geology.orientation import Array
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.roses import Rose, azimuths_of, rose_of, weights_of
from vomstudio.products.net.contents import OKABE_ITO
from vomstudio.products.net.style import PRINT, NetStyle, layer, mixed
from vomstudio.products.net.table_net import members_of
from vomstudio.products.net.written_figure import write_figure
from vomstudio.words import to_translate, tr

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLES = {
    "strike": to_translate("Strikes, both ends"),
    "dip-direction": to_translate("Dip directions"),
    "trend": to_translate("Trends"),
}
WIDTH_MM = 170.0
_ROOM = 1.25
"""Half the width of a rose's panel, in radii of the rose."""
_UP, _DOWN = 1.3, 1.14
"""From the middle of a rose to the upper and lower edge of its panel, in radii."""
_HEAD_MM, _FOOT_MM = 11.0, 9.0


@dataclass(frozen=True, eq=False)
class RoseContents:
    """of: one of `roses.ROSE_OF`; roses: by the name of their set; weight: the column that weights
    them, None for counts; by_area: the area of a petal is its share, else its length; empty: sets
    of which no row has an azimuth and a weight."""

    of: str
    roses: Mapping[str, Rose]
    weight: str | None = None
    by_area: bool = True
    empty: tuple[str, ...] = ()

    @property
    def bin_deg(self) -> float:
        return next(iter(self.roses.values())).bin_deg


def roses_of_table(
    table: OrientationRows,
    of: str,
    by: str | None = None,
    *,
    bin_deg: float = 10.0,
    weight: str | None = None,
    by_area: bool = True,
) -> RoseContents:
    """Of each set that has such azimuths. by, weight : name or number of a column; by None: `set`,
    else `kind`, else all. Raises UsageError for columns that are not there or no numbers."""
    azimuth = azimuths_of(table, of)
    weights = None if weight is None else weights_of(table, weight)
    wanted = table.is_plane if of != "trend" else ~table.is_plane
    roses, empty = {}, []
    for name, members in members_of(table, by).items():
        rows = np.array([i for i in members if wanted[i]], dtype=np.intp)
        if len(rows):
            w = None if weights is None else weights[rows]
            rose = rose_of(azimuth[rows], axial=of == "strike", bin_deg=bin_deg, weights=w)
            if rose.total > 0:
                roses[name] = rose
            else:
                empty.append(name)
    return RoseContents(of, roses, weight, by_area, tuple(empty))


def check_roses(contents: RoseContents, path: Path | None) -> None:
    """Raises GeometryError where there is nothing to draw."""
    if not contents.roses:
        raise GeometryError(
            tr("The table has no lines with a trend.")
            if contents.of == "trend"
            else tr("The table has no planes with a strike; of lines draw --of trend."),
            file=path,
            field="--of",
        )


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
    dpi: float = 300.0,
) -> None:
    """Writes the figure as svg, pdf or png (text stays text in svg and pdf)."""
    width, height = figure_size(contents)
    write_figure(
        target, lambda figure: draw_roses(figure, contents, style),
        format=format, size_mm=(25.4 * width, 25.4 * height), paper=style.paper, dpi=dpi,
    )  # fmt: skip


def figure_size(contents: RoseContents) -> tuple[float, float]:
    """Width and height in inches of a figure with all roses."""
    columns, side = _grid(len(contents.roses))
    rows = math.ceil(len(contents.roses) / columns)
    return WIDTH_MM / 25.4, (rows * (_tall(side) + _HEAD_MM) + _FOOT_MM) / 25.4


def _grid(count: int) -> tuple[int, float]:
    """Columns, and the width of a panel in mm."""
    columns = min(count, 3)
    return columns, min(WIDTH_MM / columns, 105.0)


def _tall(side: float) -> float:
    """Height of a rose's panel of this width."""
    return side * (_UP + _DOWN) / (2 * _ROOM)


def draw_roses(figure: Figure, contents: RoseContents, style: NetStyle = PRINT) -> list[Axes]:
    """The axes of each rose. In them north is up and the outermost ring has the radius 1."""
    columns, side = _grid(len(contents.roses))
    width, height = (25.4 * float(v) for v in figure.get_size_inches())
    rings = rings_of(max(float(r.shares.max()) for r in contents.roses.values()))
    figure.set_facecolor(style.paper)
    drawn = []
    for i, (name, rose) in enumerate(contents.roses.items()):
        row, column = divmod(i, columns)
        left = (width - columns * side) / 2 + column * side
        low = height - (row + 1) * (_tall(side) + _HEAD_MM)
        place = (left / width, low / height, side / width, _tall(side) / height)
        ax = figure.add_axes(place)
        ax.set_xlim(-_ROOM, _ROOM)
        ax.set_ylim(-_DOWN, _UP)
        ax.set_axis_off()
        color = style.color(OKABE_ITO[i % len(OKABE_ITO)])
        draw_rose(ax, rose, rings, contents.by_area, color, style)
        for above, text, weight in (
            (5.5, tr("{set} (n = {count:,})", set=name, count=rose.n), "bold"),
            (1.5, mean_words(rose), "normal"),
        ):
            figure.text(
                (left + side / 2) / width, (low + _tall(side) + above) / height, text,
                ha="center", va="bottom", fontsize=style.font_pt, weight=weight, color=style.ink,
                parse_math=False,
            )  # fmt: skip
        drawn.append(ax)
    figure.text(
        0.5, 0.45 * _FOOT_MM / height, _caption(contents), ha="center", va="center",
        fontsize=style.font_pt, color=style.soft, parse_math=False,
    )  # fmt: skip
    return drawn


def _caption(contents: RoseContents) -> str:
    title, step = tr(TITLES[contents.of]), f"{contents.bin_deg:g}"
    share = (
        tr("% of the number")
        if contents.weight is None
        else tr("% of the sum of {column}", column=contents.weight)
    )
    if contents.by_area:
        return tr("{title}; bins of {step}°; rings: {share}; areas are to scale",
                  title=title, step=step, share=share)  # fmt: skip
    return tr("{title}; bins of {step}°; rings: {share}; lengths are to scale",
              title=title, step=step, share=share)  # fmt: skip


def petal_radius(share: Array, outermost: float, by_area: bool) -> Array:
    """Of shares (k,), where the outermost ring has the radius 1."""
    return np.sqrt(share / outermost) if by_area else np.asarray(share / outermost)


def draw_rose(
    ax: Axes, rose: Rose, rings: list[float], by_area: bool, color: str, style: NetStyle
) -> None:
    """One rose, of radius 1 at its outermost ring, into axes that show a little more than that."""
    from matplotlib.patches import Circle, Polygon

    radii = petal_radius(np.array(rings), rings[-1], by_area)
    for radius in radii:
        last = radius == radii[-1]
        ring = Circle(
            (0, 0), float(radius), facecolor="none", edgecolor=style.ink if last else style.soft,
            linewidth=(1.25 if last else 0.5) * style.line_pt,
            zorder=layer("rim" if last else "ground"),
        )  # fmt: skip
        ax.add_patch(ring)
    for quarter in np.arange(0.0, 360.0, 90.0):
        ax.plot(*_ray(quarter, (0.0, 1.04)), color=style.soft, linewidth=0.5 * style.line_pt,
                zorder=layer("ground"))  # fmt: skip
    lengths = petal_radius(rose.shares, rings[-1], by_area)
    for i, length in enumerate(lengths):
        if length > 0:
            azimuth = np.radians(np.linspace(i, i + 1, 13) * rose.bin_deg)
            arc = length * np.stack([np.sin(azimuth), np.cos(azimuth)], axis=1)
            petal = Polygon(
                np.vstack([[0.0, 0.0], arc]), closed=True, facecolor=mixed(color, style.net, 0.25),
                edgecolor=style.outline(mixed(color, style.ink, 0.3)),
                linewidth=0.7 * style.line_pt, zorder=layer("poles"),
            )  # fmt: skip
            ax.add_patch(petal)
    if rose.mean_deg is not None:
        for end in (rose.mean_deg, rose.mean_deg + 180.0)[: 2 if rose.axial else 1]:
            ax.plot(*_ray(end, (1.0, 1.1)), color=style.ink, linewidth=3.0 * style.line_pt,
                    solid_capstyle="butt", zorder=layer("means"))  # fmt: skip
    ax.text(0.0, 1.13, "N", ha="center", va="bottom", fontsize=1.15 * style.font_pt,
            weight="bold", color=style.ink)  # fmt: skip
    place = _clearest(rose)
    for share, radius in zip(rings, radii, strict=True):
        x, y = _ray(place, (float(radius), float(radius)))
        label = ax.text(
            x[0], y[0], f"{100 * share:g} %", ha="center", va="center",
            fontsize=0.9 * style.font_pt, color=style.ink, zorder=layer("words"),
        )  # fmt: skip
        label.set_bbox({"facecolor": style.net, "edgecolor": "none", "pad": 0.6, "alpha": 0.85})


def _clearest(rose: Rose) -> float:
    """Azimuth beside north or south where the petals are shortest: figures that stand there, one
    over the other, do not meet."""
    tried = np.array([30.0, 330.0, 150.0, 210.0, 20.0, 340.0, 160.0, 200.0, 40.0, 320.0])
    span = np.arange(-15.0, 16.0, 1.0)
    bins = ((tried[:, None] + span) % 360.0 // rose.bin_deg).astype(np.intp)
    longest = rose.shares[bins % len(rose.shares)].max(axis=1)
    return float(tried[int(np.argmin(np.round(longest, 9)))])


def mean_words(rose: Rose) -> str:
    """The mean of a rose for people."""
    if rose.mean_deg is None:
        return tr("no mean")
    one = f"{round(rose.mean_deg) % 360:03d}"
    if rose.axial:
        one = f"{round(rose.mean_deg) % 180:03d}-{round(rose.mean_deg) % 180 + 180:03d}"
    return tr("mean {azimuth}, R̄ {length:.2f}", azimuth=one, length=rose.resultant)


def _ray(azimuth_deg: float, radii: tuple[float, float]) -> tuple[list[float], list[float]]:
    a = math.radians(azimuth_deg)
    return [r * math.sin(a) for r in radii], [r * math.cos(a) for r in radii]
