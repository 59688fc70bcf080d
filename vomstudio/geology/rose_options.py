"""Options of rose diagrams and histograms, declared once for all interfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.options import Options, option
from vomstudio.core.words import to_translate


@dataclass(frozen=True)
class RoseOptions(Options):
    """Angle, bins and weights of rose diagrams and histograms.

    Raises
    ------
    UsageError
        If a value is outside its bounds, or if the bins do not divide the range evenly.
    """

    of: Literal["strike", "dip-direction", "trend", "dip", "plunge"] | None = option(
        None,
        help=to_translate("angle to plot; dip and plunge give a histogram"),
        automatic_text=to_translate("strike; trend if all rows are lines"),
    )
    bin_deg: float = option(
        10.0,
        minimum=1.0,
        maximum=90.0,
        help=to_translate("bin width, a divisor of 180, or of 90 for a histogram"),
    )
    weight: str | None = option(
        None,
        metavar="COLUMN",
        help=to_translate("weight each row by this column, such as extent_m"),
    )
    by: str | None = option(
        None, metavar="COLUMN", help=to_translate("draw a rose for each value of this column")
    )
    scale: Literal["area", "length"] = option(
        "area", help=to_translate("make petal area or petal length proportional to the share")
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_bins(self.bin_deg, 90.0 if self.of in ("dip", "plunge") else 180.0)


def check_bins(bin_deg: float, range_deg: float) -> None:
    """Check that bins of a given width divide a range evenly.

    Parameters
    ----------
    bin_deg : float
        Width of a bin.
    range_deg : float

    Raises
    ------
    UsageError
        If the bins do not divide the range evenly.
    """
    bins = round(range_deg / bin_deg) if 1.0 <= bin_deg <= range_deg / 2.0 else 0
    if not bins or abs(bins * bin_deg - range_deg) > 1e-9:
        finding = Finding("rose.uneven-bins", bin_deg=bin_deg, range_deg=range_deg)
        raise UsageError(finding, field="--bin")
