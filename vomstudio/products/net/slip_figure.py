"""Figure of fault slip: faults with arrows, P and T axes, and kinematic axes.

The left net shows the great circles of the faults, with the movement of the hanging wall at the
striae (outward: normal, inward: reverse), after Angelier (1979). The right net shows the P and T
axes and the kinematic axes. Its shading is the share of faults for which a direction lies in the
compressional dihedra (right dihedra method).
"""

from __future__ import annotations

from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import tr, tr_n
from vomstudio.geology import stereonet as nets
from vomstudio.geology.faults.kinematics import compressed_share, fault_movements, p_axes, t_axes
from vomstudio.geology.faults.table_slip import SlipRows, TableSlip
from vomstudio.geology.notation import format_azimuth
from vomstudio.geology.orientation import lines_to_vectors
from vomstudio.products.net.plain_net import FONT_PT, INK, SOFT, draw_frame, save_figure
from vomstudio.products.net.slip_arrows import draw_slip_arrows

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIZE_MM = (170.0, 112.0)
MAX_FAULTS = 300
"""Maximum number of great circles and arrows; larger sets are thinned evenly."""
_FAULT, _ARROW, _P, _T = "#8a8f98", "#c1440e", "#0072B2", "#D55E00"
_GRID, _FINE_GRID, _FEW_FAULTS = 241, 721, 60
"""Coarse and fine grid sizes for the dihedra; below this number of faults, fine is used."""
_LEVELS = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
_SHADES = ("#ffffff", "#eef2f6", "#d7e2ec", "#b9cfe0", "#94b7d1")


def write_slip_figure(
    target: str | Path | IO[bytes],
    table: SlipRows,
    slip: TableSlip,
    *,
    format: str,
    size_mm: tuple[float, float] = SIZE_MM,
    dpi: float = 300.0,
) -> None:
    """Write the figure as SVG, PDF or PNG.

    Raises
    ------
    UsageError
        If the format is not supported.
    """
    save_figure(target, lambda figure: draw_slip(figure, table, slip), format, size_mm, dpi)


def draw_slip(figure: Figure, table: SlipRows, slip: TableSlip) -> tuple[Axes, Axes]:
    """Draw both nets over the whole figure, after clearing it."""
    figure.clear()
    normals, slips = fault_movements(table.dip_direction_deg, table.dip_deg, table.slip_rake_deg)
    left_axes = figure.add_axes((0.01, 0.12, 0.48, 0.86))
    right_axes = figure.add_axes((0.51, 0.12, 0.48, 0.86))
    for ax in (left_axes, right_axes):
        ax.set_xlim(-1.12, 1.12)
        ax.set_ylim(-1.4, 1.2)
    _faults(left_axes, table, normals, slips)
    _axes(right_axes, normals, slips, slip)
    figure.text(
        0.02,
        0.02,
        tr_n("{count} fault", "{count} faults", slip.n) + "; " + tr("equal area, lower hemisphere"),
        fontsize=FONT_PT,
        color=SOFT,
    )
    return left_axes, right_axes


def _faults(ax: Axes, table: SlipRows, normals: FloatArray, slips: FloatArray) -> None:
    from matplotlib.collections import LineCollection

    draw_frame(ax)
    rows = np.unique(np.linspace(0, len(normals) - 1, min(len(normals), MAX_FAULTS)).astype(int))
    arcs = nets.great_circles(table.dip_direction_deg[rows], table.dip_deg[rows])
    ax.add_collection(LineCollection(list(arcs), colors=_FAULT, linewidths=0.6, zorder=2))
    at = nets.project(slips[rows])
    moving = draw_slip_arrows(ax, at, slips[rows], color=_ARROW, width_pt=0.9, zorder=5)
    ax.plot(*at[~moving].T, linestyle="none", marker="o", markersize=3, color=_ARROW, zorder=5)
    caption = tr("Faults and movement of their hanging walls")
    if len(rows) < len(normals):
        caption += tr(" ({count} drawn)", count=len(rows))
    ax.text(-1.1, -1.14, caption, fontsize=FONT_PT, va="top", color=INK)


def _axes(ax: Axes, normals: FloatArray, slips: FloatArray, slip: TableSlip) -> None:
    rim = draw_frame(ax)
    side = np.linspace(-1.0, 1.0, _FINE_GRID if len(normals) <= _FEW_FAULTS else _GRID)
    x, y = np.meshgrid(side, side)
    radius = np.maximum(np.hypot(x, y), 1.0)
    points = np.stack([x / radius, y / radius], axis=-1).reshape(-1, 2) * (1.0 - 1e-9)
    share = compressed_share(nets.unproject(points), normals, slips).reshape(x.shape)
    shaded = ax.contourf(x, y, share, levels=list(_LEVELS), colors=list(_SHADES), zorder=1)
    shaded.set_clip_path(rim)
    size = float(np.interp(len(normals), [30, 500], [3.4, 1.6]))
    for vectors, color, marker in (
        (p_axes(normals, slips), _P, "o"),
        (t_axes(normals, slips), _T, "^"),
    ):
        ax.plot(
            *nets.project(vectors).T,
            linestyle="none",
            marker=marker,
            markersize=size,
            color=color,
            markeredgewidth=0.0,
            zorder=4,
        )
    mean = slip.kinematic_axes
    for axis, color, marker in (
        (mean.shortening, _P, "*"),
        (mean.intermediate, INK, "D"),
        (mean.extension, _T, "*"),
    ):
        vector = lines_to_vectors([axis.trend_deg], [axis.plunge_deg])
        ax.plot(
            *nets.project(vector).T,
            linestyle="none",
            marker=marker,
            color=color,
            zorder=7,
            markersize=11 if marker == "*" else 5,
            markeredgecolor="#ffffff",
            markeredgewidth=0.7,
        )
    _legend(ax, slip)


def _legend(ax: Axes, slip: TableSlip) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    mean = slip.kinematic_axes

    def format_axis(axis: Any) -> str:
        return f"{format_azimuth(axis.trend_deg)}/{axis.plunge_deg:02.0f}"

    def dot(color: str, marker: str, label: str, size: float = 4.0) -> Any:
        return Line2D(
            [], [], color=color, marker=marker, linestyle="none", markersize=size, label=label
        )

    entries = [
        dot(_P, "o", tr("P axes (shortening)")),
        dot(_T, "^", tr("T axes (extension)")),
        dot(_P, "*", tr("shortening {axis}", axis=format_axis(mean.shortening)), 8),
        dot(_T, "*", tr("extension {axis}", axis=format_axis(mean.extension)), 8),
        dot(INK, "D", tr("intermediate {axis}", axis=format_axis(mean.intermediate))),
        Patch(facecolor=_SHADES[-1], label=tr("compressed by over 80 % of faults")),
    ]
    ax.legend(
        handles=entries,
        loc="upper left",
        bbox_to_anchor=(-0.02, 0.11),
        ncols=2,
        frameon=False,
        fontsize=FONT_PT - 1,
        columnspacing=1.2,
        handletextpad=0.5,
        borderpad=0.0,
    )
