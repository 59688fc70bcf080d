"""Options of the statistics of sets, declared once for every door."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.options import Options, option
from vomstudio.core.words import to_translate


@dataclass(frozen=True)
class StatisticsOptions(Options):
    """How orientations are grouped, averaged and weighted.

    Raises
    ------
    UsageError
        For a value that is not allowed.
    """

    by: str | None = option(
        None,
        metavar="COLUMN",
        help=to_translate("column that groups the rows"),
        automatic=to_translate("one set, all"),
    )
    directed: bool = option(
        False, help=to_translate("lines have a head and a tail and are not flipped")
    )
    weights: Literal["error"] | None = option(
        None,
        help=to_translate("weight each by its own error and the natural scatter"),
        automatic=to_translate("equal weights"),
    )
