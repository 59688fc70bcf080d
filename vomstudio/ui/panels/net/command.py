"""What the net shows, as the words of the command that draws it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.core.options import option_words
from vomstudio.geology.fold_planes import FoldFilter
from vomstudio.geology.rose_options import RoseOptions
from vomstudio.products.net.contents import Contouring
from vomstudio.products.net.figure_options import RoseFigure, SetColors, StereonetOptions
from vomstudio.products.net.net_options import parse_net_plane
from vomstudio.ui.panels.net.view_settings import NetWishes
from vomstudio.ui.widgets.copied_command import CommandArgument, CommandArguments, format_numbers
from vomstudio.ui.widgets.copied_planes import result_path

if TYPE_CHECKING:
    from vomstudio.products.net.figure_style import FigureStyle

_FLAGS = ("girdles", "maxima", "errors", "averages", "intersections")


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
) -> CommandArguments:
    """Return the command of the net, or of the roses in its place.

    Parameters
    ----------
    table : Path
        File with the shown features.
    notation : str
        Notation in which planes were typed.
    style, colors
        Style of figures, and the colours of kinds by their names.
    fold : FoldFilter, optional
        Planes of the fold axis; None if it is not shown.
    """
    end: list[CommandArgument | tuple[str, CommandArgument]] = [
        ("-o", result_path(table, "svg")),
        "--force",
    ]
    set_colors = SetColors(tuple(f"{name}={color}" for name, color in colors.items()))
    if wishes.view != "net":
        figure = RoseFigure(
            font=style.font or None,
            font_size_pt=style.font_pt,
            line_width_pt=style.line_pt,
            grey=style.grey,
            width_mm=style.width_mm,
        )
        words = [*option_words(_rose_options(wishes)), *option_words(figure)]
        return ["rose", table, *words, *option_words(set_colors), *end]
    options = _net_options(wishes, projection, method, contouring, notation, fold)
    words = [*option_words(options), *option_words(style.options())]
    return ["stereonet", table, *words, *option_words(set_colors), *end]


def _rose_options(wishes: NetWishes) -> RoseOptions:
    values: dict[str, Any] = {
        "of": wishes.view,
        "bin_deg": wishes.bin_deg,
        "by": "kind",
        "scale": "area" if wishes.by_area else "length",
        "weight": "extent_m" if wishes.by_length else None,
    }
    return RoseOptions(**values)


def _net_options(
    wishes: NetWishes,
    projection: str,
    method: str | None,
    contouring: Contouring,
    notation: str,
    fold: FoldFilter | None,
) -> StereonetOptions:
    """Return the options of the net; typed planes by their dip direction."""

    def texts(name: str) -> tuple[str, ...]:
        parts = wishes.texts.get(name, "").split(";")
        return tuple(part.strip() for part in parts if part.strip())

    def planes(name: str) -> tuple[str, ...]:
        read = [parse_net_plane(text, "", notation) for text in texts(name)]
        return tuple(f"{plane.dip_direction_deg:.12g}/{plane.dip_deg:.12g}" for plane in read)

    values: dict[str, Any] = {name: name in wishes.asked for name in _FLAGS}
    values |= {
        "by": "kind",
        "projection": projection,
        "untilt": next(iter(planes("untilt")), None),
        "rotate": next(iter(texts("rotate")), None),
        "planes": planes("planes"),
        "cones": texts("cones"),
        "slip_lines": texts("slips"),
    }
    if method is not None:
        values |= {
            "contour": method,
            "filled": contouring.is_filled,
            "each_set": contouring.each_set,
            "kamb_sigma": contouring.sigma,
            "levels": format_numbers(wishes.levels) if wishes.levels else None,
        }
    if fold is not None:
        values |= {"fold": True, "quality": fold.min_quality, "only_set": fold.set_name}
    return StereonetOptions(**values)
