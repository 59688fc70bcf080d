"""Options of logs, declared once for all interfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.options import MAX_LENGTH_M, Options, check_requires, option
from vomstudio.core.words import to_translate

MAX_SIGMA_M = 1e6
MAX_ERROR_DEG = 90.0


@dataclass(frozen=True)
class LogOptions(Options):
    """Errors of boundaries and bedding, and younging direction; None selects the default.

    Raises
    ------
    UsageError
        If a value is outside its bounds.
    """

    sigma_m: float | None = option(
        None,
        minimum=0.0,
        maximum=MAX_SIGMA_M,
        label=to_translate("Points ± (1σ)"),
        help=to_translate("standard deviation of each coordinate, m"),
        tip=to_translate("Standard deviation of each coordinate of a boundary"),
        automatic_text=to_translate("0; for a line of a project, the scatter of the traces"),
    )
    bed_error_deg: float | None = option(
        None,
        minimum=0.0,
        maximum=MAX_ERROR_DEG,
        help=to_translate("half-angle of the 95 % cone of the bedding normal"),
        automatic_text=to_translate("0; for fitted bedding, the error of the fit"),
    )
    overturned: bool = option(
        False,
        label=to_translate("Overturned"),
        help=to_translate("younger beds lie below"),
        tip=to_translate("Younger beds lie below"),
    )


@dataclass(frozen=True)
class LogLine(Options):
    """Bedding and line options of the `log` command.

    Raises
    ------
    UsageError
        If a distance is outside its bounds, or if an option that requires a line is given
        without one.
    """

    bed: str | None = option(
        None,
        metavar="DD/D",
        help=to_translate("attitude of the beds"),
        automatic_text=to_translate("for a line of a project, fitted to the traces"),
    )
    line: str | None = option(
        None,
        metavar="NAME",
        help=to_translate("name or id of the project line along which the log is drawn"),
    )
    of: Literal["traces", "points", "both"] | None = option(
        None,
        label=to_translate("Boundaries"),
        help=to_translate(
            "boundaries of the log: traces across the line, points of the line, or both"
        ),
        tip=to_translate("Boundaries of the log"),
        titles=(
            to_translate("traces across the line"),
            to_translate("points of the line"),
            to_translate("traces and points"),
        ),
        empty_text="",
        automatic_text=to_translate("traces"),
    )
    reach_m: float | None = option(
        None,
        minimum=0.0,
        maximum=MAX_LENGTH_M,
        label=to_translate("Traces within"),
        help=to_translate("maximum distance of a trace from the line, m"),
        tip=to_translate("Maximum distance of a trace from the line"),
        automatic_text=to_translate("1/20 of the length of the line"),
    )
    type: str | None = option(
        None,
        metavar="TYPE",
        help=to_translate("feature type of the traces to use"),
        automatic_text=to_translate("bedding"),
    )
    plot: str | None = option(
        None, metavar="FILE", help=to_translate("also draw the bed column (.svg, .pdf or .png)")
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("of", "reach_m", "type"):
            check_requires(self, name, "line")
