"""Options for proposing sets, declared once for all interfaces."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.options import Options, check_exclusive, option
from vomstudio.core.words import to_translate

DEFAULT_MAX_SETS = 8


@dataclass(frozen=True)
class SetOptions(Options):
    """Options for proposing sets: their number or seeds, and a scanline for their spacing.

    Raises
    ------
    UsageError
        If a value is outside its bounds, or if `exactly` is combined with `max_sets` or
        `seeds`.
    """

    max_sets: int | None = option(
        None,
        minimum=1,
        help=to_translate("maximum number of proposed sets"),
        automatic_text=str(DEFAULT_MAX_SETS),
    )
    exactly: int | None = option(
        None,
        minimum=1,
        label=to_translate("Sets"),
        help=to_translate("propose exactly this number of sets (at most the number of planes)"),
        tip=to_translate("Number of sets (automatic: the most likely number)"),
    )
    seeds: str | None = option(
        None,
        metavar="DD/D,...",
        label=to_translate("Seeds"),
        tip=to_translate("Dip direction/dip of one plane per set, instead of a number"),
        empty_text="120/45, 300/80",
        help=to_translate("one plane per set, such as 120/45,300/80, instead of a number"),
    )
    scanline: str | None = option(
        None,
        metavar="X,Y,Z,X,Y,Z",
        help=to_translate(
            "also report the spacing of each set along the line between these points"
        ),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_exclusive(self, "exactly", "max_sets")
        check_exclusive(self, "exactly", "seeds")
