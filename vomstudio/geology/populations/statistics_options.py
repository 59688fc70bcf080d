"""Options of the statistics of sets, declared once for all interfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.options import Options, option
from vomstudio.core.words import to_translate


@dataclass(frozen=True)
class StatisticsOptions(Options):
    """Options for grouping, averaging and weighting orientations.

    Raises
    ------
    UsageError
        If a value is not allowed.
    """

    by: str | None = option(
        None,
        metavar="COLUMN",
        help=to_translate("column that groups the rows"),
        automatic_text=to_translate("a single set"),
    )
    directed: bool = option(
        False, help=to_translate("treat lines as directed vectors, without flipping them")
    )
    weights: Literal["error"] | None = option(
        None,
        help=to_translate("weight each orientation by its error and the natural scatter"),
        automatic_text=to_translate("equal weights"),
    )
