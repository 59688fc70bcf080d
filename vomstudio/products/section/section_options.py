"""Options of sections, shared by all interfaces."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.options import (
    MAX_LENGTH_M,
    MIN_LENGTH_M,
    Options,
    check_alternatives,
    check_requires,
    option,
)
from vomstudio.core.words import to_translate

DOMAINS = "domains"
"""Value of `SectionFeatures.along` with which each domain is projected along its own axis."""


@dataclass(frozen=True)
class SectionOptions(Options):
    """Plane or line of a section.

    Raises
    ------
    UsageError
        If a value is out of bounds, or if neither a plane with a point nor a line is given.
    """

    plane: str | None = option(
        None, metavar="DD/D", help=to_translate("plane of the section (with --through)")
    )
    through: str | None = option(
        None,
        metavar="X,Y,Z",
        help=to_translate("World point on the plane, the origin of distances"),
    )
    section_line: str | None = option(
        None,
        metavar="LINE",
        help=to_translate(
            "vertical section along the line in this file (table x, y, or GIS layer)"
        ),
    )
    flip: bool = option(
        False,
        label=to_translate("Other side"),
        help=to_translate("look from the other side (mirror image)"),
        tip=to_translate("Look at the section from the other side"),
    )
    slab_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        label=to_translate("Slab"),
        help=to_translate("thickness of the slab of cloud points to use, m"),
        tip=to_translate("Thickness of the slab of cloud points to use"),
        automatic_text=to_translate("four times the mean point spacing"),
        decimals=4,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_alternatives(self, "plane", "section_line")
        check_requires(self, "plane", "through")
        check_requires(self, "through", "plane")


@dataclass(frozen=True)
class SectionFeatures(Options):
    """Features to project onto a section.

    Raises
    ------
    UsageError
        If a value is out of bounds, or if a direction or distance is given without features.
    """

    features: str | None = option(
        None,
        metavar="FILE",
        help=to_translate("also project the features of this project or orientation table"),
    )
    along: str | None = option(
        None,
        metavar="T/P|domains",
        help=to_translate(
            "project along this trend and plunge, or, with domains, each domain along its own axis"
        ),
        automatic_text=to_translate("perpendicular to the section"),
    )
    within_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        label=to_translate("Within"),
        help=to_translate("maximum distance of the features from the section, m"),
        tip=to_translate("Maximum distance of the features from the section"),
        empty_text=to_translate("any distance"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_requires(self, "along", "features")
        check_requires(self, "within_m", "features")
