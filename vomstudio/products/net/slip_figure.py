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
from vomstudio.products.net.figure_file import write_figure
from vomstudio.products.net.net_axes import add_net, plane_transform, plot_curves, plot_vectors
from vomstudio.products.net.slip_arrows import draw_slip_arrows
from vomstudio.products.net.style import PRINT

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIZE_MM = (170.0, 112.0)
MAX_FAULTS = 300
"""Maximum number of great circles and arrows; larger sets are thinned evenly."""
_FAULT_COLOR, _ARROW_COLOR, _P_COLOR, _T_COLOR = "#8a8f98", "#c1440e", "#0072B2", "#D55E00"
_GRID_SIZE, _FINE_GRID_SIZE, _MAX_FINE_FAULTS = 215, 641, 60
"""Coarse and fine grid sizes for the dihedra, and maximum number of faults for the fine grid."""
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
    write_figure(
        target,
        lambda figure: draw_slip(figure, table, slip),
        format=format,
        size_mm=size_mm,
        paper=PRINT.paper,
        dpi=dpi,
    )


def draw_slip(figure: Figure, table: SlipRows, slip: TableSlip) -> tuple[Any, Any]:
    """Draw both nets over the whole figure, after clearing it, and return their axes."""
    figure.clear()
    normals, slips = fault_movements(table.dip_direction_deg, table.dip_deg, table.slip_rake_deg)
    left_axes, right_axes = (
        add_net(
            figure, (x_left, 0.12, 0.48, 0.86), PRINT, x_radii=(-1.12, 1.12), y_radii=(-1.4, 1.2)
        )
        for x_left in (0.01, 0.51)
    )
    _draw_faults(left_axes, table, normals, slips)
    _draw_axes(right_axes, normals, slips, slip)
    figure.text(
        0.02,
        0.02,
        tr_n("{count} fault", "{count} faults", slip.n) + "; " + tr("equal area, lower hemisphere"),
        fontsize=PRINT.font_pt,
        color=PRINT.soft,
    )
    return left_axes, right_axes


def _draw_faults(ax: Any, table: SlipRows, normals: FloatArray, slips: FloatArray) -> None:
    rows = np.unique(np.linspace(0, len(normals) - 1, min(len(normals), MAX_FAULTS)).astype(int))
    arcs = nets.great_circles(table.dip_direction_deg[rows], table.dip_deg[rows])
    plot_curves(ax, arcs, colors=_FAULT_COLOR, linewidths=0.6, zorder=2)
    is_moving = draw_slip_arrows(
        ax, slips[rows], slips[rows], color=_ARROW_COLOR, width_pt=0.9, zorder=5
    )
    dot_style: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 3, "zorder": 5}
    plot_vectors(ax, slips[rows][~is_moving], color=_ARROW_COLOR, **dot_style)
    caption = tr("Faults and movement of their hanging walls")
    if len(rows) < len(normals):
        caption += tr(" ({count} drawn)", count=len(rows))
    ax.text(
        -1.1,
        -1.14,
        caption,
        fontsize=PRINT.font_pt,
        va="top",
        color=PRINT.ink,
        transform=plane_transform(ax),
    )


def _draw_axes(ax: Any, normals: FloatArray, slips: FloatArray, slip: TableSlip) -> None:
    size = _FINE_GRID_SIZE if len(normals) <= _MAX_FINE_FAULTS else _GRID_SIZE
    steps, positions = nets.hemisphere_grid(size)
    shares = compressed_share(positions.reshape(-1, 3), normals, slips).reshape(size, size)
    ax.contourf(steps, steps, shares, levels=list(_LEVELS), colors=list(_SHADES), zorder=1)
    marker_pt = float(np.interp(len(normals), [30, 500], [3.4, 1.6]))
    for vectors, color, marker in (
        (p_axes(normals, slips), _P_COLOR, "o"),
        (t_axes(normals, slips), _T_COLOR, "^"),
    ):
        plot_vectors(
            ax,
            vectors,
            linestyle="none",
            marker=marker,
            markersize=marker_pt,
            color=color,
            markeredgewidth=0.0,
            zorder=4,
        )
    mean = slip.kinematic_axes
    for axis, color, marker in (
        (mean.shortening, _P_COLOR, "*"),
        (mean.intermediate, PRINT.ink, "D"),
        (mean.extension, _T_COLOR, "*"),
    ):
        plot_vectors(
            ax,
            lines_to_vectors([axis.trend_deg], [axis.plunge_deg]),
            linestyle="none",
            marker=marker,
            color=color,
            zorder=7,
            markersize=11 if marker == "*" else 5,
            markeredgecolor="#ffffff",
            markeredgewidth=0.7,
        )
    _draw_legend(ax, slip)


def _draw_legend(ax: Any, slip: TableSlip) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    mean = slip.kinematic_axes

    def format_axis(axis: Any) -> str:
        return f"{format_azimuth(axis.trend_deg)}/{axis.plunge_deg:02.0f}"

    def create_symbol(color: str, marker: str, label: str, size: float = 4.0) -> Any:
        return Line2D(
            [], [], color=color, marker=marker, linestyle="none", markersize=size, label=label
        )

    entries = [
        create_symbol(_P_COLOR, "o", tr("P axes (shortening)")),
        create_symbol(_T_COLOR, "^", tr("T axes (extension)")),
        create_symbol(_P_COLOR, "*", tr("shortening {axis}", axis=format_axis(mean.shortening)), 8),
        create_symbol(_T_COLOR, "*", tr("extension {axis}", axis=format_axis(mean.extension)), 8),
        create_symbol(
            PRINT.ink, "D", tr("intermediate {axis}", axis=format_axis(mean.intermediate))
        ),
        Patch(facecolor=_SHADES[-1], label=tr("compressed for over 80 % of faults")),
    ]
    ax.legend(
        handles=entries,
        loc="upper left",
        bbox_to_anchor=(-1.165, -1.114),
        bbox_transform=plane_transform(ax),
        ncols=2,
        frameon=False,
        fontsize=PRINT.font_pt - 1,
        columnspacing=1.2,
        handletextpad=0.5,
        borderpad=0.0,
    )
