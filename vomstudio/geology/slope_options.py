"""Options of the kinematic analysis of a slope, declared once for every door."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.options import check_options, option
from vomstudio.words import to_translate

DEFAULT_LATERAL_DEG = 20.0
"""Lateral limit of planes after Goodman (1980) and Wyllie & Mah (2004)."""


@dataclass(frozen=True)
class SlopeOptions:
    """Friction angle and lateral limits.

    Raises
    ------
    UsageError
        For a value that is not allowed.
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
            "maximum angle of planes and direct toppling from the slope's direction; 90 for no"
            " limit; wedges have none"
        ),
        tip=to_translate("Maximum angle from the slope's direction; 90 for no limit"),
        decimals=1,
    )
    limits: Literal["curved", "straight"] = option(
        "curved",
        help=to_translate("lateral limits of planes: small circles, or of the dip direction"),
    )

    def __post_init__(self) -> None:
        check_options(self)
