"""Options for the fold axis of a table, declared once for all interfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.options import Options, check_exclusive, option
from vomstudio.core.words import to_translate

MIN_WAVINESS_DEG = 0.01
MAX_WAVINESS_DEG = 45.0


@dataclass(frozen=True)
class FoldOptions(Options):
    """Selection and grouping of the planes from which a fold axis is computed.

    Raises
    ------
    UsageError
        If a value is outside its bounds, or if `sets` and `by` are combined.
    """

    kind: str | None = option(
        None,
        metavar="KIND",
        help=to_translate("use only planes of this kind"),
        automatic_text=to_translate("bedding, if the table has kinds"),
    )
    sets: str | None = option(
        None,
        metavar="A,B[,C]",
        help=to_translate(
            "compute the common axis of these sets (hanging wall, footwall, fault) from their means"
        ),
    )
    only_set: str | None = option(
        None, metavar="SET", help=to_translate("use only planes of this set")
    )
    quality: Literal["good", "doubtful"] | None = option(
        None,
        label=to_translate("Quality"),
        titles=(to_translate("Good only"), to_translate("Good, doubtful")),
        empty_text=to_translate("Any quality"),
        help=to_translate("use only planes with at least this verdict (column quality)"),
        tip=to_translate("Use only planes with these verdicts for the fold axis"),
    )
    by: str | None = option(
        None,
        metavar="COLUMN",
        help=to_translate(
            "compute an axis for each domain in this column, and test whether a single axis fits"
            " all"
        ),
    )
    waviness_deg: float | None = option(
        None,
        minimum=MIN_WAVINESS_DEG,
        maximum=MAX_WAVINESS_DEG,
        help=to_translate("standard deviation of the poles about the girdle of a cylindrical fold"),
        automatic_text=to_translate("90 % of the poles within 10 degrees"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_exclusive(self, "sets", "by")
