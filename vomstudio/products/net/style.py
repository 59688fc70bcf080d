"""Style of a net: colours, symbols and sizes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from vomstudio.products.net.contents import NetSet

SYMBOL_SIZES = {
    "P": 1.4,
    "X": 1.3,
    "*": 1.5,
    "D": 0.85,
    "^": 1.1,
    "v": 1.1,
    "<": 1.1,
    ">": 1.1,
    "p": 1.15,
}
"""Factors by which symbols are enlarged, so that all of them look equally large."""

LAYERS = (
    "density",
    "dots",
    "contours",
    "circles",
    "poles",
    "fold",
    "rim",
    "ticks",
    "casings",
    "chosen circles",
    "means",
    "ellipses",
    "chosen",
    "legend",
    "words",
)
"""Layers of a net in drawing order, from bottom to top."""


@dataclass(frozen=True)
class NetStyle:
    """Colours and sizes of a net.

    Parameters
    ----------
    ink, soft, paper, net : str
        Colours of text, secondary lines, the page and the net.
    font_pt, marker_pt, line_pt : float
        Sizes in points (1/72 inch of the figure).
    color_replacements : mapping of str to str
        Replacement of each colour.
    contour_map : {"light", "dark"}
    grey : bool
        Whether to draw without colours.
    family : str
        Font family; empty for DejaVu Sans.
    """

    ink: str = "#1a1a1a"
    soft: str = "#7a7a7a"
    paper: str = "#ffffff"
    net: str = "#ffffff"
    font_pt: float = 8.0
    marker_pt: float = 4.5
    line_pt: float = 0.8
    color_replacements: Mapping[str, str] = field(default_factory=dict)
    contour_map: str = "light"
    grey: bool = False
    family: str = ""

    @classmethod
    def dock(cls, dark: bool = False, dpi: float = 100.0, font_px: float = 11.0) -> NetStyle:
        """Return a light or dark style for a screen with the resolution `dpi`.

        `font_px` is the font size in pixels; symbols and lines also have fixed sizes in pixels.
        """
        px = 72.0 / dpi
        sizes = {"font_pt": font_px * px, "marker_pt": 6.0 * px, "line_pt": 1.1 * px}
        return replace(cls.dark() if dark else cls(), **sizes)  # type: ignore[arg-type]

    @classmethod
    def dark(cls) -> NetStyle:
        return cls(
            ink="#e8e8e8",
            soft="#9a9a9a",
            paper="#202124",
            net="#2a2b2e",
            # Black and the deepest blue are invisible on a dark background.
            color_replacements={"#000000": "#ffffff", "#0072B2": "#3d9be0"},
            contour_map="dark",
        )

    def color(self, color: str) -> str:
        for name, replacement in self.color_replacements.items():
            if name.casefold() == color.casefold():
                color = replacement
                break
        if self.grey:
            # Light greys would be invisible on paper.
            level = min(_luminance(color) ** (1.0 / 2.2), 0.65)
            return f"#{round(255 * level):02x}" + f"{round(255 * level):02x}" * 2
        # Feature type colours are designed for photographs, so lighten deep ones on a dark net.
        if _luminance(self.net) < 0.2:
            while _contrast(color, self.net) < 3.0:
                color = mix_colors(color, self.ink, 0.15)
        return color

    def symbol(self, net_set: NetSet) -> tuple[str, str, float]:
        """Return the face colour, edge colour and edge width (points) of a set's symbols."""
        color = self.color(net_set.color)
        if net_set.variant % 4 == 1:
            return self.net, self.outline(color), 1.5 * self.line_pt
        if net_set.variant % 4 == 2:
            return mix_colors(color, self.net), self.outline(color), 1.2 * self.line_pt
        face = color if net_set.variant % 4 == 0 else mix_colors(color, self.ink)
        edge = self.outline(face)
        if net_set.marker in "PX" and edge == face:  # a light rim would leave little of their arms
            return face, face, 0.5 * self.line_pt
        return (face, self.net, 0.5 * self.line_pt) if edge == face else (face, edge, self.line_pt)

    def outline(self, color: str) -> str:
        """Return a colour for thin lines, darkened or lightened if its contrast is too low."""
        return mix_colors(color, self.ink) if _contrast(color, self.net) < 1.8 else color


def layer(name: str) -> int:
    """Return the matplotlib zorder of one of `LAYERS`."""
    return LAYERS.index(name)


def mix_colors(color: str, other_color: str, fraction: float = 0.5) -> str:
    """Mix a colour with a share, 0 to 1, of another colour, and return it as hex."""
    from matplotlib.colors import to_hex, to_rgb

    pairs = zip(to_rgb(color), to_rgb(other_color), strict=True)
    red, green, blue = ((1.0 - fraction) * a + fraction * b for a, b in pairs)
    return to_hex((red, green, blue))


@lru_cache(maxsize=256)
def _luminance(color: str) -> float:
    """Return the relative luminance of a colour, 0 to 1 (WCAG 2)."""
    from matplotlib.colors import to_rgb

    linear_rgb = [
        v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in to_rgb(color)
    ]
    return 0.2126 * linear_rgb[0] + 0.7152 * linear_rgb[1] + 0.0722 * linear_rgb[2]


def _contrast(first_color: str, second_color: str) -> float:
    """Return the contrast ratio of two colours, 1 to 21 (WCAG 2)."""
    low, high = sorted((_luminance(first_color), _luminance(second_color)))
    return (high + 0.05) / (low + 0.05)


def symbol_scale(n: int) -> float:
    """Return the scale factor of symbols, 0.4 to 1, if n of them are drawn."""
    return float(np.interp(math.log10(max(n, 1)), [2.0, 3.0, 4.0], [1.0, 0.7, 0.4]))


PRINT = NetStyle()
