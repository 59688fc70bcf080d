"""Contours of density on a net, and the bar that says what they mean."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.errors import UsageError
from vomstudio.geology import density as densities
from vomstudio.geology.orientation import Array, Line
from vomstudio.products.net.contents import NetContents, NetSet
from vomstudio.products.net.style import NetStyle, layer, mixed
from vomstudio.words import to_translate, tr

if TYPE_CHECKING:
    from vomstudio.products.net.page import Page

DENSITY_NAMES = {
    "kamb": to_translate("Density after Kamb, {sigma} σ"),
    "exponential_kamb": to_translate("Density after Kamb, exponential kernel, {sigma} σ"),
    "linear_kamb": to_translate("Density after Kamb, linear kernel, {sigma} σ"),
    "schmidt": to_translate("Density after Schmidt"),
}

DASHES = ("-", "--", "-.", ":")
"""Of the sets of one type, which have one colour."""

MOST_ASKED = 20
SIGMAS = (0.5, 10.0)

SEE_THROUGH = 0.6


@dataclass(frozen=True, eq=False)
class Contoured:
    """The density of one set (None: of all together) and where its contours are drawn.

    x, y (k,), values (k, k): as `density_grid` gives them.
    """

    of: NetSet | None
    x: Array
    y: Array
    values: Array


@dataclass(frozen=True, eq=False)
class ContourPlan:
    """What is contoured, at which levels; without levels nothing is to be drawn."""

    method: str
    sigma: float
    filled: bool
    levels: tuple[float, ...] = ()
    parts: tuple[Contoured, ...] = ()

    @classmethod
    def of(cls, net: NetContents) -> ContourPlan | None:
        """None where no contours are wanted, or there is nothing to contour."""
        groups = contoured_groups(net)
        if net.contour is None or not groups:
            return None
        look = net.contouring
        parts = tuple(
            Contoured(s, *densities.density_grid(v, net.contour, net.projection, sigma=look.sigma))
            for s, v in groups
        )
        top = max(float(part.values.max()) for part in parts)
        levels = contour_levels(net, top)
        return cls(net.contour, look.sigma, look.is_filled, levels, parts)

    @property
    def name(self) -> str:
        return tr(DENSITY_NAMES[self.method], sigma=f"{self.sigma:g}")

    @property
    def unit(self) -> str:
        return tr(densities.DENSITY_UNITS[self.method])

    @property
    def short_unit(self) -> str:
        return "% / 1 %" if self.method == "schmidt" else "σ"


def check_contouring(contour: str | None, levels: Sequence[float], sigma: float) -> None:
    """Raises UsageError for levels or a sigma that cannot be; its `field` is the option's name."""
    if levels and contour is None:
        raise UsageError(tr("Levels need a method to contour by."), field="--levels")
    if not all(math.isfinite(level) and level > 0 for level in levels):
        raise UsageError(tr("The levels of contours must be above 0."), field="--levels")
    if len(levels) > MOST_ASKED:
        raise UsageError(
            tr("There are {count} levels; use at most {most}.", count=len(levels), most=MOST_ASKED),
            field="--levels",
        )
    if not SIGMAS[0] <= sigma <= SIGMAS[1]:
        raise UsageError(
            tr("Kamb's sigma lies between {least:g} and {most:g}.", least=SIGMAS[0],
               most=SIGMAS[1]),
            field="--sigma",
        )  # fmt: skip


def few_reasons(net: NetContents) -> list[str]:
    """A sentence for each set that is too small for its contours to mean much."""
    if net.contour is None:
        return []
    said = []
    for of, v in contoured_groups(net):
        area = densities.counting_area(len(v), net.contour, net.contouring.sigma)
        if area > 0.5:
            said.append(
                tr(
                    "{set}: {count} orientations are few for contours; the counting circle covers "
                    "{share:.0%} of the net.",
                    set=of.name if of else tr("All together"), count=len(v), share=area,
                )
            )  # fmt: skip
    return said


def contoured_groups(net: NetContents) -> list[tuple[NetSet | None, Array]]:
    """Vectors (n, 3) of each set, or of all together (None), as the net is to be contoured."""
    sets = [s for s in net.sets if len(s)]
    if not sets:
        return []
    if net.contouring.each_set:
        return [(s, s.vectors()) for s in sets]
    return [(None, np.vstack([s.vectors() for s in sets]))]


def contour_levels(net: NetContents, top: float) -> tuple[float, ...]:
    """Those asked for, or round ones, below the highest density; of all sets alike."""
    if net.contour is None:
        return ()
    wanted = net.contouring.levels or densities.round_levels(top, net.contour)
    return tuple(level for level in wanted if level < top)


def density_found(net: NetContents) -> dict[str, Any] | None:
    """Method, unit, sigma and levels of a net's contours, and of each set (or all, None) how many
    it has and where they lie densest, as plain values; None without contours."""
    groups = contoured_groups(net)
    if net.contour is None or not groups:
        return None
    look, parts = net.contouring, []
    for of, v in groups:
        place, top = densities.densest(v, net.contour, look.sigma)
        line = Line.from_vector(place)
        parts.append(
            {
                "set": None if of is None else of.name,
                "n": len(v),
                "maximum": top,
                "trend_deg": line.trend_deg,
                "plunge_deg": line.plunge_deg,
            }
        )
    return {
        "method": net.contour,
        "unit": densities.DENSITY_UNITS[net.contour],
        "sigma": None if net.contour == "schmidt" else look.sigma,
        "levels": list(contour_levels(net, max(part["maximum"] for part in parts))),
        "filled": look.is_filled,
        "parts": parts,
    }


