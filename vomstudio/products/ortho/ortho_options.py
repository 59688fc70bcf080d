"""Options of orthophotos, shared by all interfaces."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.options import (
    MAX_LENGTH_M,
    MIN_LENGTH_M,
    Options,
    check_alternatives,
    check_exclusive,
    check_requires,
    option,
)
from vomstudio.core.words import to_translate


@dataclass(frozen=True)
class OrthoOptions(Options):
    """View and pixel size of an orthophoto.

    Raises
    ------
    UsageError
        If a value is out of bounds, or if more than one direction or an incomplete one is given.
    """

    trend_deg: float | None = option(
        None,
        minimum=-3600.0,
        maximum=3600.0,
        metavar="T",
        help=to_translate("trend of the view direction, degrees (with --plunge)"),
    )
    plunge_deg: float | None = option(
        None,
        minimum=-90.0,
        maximum=90.0,
        metavar="P",
        help=to_translate("plunge of the view direction, degrees; 90 is straight down"),
    )
    plane: str | None = option(
        None, metavar="DD/D", help=to_translate("look against the upward normal of this plane")
    )
    fold: str | None = option(
        None,
        metavar="TABLE",
        help=to_translate("look along the fold axis of the bedding in this table"),
    )
    gsd_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        help=to_translate("size of a pixel, m"),
        automatic_text=to_translate("resolution of the texture or cloud"),
    )
    flip: bool = option(
        False,
        label=to_translate("Opposite side (mirrored)"),
        help=to_translate("look from the other side (mirror image)"),
        tip=to_translate("Look from the other side (mirror image)"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("trend_deg", "plunge_deg"):
            check_exclusive(self, name, "plane", "fold")
        check_requires(self, "trend_deg", "plunge_deg")
        check_requires(self, "plunge_deg", "trend_deg")

    @property
    def has_direction(self) -> bool:
        """Whether a viewing direction is given."""
        return any(item is not None for item in (self.trend_deg, self.plane, self.fold))

    def check_direction(self) -> None:
        """Require a viewing direction.

        Raises
        ------
        UsageError
            If no direction is given, or more than one.
        """
        check_alternatives(self, "trend_deg", "plane", "fold")


@dataclass(frozen=True)
class OrthoDrawing(Options):
    """Sheet, region and interpretation of an orthophoto, for the command and the window.

    Raises
    ------
    UsageError
        If parts or a domain of the interpretation are given without a project.
    """

    sheet: str | None = option(
        None,
        metavar="FILE",
        help=to_translate("also write a scaled sheet with ticks and scale bar (.png, .jpg, .pdf)"),
    )
    draw: str | None = option(
        None,
        metavar="PROJECT",
        help=to_translate(
            "also draw the features of this project as NAME_drawing.gpkg, .svg and .dxf, with"
            " apparent dips, or strikes and true dips on a map"
        ),
    )
    show: str | None = option(
        None,
        metavar="PARTS",
        help=to_translate(
            "parts of the drawing, separated by commas: traces, patches, symbols, legend"
        ),
        automatic_text=to_translate("all"),
    )
    domain: str | None = option(
        None,
        metavar="NAME",
        help=to_translate(
            "show only this domain in colour, along its own axis unless a direction is given"
        ),
    )
    around: str | None = option(
        None,
        metavar="X,Y,Z,W,H",
        help=to_translate("show only this width and height (in metres) around a World point"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_requires(self, "show", "draw")
        check_requires(self, "domain", "draw")
