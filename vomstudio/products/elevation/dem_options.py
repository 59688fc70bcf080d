"""Options of elevation models, shared by all interfaces."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.options import MAX_LENGTH_M, MIN_LENGTH_M, Options, option
from vomstudio.core.words import to_translate


@dataclass(frozen=True)
class DemOptions(Options):
    """Grid and reference plane of an elevation model.

    Raises
    ------
    UsageError
        If a value is out of bounds.
    """

    gsd_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        label=to_translate("Cell"),
        help=to_translate("cell size, m"),
        tip=to_translate("Cell size"),
        automatic_text=to_translate("mean edge length of a mesh, or mean spacing of a cloud"),
        empty_text=to_translate("model resolution"),
        decimals=4,
    )
    plane: str | None = option(
        None,
        metavar="DD/D",
        help=to_translate("reference plane, dip direction and dip"),
        automatic_text=to_translate("horizontal"),
    )
    limit_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        label=to_translate("Limit"),
        help=to_translate(
            "longest triangle side between points of a cloud; larger gaps remain open, m"
        ),
        tip=to_translate("Longest triangle side between points; larger gaps remain open"),
        automatic_text=to_translate("five times the mean point spacing"),
        decimals=4,
    )


@dataclass(frozen=True)
class DemFiles(Options):
    """Files to write in addition to the heights.

    Raises
    ------
    UsageError
        If a value is out of bounds.
    """

    hillshade: bool = option(
        False,
        label=to_translate("Hillshade"),
        help=to_translate(
            "also write a hillshade, NAME_hillshade.tif, lit from the upper left at 45°"
        ),
        tip=to_translate("Write a hillshade, lit from the upper left"),
    )
    slope: bool = option(
        False,
        label=to_translate("Slope"),
        help=to_translate("also write the surface dip in degrees, NAME_slope.tif"),
        tip=to_translate("Write the dip of the surface"),
    )
    aspect: bool = option(
        False,
        label=to_translate("Aspect"),
        help=to_translate("also write the surface dip direction in degrees, NAME_aspect.tif"),
        tip=to_translate("Write the dip direction of the surface"),
    )
    contours_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        label=to_translate("Contours"),
        help=to_translate("also write contours with this interval, m, to NAME_contours.gpkg"),
        tip=to_translate("Contour interval"),
        empty_text=to_translate("none"),
    )
