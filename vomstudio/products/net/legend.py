"""What the legend of a net says, and how wide its words are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from vomstudio.geology.notation import format_plane
from vomstudio.products.net.contents import NetContents, NetEllipse, NetSet, circles_shown
from vomstudio.products.net.style import NetStyle


@dataclass(frozen=True)
class Entry:
    """A line of the legend: a symbol (marker and/or line) and its text."""

    text: str
    color: str
    marker: str | None = None
    line: str | None = None
    outlined: bool = False
    like: NetSet | None = None
    """Of this set: its symbol is drawn as on the net."""


def legend_entries(net: NetContents, style: NetStyle) -> list[Entry]:
    entries = []
    names = [s.name for s in net.sets]
    for s in net.sets:
        circles = s.kind == "plane" and circles_shown(net)
        terse = s.name
        if s.kind == "line" and names.count(s.name) > 1:
            terse += ", lines"
        what = "lines" if s.kind == "line" else "poles" if net.poles else "planes"
        entries.append(
            Entry(
                f"{terse} ({len(s):,})" if net.compact else f"{s.name}, {what} (n = {len(s):,})",
                style.color(s.color),
                s.marker if net.poles else None,
                "-" if circles else None,
                like=s,
            )
        )
    if net.fold is not None:
        fold = net.fold
        text = "β"
        if fold.max_confidence95_deg is not None and fold.min_confidence95_deg is not None:
            major, minor = fold.max_confidence95_deg, fold.min_confidence95_deg
            errors = f"±{major:.1f}° / ±{minor:.1f}°"
            text = f"β {errors}" if net.compact else f"β, joint 95 %: {errors}"
        entries.append(Entry(text, style.ink, "*"))
        plane = format_plane(fold.pi_plane, net.notation, net.decimals)
        name = "π" if net.compact else "π-plane"
        entries.append(Entry(f"{name} {plane}", style.ink, None, "--"))
    if net.means:
        entries.append(Entry("open: mean", style.net, "o", None, outlined=True))
    if net.ellipses and not net.compact:
        what = "pole" if isinstance(net.ellipses[0], NetEllipse) else "line"
        entries.append(Entry(f"joint 95 % of the selected {what}", style.ink, None, "-"))
    return entries


@lru_cache(maxsize=4096)
def text_width(text: str, font_pt: float, weight: str = "normal") -> float:
    """Width of a text in points, without needing a canvas."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    if not text.strip():
        return 0.3 * font_pt * len(text)
    # A set may be called "$": names are no formulas.
    plain = text.replace("$", r"\$")
    box = TextPath((0, 0), plain, size=font_pt, prop=FontProperties(weight=weight)).get_extents()
    return float(box.x1)


def shortened(text: str, font_pt: float, width: float, weight: str = "normal") -> str:
    """The text, or as much of its beginning as leaves room for an ellipsis."""
    if text_width(text, font_pt, weight) <= width:
        return text
    # Measuring is slow, so that the end is sought by halves.
    fits, too_long = 1, len(text)
    while too_long - fits > 1:
        middle = (fits + too_long) // 2
        if text_width(text[:middle] + "…", font_pt, weight) <= width:
            fits = middle
        else:
            too_long = middle
    return text[:fits].rstrip() + "…"
