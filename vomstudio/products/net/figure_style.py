"""Style of a printed figure: size, font, symbols, lines and colours."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.products.net.figure_options import SIZE_MM, RoseFigure, StereonetFigure
from vomstudio.products.net.style import PRINT, NetStyle


@dataclass(frozen=True)
class FigureStyle:
    """Style of a printed figure; sizes that are not given have their defaults.

    Parameters
    ----------
    width_mm, height_mm : float or None
    font : str
        Font name; empty for the default font.
    font_pt, symbol_pt, line_pt : float or None
    grey : bool
    colors : mapping
        Replacement of each colour, #rrggbb -> #rrggbb.
    """

    width_mm: float | None = None
    height_mm: float | None = None
    font: str = ""
    font_pt: float | None = None
    symbol_pt: float | None = None
    line_pt: float | None = None
    grey: bool = False
    colors: Mapping[str, str] = field(default_factory=dict)

    @property
    def size_mm(self) -> tuple[float, float]:
        return self.width_mm or SIZE_MM[0], self.height_mm or SIZE_MM[1]

    def options(self) -> StereonetFigure:
        """Return the options of the command. Raises UsageError if a size is out of bounds."""
        size = None
        if self.height_mm is not None:
            size = "{:g}x{:g}".format(*self.size_mm)
        elif self.width_mm is not None:
            size = f"{self.width_mm:g}"
        return StereonetFigure(
            font=self.font or None,
            font_size_pt=self.font_pt,
            symbol_size_pt=self.symbol_pt,
            line_width_pt=self.line_pt,
            size_mm=size,
            grey=self.grey,
        )

    @classmethod
    def from_options(cls, options: StereonetFigure | RoseFigure) -> FigureStyle:
        """Return the style for options. Raises UsageError if the font is not installed."""
        if options.font is not None and options.font not in fonts():
            raise UsageError(Finding("figure.no-font", font=options.font), field="--font")
        if isinstance(options, RoseFigure):
            width, height, symbol = options.width_mm, None, None
        else:
            width, height = options.width_and_height
            symbol = options.symbol_size_pt
        return cls(
            width,
            height,
            font=options.font or "",
            font_pt=options.font_size_pt,
            symbol_pt=symbol,
            line_pt=options.line_width_pt,
            grey=options.grey,
        )

    def net_style(self) -> NetStyle:
        """Return the style of a net on white paper."""
        stated_sizes = {
            "font_pt": self.font_pt,
            "marker_pt": self.symbol_pt,
            "line_pt": self.line_pt,
        }
        sizes: dict[str, Any] = {
            name: value for name, value in stated_sizes.items() if value is not None
        }
        return replace(PRINT, grey=self.grey, family=self.font, swaps=dict(self.colors), **sizes)

    def to_keep(self) -> dict[str, Any]:
        """Return the values that differ from the defaults, to be stored in the settings."""
        default_style = asdict(FigureStyle())
        return {name: value for name, value in asdict(self).items() if value != default_style[name]}

    @classmethod
    def restore(cls, values: Mapping[str, Any]) -> FigureStyle:
        """Restore a style from `to_keep`, or the default style if the values are invalid."""
        names = {field.name for field in fields(cls)}
        try:
            style = cls(**{name: value for name, value in values.items() if name in names})
            cls.from_options(style.options())
            style.net_style()
        except (UsageError, TypeError, ValueError):
            return cls()
        return style


def fonts() -> list[str]:
    """Return the sorted names of the fonts available for figures."""
    from matplotlib.font_manager import fontManager

    return sorted({font.name for font in fontManager.ttflist})
