"""Command line that draws the current net or roses."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.core.options import option_words
from vomstudio.geology.fold_planes import FoldFilter
from vomstudio.geology.rose_options import RoseOptions
from vomstudio.products.net.contents import Contouring
from vomstudio.products.net.figure_options import SetColors, StereonetOptions
from vomstudio.products.net.net_options import parse_net_plane
from vomstudio.ui.panels.net.view_settings import NetViewSettings
from vomstudio.ui.widgets.copied_command import CommandArgument, CommandArguments, format_numbers
from vomstudio.ui.widgets.copied_planes import result_path

if TYPE_CHECKING:
    from vomstudio.products.net.figure_style import FigureStyle

_OVERLAY_FLAGS = ("girdles", "maxima", "errors", "averages", "intersections")


def net_command(
    table: Path,
    view_settings: NetViewSettings,
    projection: str,
    method: str | None,
    contouring: Contouring,
    notation: str,
    style: FigureStyle,
    colors: Mapping[str, str],
    fold: FoldFilter | None = None,
) -> CommandArguments:
    """Return the command that draws the net, or the roses if they are displayed.

    Parameters
    ----------
    table : Path
        File that contains the displayed features.
    view_settings : NetViewSettings
    projection : str
    method : str or None
    contouring : Contouring
    notation : str
        Notation of the typed planes.
    style : FigureStyle
    colors : mapping of str to str
        Colours of feature types by name.
    fold : FoldFilter, optional
        Filter of the planes that define the fold axis, or None if the axis is not drawn.
    """
    output: list[CommandArgument | tuple[str, CommandArgument]] = [
        ("-o", result_path(table, "svg")),
        "--force",
    ]
    set_colors = SetColors(tuple(f"{name}={color}" for name, color in colors.items()))
    if view_settings.view != "net":
        arguments = [*option_words(_rose_options(view_settings)), *option_words(style.rose_figure)]
        return ["rose", table, *arguments, *option_words(set_colors), *output]
    options = _net_options(
        view_settings=view_settings,
        projection=projection,
        method=method,
        contouring=contouring,
        notation=notation,
        fold=fold,
    )
    arguments = [*option_words(options), *option_words(style.figure)]
    return ["stereonet", table, *arguments, *option_words(set_colors), *output]


def _rose_options(view_settings: NetViewSettings) -> RoseOptions:
    values: dict[str, Any] = {
        "of": view_settings.view,
        "bin_deg": view_settings.bin_deg,
        "by": "kind",
        "scale": "area" if view_settings.is_area_scaled else "length",
        "weight": "extent_m" if view_settings.is_length_weighted else None,
    }
    return RoseOptions(**values)


def _net_options(
    view_settings: NetViewSettings,
    projection: str,
    method: str | None,
    contouring: Contouring,
    notation: str,
    fold: FoldFilter | None,
) -> StereonetOptions:
    """Return the options of the net; typed planes are converted to dip direction and dip."""

    def texts(name: str) -> tuple[str, ...]:
        parts = view_settings.texts.get(name, "").split(";")
        return tuple(part.strip() for part in parts if part.strip())

    def planes(name: str) -> tuple[str, ...]:
        attitudes = [parse_net_plane(text, "", notation) for text in texts(name)]
        return tuple(f"{plane.dip_direction_deg:.12g}/{plane.dip_deg:.12g}" for plane in attitudes)

    values: dict[str, Any] = {name: name in view_settings.overlays for name in _OVERLAY_FLAGS}
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
            # Tables contain type names in lower case.
            "contour_set": None if contouring.set_name is None else contouring.set_name.casefold(),
            "kamb_sigma": contouring.sigma,
            "levels": format_numbers(view_settings.levels) if view_settings.levels else None,
        }
    if fold is not None:
        values |= {"fold": True, "quality": fold.min_quality, "only_set": fold.set_name}
    return StereonetOptions(**values)
