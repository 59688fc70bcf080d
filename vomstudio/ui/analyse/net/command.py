"""What the net shows, as the words of the command that draws it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.geology.fold_planes import FoldFilter
from vomstudio.products.net.contents import Contouring
from vomstudio.products.net.net_options import plane_of
from vomstudio.ui.analyse.net.wishes import NetWishes
from vomstudio.ui.forms.copied_command import Word, Words, numbers_text
from vomstudio.ui.forms.copied_planes import beside

if TYPE_CHECKING:
    from vomstudio.products.net.figure_style import FigureStyle

_ASKED = ("girdles", "maxima", "errors", "averages", "intersections")

Option = Word | tuple[str, Word]


def net_words(
    table: Path,
    wishes: NetWishes,
    projection: str,
    method: str | None,
    contouring: Contouring,
    notation: str,
    style: FigureStyle,
    colors: Mapping[str, str],
    fold: FoldFilter | None = None,
) -> Words:
    """Of the net, or of the roses that stand in its place. table : of what is shown; notation : in
    which planes were typed; style, colors : of figures, and of the kinds by their names; fold :
    planes of the fold axis, None if it is not shown"""
    end: list[Option] = [("-o", beside(table, "svg")), "--force"]
    if wishes.view != "net":
        width: list[Option] = [] if style.width_mm is None else [("--width", style.width_mm)]
        return ["rose", table, *_of_rose(wishes), *width, *_look(style, colors, False), *end]
    said: list[Option] = [("--projection", projection), ("--by", "kind")]
    if method is not None:
        said.append(("--contour", method))
        said.append("--filled" if contouring.filled else "--no-filled")
        said += ["--each-set"] if contouring.each_set else []
        said += [] if method == "schmidt" else [("--kamb-sigma", contouring.sigma)]
        said += [("--levels", numbers_text(wishes.levels))] if wishes.levels else []
    said += [f"--{name}" for name in _ASKED if name in wishes.asked]
    if fold is not None:
        said.append("--fold")
        said += [] if fold.min_quality is None else [("--quality", fold.min_quality)]
        said += [] if fold.set_name is None else [("--only-set", fold.set_name)]
    if style.height_mm is not None:
        said.append(("--size", "{:g}x{:g}".format(*style.size_mm)))
    elif style.width_mm is not None:
        said.append(("--size", f"{style.width_mm:g}"))
    said += _look(style, colors, True)
    return ["stereonet", table, *said, *_typed(wishes, notation), *end]


def _look(style: FigureStyle, colors: Mapping[str, str], symbols: bool) -> list[Option]:
    """What the user has chosen for figures."""
    said: list[Option] = [("--font", style.font)] if style.font else []
    sizes = [("--font-size", style.font_pt), ("--line-width", style.line_pt)]
    if symbols:
        sizes.append(("--symbol-size", style.symbol_pt))
    said += [(option, value) for option, value in sizes if value is not None]
    said += ["--grey"] if style.grey else []
    return said + [("--color", f"{name}={color}") for name, color in colors.items()]


def _of_rose(wishes: NetWishes) -> list[Option]:
    said: list[Option] = [("--of", wishes.view), ("--bin", wishes.bin_deg), ("--by", "kind")]
    said.append(("--scale", "area" if wishes.by_area else "length"))
    return said + ([("--weight", "extent_m")] if wishes.by_length else [])


def _typed(wishes: NetWishes, notation: str) -> list[Option]:
    """Circles, lines and turning, as they stand in the fields; planes by their dip direction."""
    texts = wishes.texts

    def each(name: str) -> list[str]:
        return [part.strip() for part in texts.get(name, "").split(";") if part.strip()]

    def plane(text: str) -> str:
        found = plane_of(text, "", notation)
        return f"{found.dip_direction_deg:.12g}/{found.dip_deg:.12g}"

    said: list[Option] = [("--plane", plane(text)) for text in each("planes")]
    said += [("--cone", text) for text in each("cones")]
    said += [("--slip-line", text) for text in each("slips")]
    said += [("--untilt", plane(text)) for text in each("untilt")]
    return said + [("--rotate", text) for text in each("rotate")]
