"""Style of a lithology in a log: colour, ornament, and bed width by grain size.

The ornaments follow the standard for maps (Federal Geographic Data Committee 2006, Digital
cartographic standard for geologic map symbolization, section 37): dots for sand, dashes for mud,
bricks for limestone, and slanting bricks for dolostone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from vomstudio.core.words import to_translate

Ornament = Literal["", "bricks", "slanting bricks", "cross"]

GRAIN_SIZES = (
    to_translate("clay"),
    to_translate("silt"),
    to_translate("sand"),
    to_translate("gravel"),
)
DUNHAM_CLASSES = {
    "M": to_translate("mudstone"),
    "W": to_translate("wackestone"),
    "P": to_translate("packstone"),
    "G": to_translate("grainstone"),
    "R": to_translate("rudstone or coarser"),
}
"""Names of Dunham's classes by their letters, from fine to coarse."""
DEFAULT_WIDTH = 0.5
"""Width of a bed without a grain size."""


@dataclass(frozen=True)
class LithologyStyle:
    """Style of a lithology.

    Parameters
    ----------
    color : str
    hatch : str
        Hatch pattern of matplotlib.
    ornament : str
        Name of an ornament drawn by `bed_log_figure`.
    width : float or None
        Width of the bed as a share of the column, 0 to 1; None if the grain size is unknown.
    is_dunham : bool
        Whether the width follows Dunham's classification.
    """

    color: str
    hatch: str = ""
    ornament: Ornament = ""
    width: float | None = None
    is_dunham: bool = False


_SILICICLASTIC_STYLES = {
    "claystone": LithologyStyle("#c9c4bd", "---", width=0.25),
    "mudstone": LithologyStyle("#bdb8ae", "--", width=0.25),
    "shale": LithologyStyle("#a9a69f", "----", width=0.25),
    "siltstone": LithologyStyle("#ddd2b0", "-.", width=0.5),
    "sandstone": LithologyStyle("#f6e7a1", "...", width=0.75),
    "conglomerate": LithologyStyle("#eec58b", "oo", width=1.0),
    "breccia": LithologyStyle("#e6b48a", "OO", width=1.0),
}
_DUNHAM_WIDTHS = {
    "mudstone": 0.2,
    "wackestone": 0.4,
    "packstone": 0.6,
    "grainstone": 0.8,
    "floatstone": 1.0,
    "rudstone": 1.0,
    "boundstone": 1.0,
    "framestone": 1.0,
    "bafflestone": 1.0,
    "bindstone": 1.0,
}
_PRIMARY_STYLES = {
    "siliciclastic": LithologyStyle("#eadfae", "."),
    "limestone": LithologyStyle("#bcd9ea", ornament="bricks"),
    "dolostone": LithologyStyle("#d4c3e2", ornament="slanting bricks"),
    "organic_coal": LithologyStyle("#3c3c3c"),
    "evaporite": LithologyStyle("#f1d3e0", "++"),
    "chert": LithologyStyle("#e6cfc0", "//"),
    "ironstone": LithologyStyle("#d9a58e", "||"),
    "phosphatic": LithologyStyle("#cbb8a0", "**"),
    "volcaniclastic": LithologyStyle("#c3dcb4", "xx"),
}
_COVERED_STYLE = LithologyStyle("#ffffff", ornament="cross")


def find_style(lithology: str, strabospot: Mapping[str, str]) -> LithologyStyle:
    """Return the style of a lithology given as text or in StraboSpot fields.

    Without these fields, the bed is white, with a cross if the text states that it is covered.
    """
    if not lithology.strip() or not strabospot.get("primary_lithology"):
        lithology_name = lithology.strip().casefold()
        return (
            _COVERED_STYLE
            if lithology_name in ("covered", "unexposed")
            else LithologyStyle("#ffffff")
        )
    primary = _PRIMARY_STYLES[strabospot["primary_lithology"]]
    siliciclastic_style = _SILICICLASTIC_STYLES.get(strabospot.get("siliciclastic_type", ""))
    if siliciclastic_style is not None:
        return siliciclastic_style
    width = _DUNHAM_WIDTHS.get(strabospot.get("dunham_classification", ""))
    if width is not None:
        return LithologyStyle(
            primary.color, primary.hatch, primary.ornament, width=width, is_dunham=True
        )
    return primary
