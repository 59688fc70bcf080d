"""Options of logs, declared once for every door."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.options import check_options, option
from vomstudio.words import to_translate

MAX_SIGMA_M = 1e6
MAX_ERROR_DEG = 90.0


@dataclass(frozen=True)
class LogOptions:
    """Errors of boundaries and bedding, and the way up; None where the program chooses.

    Raises
    ------
    UsageError
        For a value outside its bounds.
    """

    sigma_m: float | None = option(
        None,
        minimum=0.0,
        maximum=MAX_SIGMA_M,
        label=to_translate("Points ± (1σ)"),
        help=to_translate("standard deviation of each coordinate, m"),
        tip=to_translate("Standard deviation of each coordinate of a boundary"),
        automatic=to_translate("0; for a line of a project the scatter of the traces"),
    )
    bed_error_deg: float | None = option(
        None,
        minimum=0.0,
        maximum=MAX_ERROR_DEG,
        help=to_translate("half-angle of the 95 % cone of the bedding's normal"),
        automatic=to_translate("0; of fitted bedding its own"),
    )
    overturned: bool = option(
        False,
        label=to_translate("Overturned"),
        help=to_translate("younger beds lie below"),
        tip=to_translate("Younger beds lie below"),
    )

    def __post_init__(self) -> None:
        check_options(self)
