"""Options of stereonets and of the appearance of figures, shared by all interfaces."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.options import Options, check_requires, option
from vomstudio.core.words import to_translate

SIZE_MM = (170.0, 115.0)
"""Default size of a figure: the width of a journal page."""
LIMITS = {
    "width_mm": (40.0, 500.0),
    "height_mm": (30.0, 500.0),
    "font_pt": (4.0, 36.0),
    "symbol_pt": (1.0, 30.0),
    "line_pt": (0.1, 10.0),
}
"""Bounds of the dimensions of a figure."""
MAX_LEVELS = 20
_COLOR_PATTERN = re.compile(r"#[0-9a-fA-F]{6}")


@dataclass(frozen=True)
class FigureAppearance(Options):
    """Fonts, lines and colours of a figure.

    Raises
    ------
    UsageError
        If a size is out of bounds.
    """

    font: str | None = option(
        None,
        metavar="NAME",
        label=to_translate("Font"),
        help=to_translate("font, which must be installed"),
        tip=to_translate("Font of all text in the figure"),
        suggestions=("DejaVu Sans",),
        empty_text=to_translate("default"),
    )
    font_size_pt: float | None = option(
        None,
        minimum=LIMITS["font_pt"][0],
        maximum=LIMITS["font_pt"][1],
        decimals=1,
        label=to_translate("Font size"),
        help=to_translate("font size, points"),
        tip=to_translate("Size of text"),
        automatic_text=to_translate("8"),
    )
    line_width_pt: float | None = option(
        None,
        minimum=LIMITS["line_pt"][0],
        maximum=LIMITS["line_pt"][1],
        decimals=1,
        label=to_translate("Lines"),
        help=to_translate("line width, points"),
        tip=to_translate("Width of lines"),
        automatic_text=to_translate("0.8"),
    )
    grey: bool = option(
        False,
        label=to_translate("Greyscale"),
        help=to_translate("draw in greyscale"),
        tip=to_translate("Draw in greyscale"),
    )


@dataclass(frozen=True)
class StereonetFigure(FigureAppearance):
    """Size and appearance of a stereonet.

    Raises
    ------
    UsageError
        If a size is out of bounds, or if a text is not a valid size.
    """

    symbol_size_pt: float | None = option(
        None,
        minimum=LIMITS["symbol_pt"][0],
        maximum=LIMITS["symbol_pt"][1],
        decimals=1,
        label=to_translate("Symbols"),
        help=to_translate("symbol size, points"),
        tip=to_translate("Size of symbols"),
        automatic_text=to_translate("4.5"),
    )
    size_mm: str | None = option(
        None,
        metavar="WxH",
        label=to_translate("Size in mm"),
        help=to_translate("figure width and height, or only its width, millimetres"),
        tip=to_translate("Width and height, such as 170x115, or only the width"),
        automatic_text=to_translate("width 170, automatic height"),
        empty_text=to_translate("170 x auto"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, value in zip(("width_mm", "height_mm"), self.width_and_height, strict=True):
            minimum, maximum = LIMITS[name]
            if value is not None and not minimum <= value <= maximum:
                raise UsageError(
                    Finding(
                        "option.out-of-range",
                        value=value,
                        minimum=minimum,
                        maximum=maximum,
                    ),
                    field="--size",
                )

    @property
    def width_and_height(self) -> tuple[float | None, float | None]:
        """Width and height in millimetres; None if not given.

        Raises
        ------
        UsageError
            If the text is not a valid size.
        """
        if self.size_mm is None:
            return None, None
        text = self.size_mm.lower().replace("\N{MULTIPLICATION SIGN}", "x")
        width, separator, height = text.partition("x")
        try:
            return float(width), float(height) if separator else None
        except ValueError:
            raise UsageError(
                Finding("figure.not-a-size", text=self.size_mm), field="--size"
            ) from None


@dataclass(frozen=True)
class RoseFigure(FigureAppearance):
    """Size and appearance of rose diagrams.

    Raises
    ------
    UsageError
        If a size is out of bounds.
    """

    width_mm: float | None = option(
        None,
        minimum=LIMITS["width_mm"][0],
        maximum=LIMITS["width_mm"][1],
        help=to_translate("figure width, millimetres"),
        automatic_text=to_translate("170"),
    )


@dataclass(frozen=True)
class SetColors(Options):
    """Colours of sets.

    Raises
    ------
    UsageError
        If a text is not of the form SET=#RRGGBB.
    """

    colors: tuple[str, ...] = option(
        (), metavar="SET=#RRGGBB", help=to_translate("colour of a set")
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for item in self.colors:
            name, _, color = item.rpartition("=")
            if not name or not _COLOR_PATTERN.fullmatch(color):
                raise UsageError(Finding("figure.not-a-color", text=item), field="--color")

    @property
    def colors_by_set(self) -> dict[str, str]:
        """Colours by the name of their set."""
        return {name: color for name, _, color in (item.rpartition("=") for item in self.colors)}


@dataclass(frozen=True)
class StereonetOptions(Options):
    """Contents of a stereonet.

    Raises
    ------
    UsageError
        If a value is out of bounds, levels are invalid, levels or a contoured set are given without
        a method, or planes are filtered without a fold axis.
    """

    by: str | None = option(
        None, metavar="COLUMN", help=to_translate("colour by this column (name or number)")
    )
    projection: Literal["area", "angle"] = option(
        "area", help=to_translate("equal area or equal angle")
    )
    contour: Literal["kamb", "exponential_kamb", "linear_kamb", "schmidt"] | None = option(
        None, metavar="METHOD", help=to_translate("contour the density of poles and lines")
    )
    levels: str | None = option(
        None,
        metavar="A,B,...",
        help=to_translate("contour levels: standard deviations, or percent with schmidt"),
        automatic_text=to_translate("multiples of a round step, below the maximum density"),
    )
    filled: bool | None = option(
        None,
        help=to_translate("fill the contours"),
        automatic_text=to_translate("filled; lines with --each-set"),
    )
    each_set: bool = option(
        False, help=to_translate("contour each set separately, in its colour, at the same levels")
    )
    contour_set: str | None = option(
        None,
        metavar="SET",
        help=to_translate("contour this set only"),
        automatic_text=to_translate("all sets together"),
    )
    kamb_sigma: float = option(
        3.0,
        minimum=0.5,
        maximum=10.0,
        metavar="S",
        help=to_translate(
            "smoothing of Kamb's methods: expected count of a uniform distribution, in standard"
            " deviations"
        ),
    )
    untilt: str | None = option(
        None,
        metavar="DD/D",
        help=to_translate(
            "rotate everything so that this plane becomes horizontal, about its strike"
        ),
    )
    rotate: str | None = option(
        None,
        metavar="T/P/ANGLE",
        help=to_translate("rotate everything about an axis (trend/plunge), by the right-hand rule"),
    )
    intersections: bool = option(
        False, help=to_translate("draw all intersections of up to 300 planes")
    )
    planes: tuple[str, ...] = option(
        (), metavar="DD/D", help=to_translate("also draw this great circle")
    )
    cones: tuple[str, ...] = option(
        (),
        metavar="T/P/ANGLE",
        help=to_translate("also draw this small circle about an axis (trend/plunge)"),
    )
    slip_lines: tuple[str, ...] = option(
        (),
        metavar="DD/D/RAKE",
        help=to_translate(
            "also draw this plane and a line on it, with its rake from the right-hand-rule strike"
        ),
    )
    girdles: bool = option(
        False, help=to_translate("draw the best-fit great circle of sets that form girdles")
    )
    maxima: bool = option(
        False, help=to_translate("mark the density maximum of each set or of the contours")
    )
    errors: bool = option(
        False,
        help=to_translate(
            "draw the 95 % ellipse of each plane from the error columns of the table"
        ),
    )
    averages: bool = option(
        False, help=to_translate("state the mean of each set, with n and method")
    )
    fold: bool = option(
        False, help=to_translate("draw the fold axis of the bedding and its great circle")
    )
    quality: Literal["good", "doubtful"] | None = option(
        None, help=to_translate("use only planes with at least this verdict for the fold axis")
    )
    only_set: str | None = option(
        None,
        metavar="SET",
        help=to_translate("use only planes of this set for the fold axis"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_requires(self, "levels", "contour")
        check_requires(self, "contour_set", "contour")
        check_requires(self, "quality", "fold")
        check_requires(self, "only_set", "fold")
        parse_levels(self.levels)


def parse_levels(text: str | None) -> tuple[float, ...]:
    """Parse contour levels, and return them in ascending order without duplicates.

    Raises
    ------
    UsageError
    """
    if text is None:
        return ()
    try:
        levels = tuple(sorted({float(word) for word in text.split(",")}))
    except ValueError:
        levels = ()
    if not levels or not all(0.0 < level < float("inf") for level in levels):
        raise UsageError(Finding("net.not-levels", text=text), field="--levels")
    if len(levels) > MAX_LEVELS:
        raise UsageError(
            Finding("net.too-many-levels", count=len(levels), maximum=MAX_LEVELS),
            field="--levels",
        )
    return levels
