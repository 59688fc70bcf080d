"""Options of the analysis of fracture traces, declared once for all interfaces."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.options import Options, check_exclusive, option
from vomstudio.core.words import to_translate


@dataclass(frozen=True)
class FractureOptions(Options):
    """Sampling region, plane, sets and weights of traces; None selects the default.

    Raises
    ------
    UsageError
        If a value is outside its bounds, or if `by` is combined with `strikes`.
    """

    area: str | None = option(
        None,
        metavar="POLYGON",
        help=to_translate(
            "file with the mapped area, to which traces are clipped; closed lines are used if it"
            " has no polygon"
        ),
    )
    circle: str | None = option(
        None,
        metavar="X,Y,R",
        help=to_translate(
            "circle instead of an area: centre and radius in metres (X,Y,Z,R on a plane)"
        ),
    )
    scanline: str | None = option(
        None, metavar="LINE", help=to_translate("file with one or more scanlines")
    )
    plane: str | None = option(
        None,
        metavar="DD/D",
        help=to_translate(
            "plane on which three-dimensional lines are analysed; 000/00 is the map plane"
        ),
        automatic_text=to_translate("best-fit plane, if the lines are three-dimensional"),
    )
    snap_m: float = option(
        0.0,
        minimum=0.0,
        label=to_translate("Snap"),
        help=to_translate("maximum distance between a trace end and the trace it abuts, m"),
        tip=to_translate("Maximum distance between a trace end and the trace it abuts"),
    )
    by: str | None = option(
        None,
        metavar="COLUMN",
        help=to_translate("attribute that names the sets"),
        automatic_text=to_translate("set, if present"),
    )
    strikes: str | None = option(
        None,
        metavar="A-B,...",
        help=to_translate(
            "ranges of strike that define the sets, clockwise, such as 340-020,060-100"
        ),
    )
    terzaghi_cap: float | None = option(
        None,
        minimum=1.0,
        metavar="W",
        label=to_translate("Cap"),
        help=to_translate("maximum Terzaghi weight"),
        tip=to_translate("Maximum Terzaghi weight"),
        automatic_text=to_translate("no maximum"),
    )
    layer: str | None = option(
        None,
        metavar="NAME",
        help=to_translate("layer of the traces, if their file has several"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_exclusive(self, "by", "strikes")
