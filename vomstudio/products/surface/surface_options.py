"""Options of the surface analysis of a patch, shared by all interfaces."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.options import MAX_LENGTH_M, MIN_LENGTH_M, Options, option
from vomstudio.core.words import to_translate


@dataclass(frozen=True)
class SurfaceOptions(Options):
    """Options for the analysis of a patch and the map of its deviations.

    Raises
    ------
    UsageError
        If a value is out of bounds.
    """

    around: str | None = option(
        None,
        metavar="X,Y,Z,R",
        help=to_translate("use only the part of the model within R metres of a World point"),
    )
    noise_m: float | None = option(
        None,
        minimum=0.0,
        maximum=MAX_LENGTH_M,
        label=to_translate("Noise"),
        help=to_translate("standard deviation of the model's noise, m"),
        tip=to_translate("Standard deviation of the model's noise"),
        automatic_text=to_translate(
            "scatter about local planes for a cloud, a quarter of the mean edge length for a mesh"
        ),
        decimals=5,
    )
    gsd_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        help=to_translate("cell size of the map, m"),
        automatic_text=to_translate("mean edge length or point spacing"),
    )
