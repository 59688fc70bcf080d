"""Plain net on matplotlib axes, for figures with several nets or with other panels."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.words import tr
from vomstudio.products.net.figure_file import write_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK, SOFT, PAPER = "#1a1a1a", "#7a7a7a", "#ffffff"
FONT_PT = 8.0


def save_figure(
    target: str | Path | IO[bytes],
    draw: Callable[[Figure], Any],
    format: str,
    size_mm: tuple[float, float],
    dpi: float,
) -> None:
    """Write a drawing as SVG, PDF or PNG; text remains editable.

    Raises
    ------
    UsageError
        If the format is not supported.
    """
    write_figure(target, draw, format=format, size_mm=size_mm, paper=PAPER, dpi=dpi)


def draw_frame(ax: Axes) -> Any:
    """Draw and return the primitive circle of radius 1, with north and 10 degree ticks."""
    from matplotlib.patches import Circle
    from matplotlib.patheffects import withStroke

    ax.set_aspect("equal")
    ax.set_axis_off()
    rim = Circle((0.0, 0.0), 1.0, facecolor="none", edgecolor=INK, linewidth=0.9, zorder=6)
    ax.add_patch(rim)
    for azimuth in range(0, 360, 10):
        angle = np.radians(azimuth)
        inner = 0.96 if azimuth % 90 == 0 else 0.98
        ends = np.outer([inner, 1.0], [np.sin(angle), np.cos(angle)])
        ax.plot(*ends.T, color=INK, linewidth=0.6, zorder=6)
    north = ax.text(0.0, 1.02, tr("N"), ha="center", va="bottom", fontsize=FONT_PT, color=INK)
    # Slip arrows near the rim extend beyond it.
    north.set_zorder(8)
    north.set_path_effects([withStroke(linewidth=2.5, foreground=PAPER)])
    return rim
