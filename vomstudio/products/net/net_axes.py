"""Axes of mplstereonet, on which every net is drawn.

The axes project longitude and latitude (see `vomstudio.geology.stereonet`); this module draws
directions on them. The library and matplotlib are imported on first use.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geology import stereonet as nets
from vomstudio.products.net.style import NetStyle, layer

if TYPE_CHECKING:
    from matplotlib.collections import LineCollection
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.transforms import Transform

UNIT_RANGE = (-1.0, 1.0)
NORTH_HEIGHT_LETTERS, NORTH_SIZE = 1.5, 1.15
"""Height of the centre of the letter N above the circle, and its size, in font sizes."""


@cache
def import_mplstereonet() -> Any:
    """Import mplstereonet, which registers its axes with matplotlib."""
    with warnings.catch_warnings():
        # The library was written for an older version of matplotlib.
        warnings.simplefilter("ignore")
        import mplstereonet

    return mplstereonet


def is_stereonet_axes(ax: Any) -> bool:
    """Return whether axes are those of mplstereonet.

    Parameters
    ----------
    ax : object

    Returns
    -------
    bool
    """
    return isinstance(ax, import_mplstereonet().StereonetAxes)


def add_net(
    figure: Figure,
    box: tuple[float, float, float, float],
    style: NetStyle,
    projection: str = "area",
    *,
    x_radii: tuple[float, float] = UNIT_RANGE,
    y_radii: tuple[float, float] = UNIT_RANGE,
    north: str = "N",
) -> Any:
    """Add axes of a net with circle, ticks every 10 degrees, centre and north.

    Parameters
    ----------
    figure : Figure
    box : (float, float, float, float)
        Area that the net fills: left and lower edge, width and height, as shares of the figure.
    style : NetStyle
    projection : {"area", "angle"}, optional
    x_radii, y_radii : (float, float), optional
        Limits of the area, in radii from the centre of the net.
    north : str, optional
        Text over the tick of the azimuth 0.
    """
    import_mplstereonet()
    x_left, y_low, width, height = box
    columns, rows = (float(side) for side in figure.get_size_inches())
    radius = min(width * columns / np.ptp(x_radii), height * rows / np.ptp(y_radii))
    cx = (x_left + width / 2) * columns - radius * sum(x_radii) / 2
    cy = (y_low + height / 2) * rows - radius * sum(y_radii) / 2
    ax = figure.add_axes(
        (
            (cx - radius) / columns,
            (cy - radius) / rows,
            2 * radius / columns,
            2 * radius / rows,
        ),
        projection=f"equal_{projection}_stereonet",
        facecolor=style.net,
    )
    axes: Any = ax
    axes.set_azimuth_ticks([])
    axes.xaxis.set_visible(False)
    axes.yaxis.set_visible(False)
    axes.spines["geo"].set(color=style.ink, linewidth=1.25 * style.line_pt, zorder=layer("rim"))
    letter = style.font_pt / (72.0 * radius)
    _draw_ticks(axes, style, letter)
    if north:
        axes.text(
            0.0,
            1.0 + NORTH_HEIGHT_LETTERS * letter,
            north,
            ha="center",
            va="center_baseline",
            fontsize=NORTH_SIZE * style.font_pt,
            weight="bold",
            color=style.ink,
            transform=plane_transform(axes),
            zorder=layer("words"),
        )
    return axes


def _draw_ticks(ax: Any, style: NetStyle, letter: float) -> None:
    """Draw the ticks and the cross; `letter` is the height of a letter in radii."""
    from matplotlib.collections import LineCollection

    azimuth = np.radians(np.arange(0, 360, 10))
    unit = np.stack([np.sin(azimuth), np.cos(azimuth)], axis=1)
    length = np.where(np.arange(36) % 9 == 0, 0.6, 0.3)[:, None] * letter
    tick_length = 0.35 * letter
    ticks = [*np.stack([unit, unit * (1 + length)], axis=1)]
    ticks += [
        np.array([[-tick_length, 0], [tick_length, 0]]),
        np.array([[0, -tick_length], [0, tick_length]]),
    ]
    ax.add_collection(
        LineCollection(
            ticks,
            colors=style.ink,
            linewidths=style.line_pt,
            zorder=layer("ticks"),
            transform=plane_transform(ax),
            clip_on=False,
        ),
        autolim=False,
    )


def plane_transform(ax: Any) -> Transform:
    """Return the transform from positions in the unit circle to display coordinates.

    It is used for symbols that do not represent a direction.

    Parameters
    ----------
    ax : object

    Returns
    -------
    Transform
    """
    from matplotlib.transforms import Affine2D

    transform: Transform = Affine2D().translate(1.0, 1.0).scale(0.5) + ax.transAxes
    return transform


def unit_positions(ax: Any, vectors: FloatArray) -> FloatArray:
    """Return the projected positions (n, 2) of directions (n, 3) in the unit circle.

    Parameters
    ----------
    ax : object
    vectors : ndarray of float

    Returns
    -------
    ndarray of float
    """
    to_axes = ax.transProjection + ax.transAffine
    return np.asarray(2.0 * to_axes.transform(nets.vectors_to_longitude_latitude(vectors)) - 1.0)


def plot_vectors(ax: Any, vectors: FloatArray, *, flip: bool = True, **look: Any) -> Line2D:
    """Plot unit vectors (n, 3) as symbols, or as a curve on the lower hemisphere.

    Symbols at the rim are drawn whole. With `flip`, vectors that point upwards are plotted at
    their lower end. Curves must not be flipped: their ends are horizontal except for rounding.

    Parameters
    ----------
    ax : object
    vectors : ndarray of float
    flip : bool
    **look : object

    Returns
    -------
    Line2D
    """
    positions = nets.vectors_to_longitude_latitude(vectors, flip=flip)
    (line,) = ax.plot(*positions.T, **({"clip_on": False} | look))
    return line  # type: ignore[no-any-return]


def plot_polylines(
    ax: Any, parts: Sequence[FloatArray], *, label: str = "", **look: Any
) -> list[Line2D]:
    """Plot the parts (k, 3) of one curve on the lower hemisphere; the first one has the label.

    Parameters
    ----------
    ax : object
    parts : sequence of ndarray of float
    label : str
    **look : object

    Returns
    -------
    list of Line2D
    """
    return [
        plot_vectors(ax, part, flip=False, label=label if i == 0 else "", **look)
        for i, part in enumerate(parts)
    ]


def plot_curves(ax: Any, curves: Sequence[FloatArray] | FloatArray, **look: Any) -> LineCollection:
    """Plot many curves (k, 3) on the lower hemisphere as one collection.

    All curves are projected together, because matplotlib would project them one by one.

    Parameters
    ----------
    ax : object
    curves : sequence of ndarray of float or ndarray of float
    **look : object

    Returns
    -------
    LineCollection
    """
    from matplotlib.collections import LineCollection

    ends = np.cumsum([len(curve) for curve in curves], dtype=np.intp)[:-1]
    vectors = np.concatenate([np.zeros((0, 3)), *curves])
    positions = nets.vectors_to_longitude_latitude(vectors, flip=False)
    lines = LineCollection(
        np.split(ax.transProjection.transform(positions), ends),
        transform=ax.transAffine + ax.transAxes,
        **({"clip_on": False} | look),
    )
    return ax.add_collection(lines, autolim=False)  # type: ignore[no-any-return]
