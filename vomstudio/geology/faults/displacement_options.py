"""Options of displacements and three-point problems, declared once for all interfaces."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.options import Options, check_exclusive, check_requires, option
from vomstudio.core.words import to_translate

MAX_SIGMA_M = 1e6
MAX_ERROR_DEG = 90.0


@dataclass(frozen=True)
class ThreePointOptions(Options):
    """Error of the points in a three-point problem.

    Raises
    ------
    UsageError
        If a value is outside its bounds.
    """

    sigma_m: float = option(
        0.0,
        minimum=0.0,
        maximum=MAX_SIGMA_M,
        label=to_translate("Points ± (1σ)"),
        help=to_translate("standard deviation of each coordinate, m"),
        tip=to_translate("Standard deviation of each coordinate"),
        automatic_text=to_translate("estimated from the misfit, with more than three points"),
        decimals=4,
        empty_text=to_translate("unknown"),
    )


@dataclass(frozen=True)
class DisplacementOptions(Options):
    """Fault, bed and slip of a displacement, with their errors.

    Raises
    ------
    UsageError
        If a value is outside its bounds, if `rake_deg` is combined with `slip`, or if either is
        given without `bed`.
    """

    fault: str = option(metavar="DD/D", help=to_translate("attitude of the fault"))
    bed: str | None = option(
        None,
        metavar="DD/D",
        help=to_translate("attitude of the bed, if the points are its cut-offs"),
        automatic_text=to_translate("each pair was originally one point"),
    )
    rake_deg: float | None = option(
        None,
        minimum=0.0,
        maximum=180.0,
        help=to_translate(
            "rake of the slip lineation, from the right-hand-rule strike (90 down dip); a"
            " horizontal fault needs --slip"
        ),
    )
    slip: str | None = option(
        None,
        metavar="T/P",
        help=to_translate("trend and plunge of the slip lineation, instead of its rake"),
    )
    sigma_m: float | None = option(
        None,
        minimum=0.0,
        maximum=MAX_SIGMA_M,
        label=to_translate("Points ± (1σ)"),
        help=to_translate("standard deviation of each coordinate, m"),
        tip=to_translate("Standard deviation of each coordinate of a cut-off"),
        automatic_text=to_translate("0; for traces of a project, their scatter"),
    )
    fault_error_deg: float = option(
        0.0,
        minimum=0.0,
        maximum=MAX_ERROR_DEG,
        help=to_translate("half-angle of the 95 % cone of the fault normal"),
    )
    bed_error_deg: float = option(
        0.0,
        minimum=0.0,
        maximum=MAX_ERROR_DEG,
        help=to_translate("half-angle of the 95 % cone of the bed normal"),
    )
    rake_error_deg: float = option(
        0.0,
        minimum=0.0,
        maximum=MAX_ERROR_DEG,
        label=to_translate("Slip ± (95 %)"),
        help=to_translate("95 % error of the rake"),
        tip=to_translate("95 % error of the slip's rake"),
        decimals=2,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_exclusive(self, "rake_deg", "slip")
        check_requires(self, "rake_deg", "bed")
        check_requires(self, "slip", "bed")
