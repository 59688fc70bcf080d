"""Options of the kinematic analysis of a slope, declared once for all interfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.options import (
    Options,
    check_alternatives,
    check_requires,
    option,
)
from vomstudio.core.words import to_translate

DEFAULT_LATERAL_DEG = 20.0
"""Default lateral limit for planes (Goodman 1980; Wyllie & Mah 2004)."""


@dataclass(frozen=True)
class SlopeOptions(Options):
    """Friction angle and lateral limits.

    Raises
    ------
    UsageError
        If a value is not allowed.
    """

    friction_deg: float = option(
        minimum=0.0,
        maximum=89.9,
        label=to_translate("Friction"),
        help=to_translate("friction angle of the planes"),
        tip=to_translate("Friction angle of the planes"),
        decimals=1,
    )
    lateral_deg: float = option(
        DEFAULT_LATERAL_DEG,
        minimum=0.1,
        maximum=90.0,
        label=to_translate("Lateral"),
        help=to_translate(
            "maximum angle from the slope direction for planes and direct toppling, not for"
            " wedges; 90: no limit"
        ),
        tip=to_translate("Maximum angle from the slope direction; 90 for no limit"),
        decimals=1,
    )
    limits: Literal["curved", "straight"] = option(
        "curved",
        label=to_translate("Limits"),
        help=to_translate(
            "lateral limits of planes: small circles about the strike, or dip directions"
        ),
        tip=to_translate("Lateral limits: small circles about the strike, or dip directions"),
        titles=(to_translate("small circles"), to_translate("dip directions")),
    )


@dataclass(frozen=True)
class SlopeFaces(Options):
    """Slope face or facets, and files of the command.

    Raises
    ------
    UsageError
        If both or neither of a face and facets are given, or if an option does not apply to them.
    """

    face: str | None = option(
        None, metavar="DD/D", help=to_translate("dip direction and dip of the slope")
    )
    facets: str | None = option(
        None,
        metavar="FACETS",
        help=to_translate("use each facet of this table as a face"),
    )
    labelled_model: str | None = option(
        None,
        metavar="MODEL",
        help=to_translate("labelled model with these facets"),
    )
    paint: str | None = option(
        None,
        metavar="OUT.ply",
        help=to_translate("write the labelled model, coloured by the critical share of each facet"),
    )
    plot: str | None = option(
        None,
        metavar="FILE",
        help=to_translate("also draw a net for each failure mode (.svg, .pdf or .png)"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_alternatives(self, "face", "facets")
        check_requires(self, "labelled_model", "facets")
        check_requires(self, "paint", "labelled_model")
        check_requires(self, "plot", "face")
