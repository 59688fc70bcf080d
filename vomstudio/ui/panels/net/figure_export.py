"""Export of the net or roses as a figure in the figure style of the user."""

from __future__ import annotations

from pathlib import Path
from typing import IO, TYPE_CHECKING, Protocol

from vomstudio.ui.base.studio import Studio

if TYPE_CHECKING:
    from vomstudio.products.net.contents import NetContents
    from vomstudio.products.net.figure_style import FigureStyle
    from vomstudio.products.net.rose_contents import RoseContents
    from vomstudio.ui.panels.net.view_settings import NetViewSettings


class NetDock(Protocol):
    """Interface of the net panel that commands and dialogs use."""

    view_settings: NetViewSettings

    def contents(self) -> NetContents: ...
    def printable_contents(self) -> NetContents | RoseContents: ...


def load_figure_style(studio: Studio) -> FigureStyle:
    """Return the style of printed figures from the settings."""
    from vomstudio.products.net.figure_style import FigureStyle

    return FigureStyle.restore(studio.settings.figure_style)


def write_net_figure(
    target: Path | IO[bytes],
    net_contents: NetContents | RoseContents,
    style: FigureStyle,
    format_: str,
    dpi: float = 300.0,
) -> None:
    """Write the net or the roses as a figure.

    Raises
    ------
    GeometryError
        If no set contains the angle that the roses show.
    """
    from vomstudio.products.net.figure import write_stereonet
    from vomstudio.products.net.figure_options import SIZE_MM
    from vomstudio.products.net.rose import write_roses
    from vomstudio.products.net.rose_contents import RoseContents, check_roses

    if isinstance(net_contents, RoseContents):
        check_roses(net_contents, None)
        width = style.width_mm or SIZE_MM[0]
        write_roses(
            target, net_contents, format=format_, style=style.net_style(), width_mm=width, dpi=dpi
        )
        return
    write_stereonet(
        target,
        net_contents,
        format=format_,
        style=style.net_style(),
        width_mm=style.width_mm,
        height_mm=style.height_mm,
        dpi=dpi,
    )
