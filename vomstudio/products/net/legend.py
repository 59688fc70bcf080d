"""Legend entries of a net, and measurement of text."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from vomstudio.core.words import to_translate, tr
from vomstudio.geology.folds import FoldAxis
from vomstudio.geology.notation import format_error_deg, format_plane
from vomstudio.products.net.contents import (
    USER_LINE_MARKER,
    NetContents,
    NetLineEllipse,
    NetSet,
    describe_means,
    fold_ellipse,
    shows_all_circles,
)
from vomstudio.products.net.style import NetStyle

_NO_BREAK_EQUALS = "\N{NO-BREAK SPACE}=\N{NO-BREAK SPACE}"
SYMBOLS = {
    "slip": to_translate("Slip of the hanging wall"),
    "line-ellipse": to_translate("Joint 95 % region of the selected line"),
    "pole-ellipse": to_translate("Joint 95 % region of the selected pole"),
}
"""Texts of the legend, keyed by symbol."""


@dataclass(frozen=True)
class NetLegendEntry:
    """Entry of the legend: a symbol (marker, line or both) and its text."""

    text: str
    color: str
    marker: str | None = None
    line: str | None = None
    is_outlined: bool = False
    symbol_set: NetSet | None = None
    """Set whose symbol is drawn in the same way as on the net."""
    is_continuation: bool = False
    """Whether the text continues that of the previous entry."""


def legend_entries(net: NetContents, style: NetStyle) -> list[NetLegendEntry]:
    """Return the legend entries of a net."""
    entries = []
    names = [set_.name for set_ in net.sets]
    for set_ in net.sets:
        has_circles = set_.kind == "plane" and shows_all_circles(net)
        short_name = set_.name
        if set_.kind == "line" and names.count(set_.name) > 1:
            short_name = tr("{set}, lines", set=short_name)
        entries.append(
            NetLegendEntry(
                f"{short_name} ({len(set_):,})"
                if net.compact
                else format_set_entry(set_, net.poles),
                style.color(set_.color),
                set_.marker if net.poles else None,
                "-" if has_circles else None,
                symbol_set=set_,
            )
        )
    if net.poles and any(set_.slips is not None for set_ in net.sets):
        entries.append(NetLegendEntry(tr(SYMBOLS["slip"]), style.ink, ">", "-"))
    if net.fold is not None:
        beta, plane = fold_texts(net, net.fold)
        entries.append(NetLegendEntry(beta, style.ink, "*"))
        entries.append(NetLegendEntry(plane, style.ink, None, "--"))
    for circle in (item for item in net.user_circles if item.label):
        color = style.ink if circle.color is None else style.outline(style.color(circle.color))
        entries.append(NetLegendEntry(circle.label, color, None, circle.dash))
    if any(mark.marker == USER_LINE_MARKER for mark in net.marks):
        text = tr("Line on a plane (rake)")
        entries.append(NetLegendEntry(text, style.net, USER_LINE_MARKER, None, is_outlined=True))
    if net.errors:
        entries.append(NetLegendEntry(tr("95 % error of each feature"), style.soft, None, "-"))
    if net.means:
        text = describe_means(net.means)
        entries.append(NetLegendEntry(text, style.net, "o", None, is_outlined=True))
    if net.ellipses and not net.compact:
        text = (
            tr(SYMBOLS["line-ellipse"])
            if isinstance(net.ellipses[0], NetLineEllipse)
            else tr(SYMBOLS["pole-ellipse"])
        )
        entries.append(NetLegendEntry(text, style.ink, None, "-"))
    if any(mean.total is not None for mean in net.means):
        text = tr("95 % error of the mean, including registration")
        entries.append(NetLegendEntry(text, style.ink, None, "-"))
    return entries


def fold_texts(net: NetContents, fold: FoldAxis) -> tuple[str, str]:
    """Return the legend texts for beta and for the pi-plane."""
    ellipse = fold_ellipse(fold)
    text = "β"
    if ellipse is not None:
        semi_axes = (ellipse.max_angle_deg, ellipse.min_angle_deg)
        errors = " / ".join(f"±{format_error_deg(angle)}" for angle in semi_axes)
        text = f"β {errors}" if net.compact else tr("β, joint 95 %: {errors}", errors=errors)
    text = tr("{beta}, n = {n:,}", beta=text, n=fold.n)
    if net.fold_not_good_count:
        text = tr("{beta}, {count:,} not rated good", beta=text, count=net.fold_not_good_count)
    plane = format_plane(fold.pi_plane, net.notation, net.decimals)
    return text, f"π {plane}" if net.compact else tr("π-plane {orientation}", orientation=plane)


def format_set_entry(net_set: NetSet, include_poles: bool) -> str:
    """Return the full legend text of a set.

    Parameters
    ----------
    net_set : NetSet
    include_poles : bool

    Returns
    -------
    str
    """
    if net_set.kind == "line":
        return tr("{set}, lines (n = {count:,})", set=net_set.name, count=len(net_set))
    if include_poles:
        return tr("{set}, poles (n = {count:,})", set=net_set.name, count=len(net_set))
    return tr("{set}, planes (n = {count:,})", set=net_set.name, count=len(net_set))


def text_width(text: str, font_pt: float, weight: str = "normal") -> float:
    """Measure the width of a text in points in matplotlib's current font, without a canvas."""
    from matplotlib import rcParams

    if not text.strip():
        return 0.3 * font_pt * len(text)
    return _width(text, font_pt, weight, tuple(rcParams["font.family"]))


@lru_cache(maxsize=4096)
def _width(text: str, font_pt: float, weight: str, family: tuple[str, ...]) -> float:
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    # The outlines of the letters would be slightly narrower, but measuring them takes twenty times
    # as long.
    font = FontProperties(family=list(family), weight=weight, size=font_pt)
    return float(text_to_path.get_text_width_height_descent(text, font, ismath=False)[0])


def wrap_text(text: str, font_pt: float, width: float, weight: str = "normal") -> list[str]:
    """Wrap a text to a width; longer words get their own line, no-break spaces are kept.

    An equals sign and both of its sides stay together.
    """
    if text_width(text, font_pt, weight) <= width:
        return [text]
    lines: list[str] = []
    for word in text.replace(" = ", _NO_BREAK_EQUALS).split(" "):
        extended_line = f"{lines[-1]} {word}" if lines else word
        if lines and text_width(extended_line, font_pt, weight) <= width:
            lines[-1] = extended_line
        else:
            lines.append(word)
    return [line.replace(_NO_BREAK_EQUALS, " = ") for line in lines]


def shorten_text(text: str, font_pt: float, width: float, weight: str = "normal") -> str:
    """Shorten a text to a width by means of an ellipsis."""
    if text_width(text, font_pt, weight) <= width:
        return text
    # Measuring is slow, so find the end by bisection.
    low, high = 1, len(text)
    while high - low > 1:
        centre = (low + high) // 2
        if text_width(text[:centre] + "…", font_pt, weight) <= width:
            low = centre
        else:
            high = centre
    return text[:low].rstrip() + "…"
