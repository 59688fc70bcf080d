"""Style of a printed figure: size, font, symbols, lines and colours."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.options import given_options
from vomstudio.products.net.figure_options import SIZE_MM, RoseFigure, SetColors, StereonetFigure
from vomstudio.products.net.style import PRINT, NetStyle


@dataclass(frozen=True)
class FigureStyle:
    """Style of a printed figure.

    Parameters
    ----------
    figure : StereonetFigure
        Size, font, symbols and lines.
    colors : mapping
        Replacement of each colour, #rrggbb -> #rrggbb.
    """

    figure: StereonetFigure = field(default_factory=StereonetFigure)
    colors: Mapping[str, str] = field(default_factory=dict)

    @property
    def width_mm(self) -> float | None:
        return self.figure.width_and_height[0]

    @property
    def height_mm(self) -> float | None:
        return self.figure.width_and_height[1]

    @property
    def size_mm(self) -> tuple[float, float]:
        return self.width_mm or SIZE_MM[0], self.height_mm or SIZE_MM[1]

    @property
    def rose_figure(self) -> RoseFigure:
        """Options of a rose with the same width, font and lines."""
        shared_options = {
            item.name: getattr(self.figure, item.name)
            for item in fields(RoseFigure)
            if hasattr(self.figure, item.name)
        }
        return RoseFigure(**shared_options, width_mm=self.width_mm)

    @classmethod
    def from_options(cls, options: StereonetFigure | RoseFigure) -> FigureStyle:
        """Return the style for options. Raises UsageError if the font is not installed."""
        if options.font is not None and options.font not in fonts():
            raise UsageError(Finding("figure.no-font", font=options.font), field="--font")
        if isinstance(options, StereonetFigure):
            return cls(options)
        values = asdict(options)
        width = values.pop("width_mm")
        return cls(StereonetFigure(**values, size_mm=None if width is None else f"{width:g}"))

    def net_style(self) -> NetStyle:
        """Return the style of a net on white paper."""
        figure = self.figure
        stated_sizes = {
            "font_pt": figure.font_size_pt,
            "marker_pt": figure.symbol_size_pt,
            "line_pt": figure.line_width_pt,
        }
        sizes: dict[str, Any] = {
            name: value for name, value in stated_sizes.items() if value is not None
        }
        return replace(
            PRINT,
            grey=figure.grey,
            family=figure.font or "",
            color_replacements=dict(self.colors),
            **sizes,
        )

    def to_settings(self) -> dict[str, Any]:
        """Return the values that differ from the defaults, to be stored in the settings."""
        colors = {"colors": dict(self.colors)} if self.colors else {}
        return {**given_options(self.figure), **colors}

    @classmethod
    def restore(cls, values: Mapping[str, Any]) -> FigureStyle:
        """Restore a style from `to_settings`, or the default style if the values are invalid."""
        names = {item.name for item in fields(StereonetFigure)}
        figure_values = {name: value for name, value in values.items() if name in names}
        try:
            figure = cls.from_options(StereonetFigure(**figure_values)).figure
            colors = dict(values.get("colors", {}))
            SetColors(tuple(f"{set_name}={color}" for set_name, color in colors.items()))
        except (UsageError, TypeError, ValueError):
            return cls()
        return cls(figure, colors)


def fonts() -> list[str]:
    """Return the sorted names of the fonts available for figures."""
    from matplotlib.font_manager import fontManager

    return sorted({font.name for font in fontManager.ttflist})