def contour_colors(of: NetSet | None, n: int, filled: bool, style: NetStyle) -> list[object]:
    """Of n levels, from the lowest: greys (or, on a dark net, a map for the eye) of all together,
    shades of a set's own colour for that set."""
    from matplotlib import colormaps

    if of is None and filled:
        if style.contour_map == "dark":
            return [colormaps["cividis"](float(s)) for s in np.linspace(0.1, 0.75, n)]
        return [colormaps["Greys"](float(s)) for s in np.linspace(0.12, 0.62, n)]
    color = style.ink if of is None else style.outline(style.color(of.color))
    return [mixed(color, style.net, float(share)) for share in np.linspace(0.55, 0.0, n)]


def dash(of: NetSet | None) -> str:
    return DASHES[of.variant % len(DASHES)] if of is not None else "-"


def draw_contours(page: Page, plan: ContourPlan) -> None:
    style, n = page.style, len(plan.levels)
    if not n:
        return
    for part in plan.parts:
        top = float(part.values.max())
        if top <= plan.levels[0]:
            continue
        colors = contour_colors(part.of, n, plan.filled, style)
        if plan.filled:
            # Up to a level above all, so that one level is enough.
            filled = page.axes.contourf(
                part.x, part.y, part.values, levels=[*plan.levels, plan.levels[-1] + top],
                colors=colors, alpha=None if part.of is None else SEE_THROUGH,
                zorder=layer("density"), antialiased=True,
            )  # fmt: skip
            filled.set_clip_path(page.rim)
        shades = _line_colors(part.of, colors, plan.filled, style)
        lines = page.axes.contour(
            part.x, part.y, part.values, levels=list(plan.levels), colors=shades,
            linewidths=_line_width(plan, style), linestyles=dash(part.of),
            zorder=layer("contours"),
        )  # fmt: skip
        lines.set_clip_path(page.rim)
    _draw_bar(page, plan)


def _line_colors(
    of: NetSet | None, colors: list[object], filled: bool, style: NetStyle
) -> list[object]:
    """Lines about filled contours only part them."""
    if not filled:
        return colors
    color = style.soft if of is None else style.outline(style.color(of.color))
    return [color] * len(colors)


def _line_width(plan: ContourPlan, style: NetStyle) -> float:
    return (0.6 if plan.filled else 1.1) * style.line_pt


def bar_width(plan: ContourPlan, font: float, beside: bool) -> float:
    """Of the columns of the bar, one for each set, in points."""
    k = len(plan.parts)
    most = 8.0 if beside else 2.5
    return font if k == 1 else font * min(0.9 * k, most)


def bar_room(plan: ContourPlan | None, font: float) -> float:
    """What the bar takes of the width where it stands at the right edge."""
    return 0.0 if plan is None or not plan.levels else 3.5 * font + bar_width(plan, font, False)


def _draw_bar(page: Page, plan: ContourPlan) -> None:
    from matplotlib.patches import Rectangle

    n, font, row = len(plan.levels), page.font, page.row
    thick = bar_width(plan, font, page.beside)
    if page.beside:
        tall = min(1.5 * font * n, 0.4 * page.height)
        left, low = page.legend_x, page.pad + (len(page.foot) + 0.8) * row
        page.text(left, low + tall + 0.8 * row, plan.unit)
        page.text(left, low + tall + 1.8 * row, plan.name)
    else:
        tall = min(1.5 * font * n, 1.2 * page.radius)
        left, low = page.width - page.pad - 2.2 * font - thick, page.cy - tall / 2
        page.text(page.width - page.pad, low + tall + 0.8 * row, plan.short_unit, align="right")
    each = thick / len(plan.parts)
    for column, part in enumerate(plan.parts):
        colors = contour_colors(part.of, n, plan.filled, page.style)
        for i, color in enumerate(colors):
            x, y = left + column * each, low + tall * i / n
            if plan.filled:
                cell = Rectangle(
                    page.net_of(x, y), each / page.radius, tall / n / page.radius,
                    facecolor=_laid_over(color, part.of, page.style),
                    edgecolor=page.style.soft, linewidth=0.5 * page.style.line_pt,
                    zorder=layer("legend"),
                )  # fmt: skip
                page.axes.add_patch(cell)
            else:
                ends = np.array([page.net_of(x, y), page.net_of(x + 0.85 * each, y)])
                page.axes.plot(
                    *ends.T, color=color, linestyle=dash(part.of),
                    linewidth=1.4 * _line_width(plan, page.style), zorder=layer("legend"),
                )  # fmt: skip
    for i, level in enumerate(plan.levels):
        page.text(left + thick + 0.4 * font, low + tall * i / n, f"{level:g}")


def _laid_over(color: object, of: NetSet | None, style: NetStyle) -> object:
    """As it looks on the net."""
    return color if of is None else mixed(style.net, str(color), SEE_THROUGH)
