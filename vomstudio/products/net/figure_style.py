"""What a user may choose of a printed figure: its size, letters, symbols, lines and colours."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any

from vomstudio.core.findings import Finding
from vomstudio.errors import UsageError
from vomstudio.products.net.style import PRINT, NetStyle

SIZE_MM = (170.0, 115.0)
"""A page wide, as journals print it."""

LIMITS = {
    "width_mm": (40.0, 500.0, "--size"),
    "height_mm": (30.0, 500.0, "--size"),
    "font_pt": (4.0, 36.0, "--font-size"),
    "symbol_pt": (1.0, 30.0, "--symbol-size"),
    "line_pt": (0.1, 10.0, "--line-width"),
}
"""Least, most, and the option of the command."""


@dataclass(frozen=True)
class FigureStyle:
    """Sizes in millimetres and points, None for the usual one. colors : #rrggbb that others are
    drawn in, by those"""

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

    def check(self, width_option: str = "--size") -> None:
        """Raises UsageError for what cannot be drawn; its `field` is the option's name."""
        for name, (least, most, option) in LIMITS.items():
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and least <= value <= most):
                raise UsageError(
                    Finding("option.out-of-range", value=value, minimum=least, maximum=most),
                    field=width_option if name == "width_mm" else option,
                )
        if self.font and self.font not in fonts():
            raise UsageError(Finding("figure.no-font", font=self.font), field="--font")

    def of_net(self) -> NetStyle:
        """The style of a figure on white paper."""
        given = {"font_pt": self.font_pt, "marker_pt": self.symbol_pt, "line_pt": self.line_pt}
        sizes: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
        return replace(PRINT, grey=self.grey, family=self.font, swaps=dict(self.colors), **sizes)

    def to_keep(self) -> dict[str, Any]:
        """What differs from the usual, for the settings."""
        usual = asdict(FigureStyle())
        return {name: value for name, value in asdict(self).items() if value != usual[name]}

    @classmethod
    def kept(cls, values: Mapping[str, Any]) -> FigureStyle:
        """Of `to_keep`; the usual style where the settings hold something else."""
        names = {f.name for f in fields(cls)}
        try:
            found = cls(**{name: value for name, value in values.items() if name in names})
            found.check()
            found.of_net()
        except (UsageError, TypeError, ValueError):
            return cls()
        return found


def fonts() -> list[str]:
    """The names of the fonts that figures can be drawn with, in order."""
    from matplotlib.font_manager import fontManager

    return sorted({font.name for font in fontManager.ttflist})


def size_of(text: str | None) -> tuple[float | None, float | None]:
    """Width and height of "WxH" in millimetres, or of "W". Raises UsageError."""
    if text is None:
        return None, None
    wide, by, high = text.lower().replace("\N{MULTIPLICATION SIGN}", "x").partition("x")
    try:
        return float(wide), float(high) if by else None
    except ValueError:
        raise UsageError(Finding("figure.not-a-size", text=text), field="--size") from None
