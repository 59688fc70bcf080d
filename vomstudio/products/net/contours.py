"""Planning of density contours: groups, levels and colours."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geology import density as densities
from vomstudio.geology.orientation import Line
from vomstudio.products.net.contents import Contouring, NetContents, NetSet
from vomstudio.products.net.style import NetStyle, mix_colors

DENSITY_NAMES = {
    "kamb": to_translate("Density after Kamb, {sigma} σ"),
    "exponential_kamb": to_translate("Density after Kamb, exponential kernel, {sigma} σ"),
    "linear_kamb": to_translate("Density after Kamb, linear kernel, {sigma} σ"),
    "schmidt": to_translate("Density after Schmidt"),
}

DASHES = ("-", "--", "-.", ":")
"""Line styles that distinguish sets of the same colour."""

OPACITY = 0.6


@dataclass(frozen=True, eq=False)
class ContourGroup:
    """Density of one set, or of all features if `of` is None, on a grid.

    `steps` (k,) and `values` (k, k) are as returned by `density_grid`. `dash` is the line style.
    """

    of: NetSet | None
    steps: FloatArray
    values: FloatArray
    dash: str = "-"


@dataclass(frozen=True, eq=False)
class ContourPlan:
    """Groups and levels of contours; nothing is drawn if there are no levels."""

    method: str
    sigma: float
    filled: bool
    levels: tuple[float, ...] = ()
    parts: tuple[ContourGroup, ...] = ()
    subject: str = ""
    """Description of the contoured sets for the legend; empty if they are all of one kind."""

    @classmethod
    def of(cls, net: NetContents) -> ContourPlan | None:
        """Plan the contours of a net; None if not requested or if there are no features.

        Copies of a net that differ in other contents share the plan, so that the density is
        computed once.
        """
        return _plan_contours(net.sets, net.contour, net.contouring)

    @property
    def name(self) -> str:
        return tr(DENSITY_NAMES[self.method], sigma=f"{self.sigma:g}")

    @property
    def unit(self) -> str:
        return tr(densities.DENSITY_UNITS[self.method])

    @property
    def short_unit(self) -> str:
        return "% / 1 %" if self.method == "schmidt" else "σ"


@lru_cache(maxsize=1)
def _plan_contours(
    sets: tuple[NetSet, ...], contour: str | None, contouring: Contouring
) -> ContourPlan | None:
    net = NetContents(sets, contour=contour, contouring=contouring)
    groups = contour_groups(net)
    if contour is None or not groups:
        return None
    colors = Counter[str]()
    parts = []
    for net_set, vectors in groups:
        steps, values = densities.density_grid(vectors, contour, sigma=contouring.sigma)
        color = "" if net_set is None else net_set.color
        parts.append(ContourGroup(net_set, steps, values, DASHES[colors[color] % len(DASHES)]))
        colors[color] += 1
    top = max(float(part.values.max()) for part in parts)
    return ContourPlan(
        contour,
        contouring.sigma,
        contouring.is_filled,
        contour_levels(net, top),
        tuple(parts),
        _describe_subject(net),
    )


def check_contour_sizes(net: NetContents) -> list[Finding]:
    """Return a finding for each set that is too small for meaningful contours."""
    if net.contour is None:
        return []
    findings = []
    for contoured_set, v in contour_groups(net):
        area = densities.counting_area(len(v), net.contour, net.contouring.sigma)
        if area > 0.5:
            findings.append(
                Finding(
                    "net.few-for-contours",
                    set=contoured_set.name
                    if contoured_set
                    else net.contouring.set_name or tr("All sets"),
                    count=len(v),
                    share_percent=100.0 * area,
                )
            )
    return findings


def contoured_sets(net: NetContents) -> list[NetSet]:
    """Return the sets that are contoured.

    Parameters
    ----------
    net : NetContents

    Returns
    -------
    list of NetSet
    """
    contoured_name = net.contouring.set_name
    return [set_ for set_ in net.sets if len(set_) and contoured_name in (None, set_.group_name)]


def _describe_subject(net: NetContents) -> str:
    """Describe the sets that are contoured together.

    Returns an empty text if each set has its own contours or the net has fewer than two groups.
    """
    sets = contoured_sets(net)
    if net.contouring.each_set or len({set_.group_name for set_ in net.sets if len(set_)}) < 2:
        return ""
    count = sum(map(len, sets))
    if net.contouring.set_name is None:
        return tr("of all sets together, n = {count:,}", count=count)
    return tr("of {set}, n = {count:,}", set=net.contouring.set_name, count=count)


def contour_groups(net: NetContents) -> list[tuple[NetSet | None, FloatArray]]:
    """Return each contoured set with its vectors (n, 3).

    If the sets are contoured together, the only item is None with the vectors of all of them.
    """
    sets = contoured_sets(net)
    if not sets:
        return []
    if net.contouring.each_set:
        return [(set_, set_.vectors()) for set_ in sets]
    return [(None, np.vstack([set_.vectors() for set_ in sets]))]


def contour_levels(net: NetContents, top: float) -> tuple[float, ...]:
    """Return the requested levels, or round levels, below the highest density."""
    if net.contour is None:
        return ()
    levels = net.contouring.levels or densities.choose_round_levels(top, net.contour)
    return tuple(level for level in levels if level < top)


def describe_density(net: NetContents) -> dict[str, Any] | None:
    """Describe the contours of a net as plain values, or return None if it has none.

    The values are the method, unit, sigma and levels and, for each group of contours, its name, its
    size, and its maximum with trend and plunge. The name is None for all sets together.
    """
    plan = ContourPlan.of(net)
    if net.contour is None or plan is None:
        return None
    contouring, parts = net.contouring, []
    for (contoured_set, v), part in zip(contour_groups(net), plan.parts, strict=True):
        place, top = densities.find_maximum(v, net.contour, contouring.sigma, part.values)
        line = Line.from_vector(place)
        parts.append(
            {
                "set": contouring.set_name if contoured_set is None else contoured_set.name,
                "n": len(v),
                "maximum": top,
                "trend_deg": line.trend_deg,
                "plunge_deg": line.plunge_deg,
            }
        )
    return {
        "method": net.contour,
        "unit": densities.DENSITY_UNITS[net.contour],
        "sigma": None if net.contour == "schmidt" else contouring.sigma,
        "levels": list(plan.levels),
        "filled": contouring.is_filled,
        "parts": parts,
    }


def contour_colors(
    colored_set: NetSet | None, n: int, is_filled: bool, style: NetStyle
) -> list[str]:
    """Return the colours of n ascending levels.

    All features together are drawn in greys (in a perceptual colour map on a dark net), and each
    set in shades of its colour.
    """
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    if colored_set is None and is_filled:
        if style.contour_map == "dark":
            return [to_hex(colormaps["cividis"](float(s))) for s in np.linspace(0.1, 0.9, n)]
        return [to_hex(colormaps["Greys"](float(s))) for s in np.linspace(0.2, 0.9, n)]
    color = style.ink if colored_set is None else style.outline(style.color(colored_set.color))
    return [mix_colors(color, style.net, float(fraction)) for fraction in np.linspace(0.55, 0.0, n)]


def bar_width(plan: ContourPlan, font: float, is_legend_beside: bool) -> float:
    """Return the total width of the columns of the colour bar in points."""
    k = len(bar_columns(plan))
    max_letters = 8.0 if is_legend_beside else 2.5
    return font if k == 1 else font * min(0.9 * k, max_letters)


def bar_height(plan: ContourPlan, font: float, height: float) -> float:
    """Return the height of the colour bar beside the net in points."""
    return min(1.5 * font * len(plan.levels), 0.4 * height)


def bar_columns(plan: ContourPlan) -> list[ContourGroup]:
    """Return the first group of each colour, which has its own column in the colour bar."""
    first_groups: dict[str | None, ContourGroup] = {}
    for part in plan.parts:
        first_groups.setdefault(part.of.color if part.of else None, part)
    return list(first_groups.values())


def bar_space(plan: ContourPlan | None, font: float) -> float:
    """Return the width that a colour bar at the right edge requires, in points."""
    return 0.0 if plan is None or not plan.levels else 3.5 * font + bar_width(plan, font, False)
