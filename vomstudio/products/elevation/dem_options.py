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
        help=to_translate("side of a cell, m"),
        tip=to_translate("Side of a cell"),
        automatic=to_translate("the mean edge of a mesh, the mean spacing of a cloud"),
        empty_text=to_translate("as the model"),
        decimals=4,
    )
    plane: str | None = option(
        None,
        metavar="DD/D",
        help=to_translate("reference plane, dip direction and dip"),
        automatic=to_translate("the horizontal"),
    )
    limit_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        label=to_translate("Limit"),
        help=to_translate(
            "longest side of triangles between the points of a cloud; larger holes stay open, m"
        ),
        tip=to_translate("Longest side of triangles between points; larger holes stay open"),
        automatic=to_translate("five times the root of the area of one point"),
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
        help=to_translate("also NAME_hillshade.tif, light from the upper left, 45° high"),
        tip=to_translate("Write a hillshade, with light from the upper left"),
    )
    slope: bool = option(
        False,
        label=to_translate("Slope"),
        help=to_translate("also NAME_slope.tif, the dip of the surface, degrees"),
        tip=to_translate("Write the dip of the surface"),
    )
    aspect: bool = option(
        False,
        label=to_translate("Aspect"),
        help=to_translate("also NAME_aspect.tif, the dip direction of the surface, degrees"),
        tip=to_translate("Write the dip direction of the surface"),
    )
    contours_m: float | None = option(
        None,
        minimum=MIN_LENGTH_M,
        maximum=MAX_LENGTH_M,
        label=to_translate("Contours"),
        help=to_translate("also NAME_contours.gpkg, lines at multiples of this height, m"),
        tip=to_translate("Contour lines at multiples of this height"),
        empty_text=to_translate("none"),
    )
