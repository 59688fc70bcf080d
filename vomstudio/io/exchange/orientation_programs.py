"""Planes and lines for Stereonet, Orient and GeMS.

- Stereonet (R. W. Allmendinger, N. Cardozo): tab-separated text with two named columns, planes by
  the right-hand rule, one kind of data per file.
- Orient (F. W. Vollmer): tab-separated text whose header defines the columns (Orient user manual,
  appendix "Data File Format"): Station, X, Y, Z, the angles of a plane and of a line, Type, Domain,
  Comment.
- GeMS (U.S. Geological Survey 2020, Techniques and Methods 11-B10): fields of the feature class
  OrientationPoints, in order, followed by the coordinates. As in the standard, -9 stands for
  unknown numbers and # for unknown words.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from vomstudio.io.exchange.columns import Row, delimited_text, label, round_angle

ORIENT_COLUMNS = (
    "Station",
    "X",
    "Y",
    "Z",
    "Dip Direction",
    "Dip",
    "Trend",
    "Plunge",
    "Type",
    "Domain",
    "Comment",
)
GEMS_COLUMNS = (
    "Type",
    "Azimuth",
    "Inclination",
    "Symbol",
    "Label",
    "LocationConfidenceMeters",
    "IdentityConfidence",
    "OrientationConfidenceDegrees",
    "PlotAtScale",
    "StationsID",
    "MapUnit",
    "LocationSourceID",
    "OrientationSourceID",
    "Notes",
    "OrientationPoints_ID",
)

UNKNOWN_NUMBER, UNKNOWN_WORD = -9, "#"
_BEDDING_SYMBOLS = {
    "horizontal": "06.01",
    "inclined": "06.02",
    "vertical": "06.03",
    "overturned": "06.04",
}
"""Symbols of the FGDC Digital Cartographic Standard for Geologic Map Symbolization, section 6."""
MIN_VERTICAL_DIP_DEG, MAX_HORIZONTAL_DIP_DEG = 89.5, 0.5


def is_plane(row: Row) -> bool:
    """Return whether a row of the orientation table is a plane."""
    return bool(row["element"] == "plane")


def stereonet_planes(rows: Sequence[Row]) -> str:
    """Return the table of strikes (right-hand rule) and dips."""
    records = [
        (round_angle(row["strike_rhr_deg"]), round_angle(row["dip_deg"]), label(row))
        for row in rows
    ]
    return delimited_text(("strike", "dip", "label"), records, "\t")


def stereonet_lines(rows: Sequence[Row]) -> str:
    """Return the table of trends and plunges."""
    records = [
        (round_angle(row["trend_deg"]), round_angle(row["plunge_deg"]), label(row)) for row in rows
    ]
    return delimited_text(("trend", "plunge", "label"), records, "\t")


def orient_table(rows: Sequence[Row]) -> str:
    """Return the table of planes and lines; a line on a plane has the angles of both."""
    return delimited_text(ORIENT_COLUMNS, [_orient_row(row) for row in rows], "\t")


def _orient_row(row: Row) -> list[Any]:
    if is_plane(row):
        plane = (row["dip_direction_deg"], row["dip_deg"])
    else:
        plane = (row["on_plane_dip_direction_deg"], row["on_plane_dip_deg"])
    line = (row["trend_deg"], row["plunge_deg"])
    return [
        row.get("station") or label(row),
        row["x"],
        row["y"],
        row["z"],
        *map(round_angle, (*plane, *line)),
        row["kind"],
        row.get("domain"),
        row["notes"],
    ]


def gems_table(rows: Sequence[Row]) -> str:
    """Return the table of features that have a position, as required for points on a map."""
    names = (*GEMS_COLUMNS, "X", "Y", "Z")
    return delimited_text(
        names, [[*_gems_row(row), row["x"], row["y"], row["z"]] for row in rows], ","
    )


def _gems_row(row: Row) -> list[Any]:
    is_plane_row = is_plane(row)
    azimuth, inclination = (
        (row["strike_rhr_deg"], row["dip_deg"])
        if is_plane_row
        else (row["trend_deg"], row["plunge_deg"])
    )
    if is_plane_row and row["undefined"]:
        azimuth = 0.0
    error = row["total95_deg"]
    return [
        row["kind"] or UNKNOWN_WORD,
        round_angle(azimuth),
        round_angle(inclination),
        _symbol(row),
        str(round(inclination)),
        UNKNOWN_NUMBER,
        "certain" if row["kind"] else "unspecified",
        UNKNOWN_NUMBER if error is None else round_angle(error),
        0,
        None,
        UNKNOWN_WORD,
        UNKNOWN_WORD,
        UNKNOWN_WORD,
        "; ".join(filter(None, (label(row), row["notes"]))),
        row["id"],
    ]


def _symbol(row: Row) -> str | None:
    """Return the FGDC symbol of a bedding plane, or None for other features.

    The names of other types are user-defined, so their symbols are not known.
    """
    if not is_plane(row) or (row["kind"] or "").casefold() != "bedding":
        return None
    if row["overturned"]:
        return _BEDDING_SYMBOLS["overturned"]
    if row["dip_deg"] < MAX_HORIZONTAL_DIP_DEG:
        return _BEDDING_SYMBOLS["horizontal"]
    return _BEDDING_SYMBOLS["vertical" if row["dip_deg"] > MIN_VERTICAL_DIP_DEG else "inclined"]
