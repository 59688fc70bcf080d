"""Figure of the shapes of point clouds to which planes were fitted.

It plots coplanarity against collinearity.

Coplanarity is 1 / l3 and collinearity is l1 / l2, where the eigenvalues l1 to l3 are normalised by
their sum (Tavani et al., eqs. 20 and 21, fig. 27). A spherical cloud plots at (1, 3). A rod plots
along the border l2 = l3, where the collinearity is the coplanarity minus two, and a sheet plots
high above collinearity 1.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.words import to_translate, tr
from vomstudio.geology.profiles import PROFILES_BY_NAME, Thresholds
from vomstudio.products.figure_layout import label_symbols
from vomstudio.products.net.figure_file import size_settings, write_figure
from vomstudio.products.net.style import PRINT, NetStyle

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIZE_MM = (120.0, 100.0)
_SYMBOLS = {
    "good": ("o", "#009E73", to_translate("good")),
    "doubtful": ("^", "#E69F00", to_translate("doubtful")),
    "poor": ("s", "#D55E00", to_translate("poor")),
    None: ("x", "#7a7a7a", to_translate("not assessed")),
}
_MAX_NAMES = 30


def write_shapes(
    target: str | Path | IO[bytes],
    rows: Sequence[Mapping[str, Any]],
    *,
    format: str,
    style: NetStyle = PRINT,
    dpi: float = 300.0,
) -> int:
    """Write the figure for rows of the orientation table.

    Returns the number of planes that have a shape.

    Raises
    ------
    UsageError
        If the format is not svg, pdf or png.
    """

    def draw(figure: Figure) -> int:
        return draw_shapes(figure.add_axes((0.13, 0.13, 0.83, 0.80)), rows, style)

    return write_figure(
        target,
        draw,
        format=format,
        size_mm=SIZE_MM,
        paper=style.paper,
        dpi=dpi,
        settings=size_settings(style),
    )


def draw_shapes(axes: Axes, rows: Sequence[Mapping[str, Any]], style: NetStyle = PRINT) -> int:
    """Draw symbols by verdict, name those that are not good, and return the symbol count."""
    finite_rows = [
        row for row in rows if _is_finite(row["coplanarity"]) and _is_finite(row["collinearity"])
    ]
    largest_value = max((float(row["coplanarity"]) for row in finite_rows), default=100.0)
    top = 10.0 ** math.ceil(math.log10(max(largest_value * 1.5, 100.0)))
    _draw_background(axes, top, style)
    for quality, (marker, color, name) in _SYMBOLS.items():
        group = [row for row in finite_rows if row.get("quality") == quality]
        if not group:
            continue
        axes.plot(
            [float(row["collinearity"]) for row in group],
            [float(row["coplanarity"]) for row in group],
            marker,
            color=style.color(color),
            markersize=style.marker_pt,
            linestyle="none",
            label=tr("{verdict} ({count})", verdict=tr(name), count=len(group)),
            zorder=4,
        )
    if finite_rows:
        axes.legend(loc="lower right", frameon=False, fontsize=0.9 * style.font_pt)
    _label_symbols(axes, finite_rows, style)
    axes.set_title(
        tr("n = {count} planes", count=len(finite_rows)), fontsize=style.font_pt, color=style.ink
    )
    return len(finite_rows)


def _label_symbols(axes: Axes, finite_rows: Sequence[Mapping[str, Any]], style: NetStyle) -> None:
    """Name up to `_MAX_NAMES` symbols of planes that are not good."""
    if not finite_rows:
        return
    labelled_rows = [k for k, row in enumerate(finite_rows) if row.get("quality") != "good"][
        :_MAX_NAMES
    ]
    label_symbols(
        axes,
        np.array([(float(row["collinearity"]), float(row["coplanarity"])) for row in finite_rows]),
        {k: str(finite_rows[k].get("name") or finite_rows[k]["id"]) for k in labelled_rows},
        symbol_pt=style.marker_pt,
        font_pt=0.8 * style.font_pt,
        color=style.ink,
    )


def _draw_background(axes: Axes, top: float, style: NetStyle) -> None:
    limits: Thresholds = PROFILES_BY_NAME["textbook"]
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(1.0, top)
    axes.set_ylim(3.0, top)
    axes.set_xlabel(tr("collinearity, λ1 / λ2"))
    axes.set_ylabel(tr("coplanarity, 1 / λ3"))
    axes.spines[["top", "right"]].set_visible(False)
    border = np.geomspace(3.0, top, 200)
    axes.fill_between(border - 2.0, 3.0, border, color=style.soft, alpha=0.15, linewidth=0)
    axes.plot(border - 2.0, border, color=style.soft, linewidth=style.line_pt)
    text_style: dict[str, Any] = {"color": style.soft, "fontsize": 0.9 * style.font_pt, "zorder": 3}
    box_style = {"facecolor": style.paper, "edgecolor": "none", "pad": 1.0}
    axes.text(1.15, top / 1.3, tr("sheet (oblate)"), va="top", bbox=box_style, **text_style)
    axes.text(1.15, 3.6, tr("equant"), va="bottom", **text_style)
    axes.text(top / 1.6, top / 1.6, tr("rod (prolate)"), ha="right", va="bottom", **text_style)
    axes.text(top / 1.6, top / 60, tr("impossible: λ2 < λ3"), ha="right", va="top", **text_style)
    for position, line in (
        (limits.least_coplanarity, axes.axhline),
        (limits.most_collinearity, axes.axvline),
    ):
        if math.isfinite(position):
            line(position, color=style.ink, linewidth=style.line_pt, linestyle="--", zorder=1)


def _is_finite(value: object) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)
