"""Options of the comparison of two models, declared once for all interfaces."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.options import MAX_LENGTH_M, MIN_LENGTH_M, Options, option
from vomstudio.core.words import to_translate


@dataclass(frozen=True)
class CompareOptions(Options):
    """Kind of distances. Raises UsageError for a value outside its bounds."""

    m3c2_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        metavar="RADIUS",
        label=to_translate("Radius"),
        help=to_translate("use M3C2 with this cylinder radius, m; also gives a level of detection"),
        tip=to_translate("Cylinder radius; each cylinder should contain at least twenty points"),
        automatic_text=to_translate("distance to the nearest point of the benchmark"),
        empty_text=to_translate("nearest"),
    )
    registration_error_m: float | None = option(
        None,
        minimum=0.0,
        label=to_translate("Error (1σ)"),
        help=to_translate(
            "standard deviation of the position of one model relative to the other, for the level"
            " of detection, m"
        ),
        tip=to_translate("Standard deviation of one model's position relative to the other"),
        automatic_text=to_translate("from the model's registration or reconstruction, otherwise 0"),
        decimals=4,
    )
