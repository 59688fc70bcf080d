"""Texts of the findings about the notation of orientations."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "vector.invalid": (
        "error",
        to_translate("The {name} must be three finite numbers that are not all zero. Correct it."),
    ),
    "notation.empty": (
        "error",
        to_translate("The orientation is empty. Enter it in the form 132/41."),
    ),
    "notation.not-a-plane": (
        "error",
        to_translate(
            "“{text}” is not a plane. Use a form such as 132/41, 042/41 RHR, 042/41 SE or N42E"
            " 41SE."
        ),
    ),
    "notation.not-a-line": (
        "error",
        to_translate(
            "“{text}” is not a line. Use a form such as 130/25 (trend/plunge), 25 → 130 or N50W 25."
        ),
    ),
    "notation.not-an-azimuth": (
        "error",
        to_translate("“{text}” is not an azimuth. Use a form such as 045, N45E or NW."),
    ),
    "notation.not-a-rake": (
        "error",
        to_translate(
            "“{text}” is not a rake. Use a form such as 100, or 80E from one end of the strike."
        ),
    ),
    "notation.not-an-angle": (
        "error",
        to_translate("“{text}” is not an angle. Use a form such as 45 or 7°30'."),
    ),
    "notation.signed-azimuth": (
        "error",
        to_translate(
            "The azimuth in “{text}” has a sign. Enter a value from 0 to 360, without a sign."
        ),
    ),
    "notation.signed-dip": (
        "error",
        to_translate("The dip in “{text}” has a sign. Enter a value from 0 to 90, without a sign."),
    ),
    "notation.unclear-minus": (
        "error",
        to_translate(
            "The hyphen in “{text}” may be a minus sign or a separator. Enter 130/-25 or 130/25."
        ),
    ),
    "notation.no-quadrant": (
        "error",
        to_translate("“{text}” has no dip quadrant. Add it, as in N42E 41SE."),
    ),
    "notation.needless-quadrant": (
        "error",
        to_translate("“{text}” has a dip direction and a quadrant. Remove the quadrant."),
    ),
    "notation.one-angle": (
        "error",
        to_translate("“{text}” contains only one angle. Enter two, as in {example}."),
    ),
    "notation.other-side": (
        "error",
        to_translate(
            "A plane with strike {strike} cannot dip towards {side} (“{text}”). Enter dip direction"
            " and dip without a quadrant, as in 132/41."
        ),
    ),
    "notation.unknown-word": (
        "error",
        to_translate(
            "“{word}” in “{text}” is not a number, compass direction, angle name or hand rule (RHR,"
            " LHR). Correct it."
        ),
    ),
    "notation.lone-direction": (
        "error",
        to_translate(
            "“{text}” has a direction but no dip. Use the form “dip direction 132, dip 41”."
        ),
    ),
    "notation.no-number": (
        "error",
        to_translate("“{label}” in “{text}” is not followed by a number. Add one."),
    ),
    "notation.bearing-out-of-range": (
        "error",
        to_translate("The angle of {bearing} in “{text}” is not between 0 and 90. Correct it."),
    ),
    "notation.azimuth-out-of-range": (
        "error",
        to_translate(
            "The azimuth {azimuth_deg:g} in “{text}” is not between 0 and 360. Correct it."
        ),
    ),
    "notation.rake-out-of-range": (
        "error",
        to_translate(
            "The rake {rake_deg:g} in “{text}” is over 90. Measured from one end of the strike, it"
            " ranges from 0 to 90."
        ),
    ),
    "notation.not-an-end": (
        "error",
        to_translate(
            "{end} is not an end of the strike {strike_deg:azimuth} (“{text}”). Specify one of"
            " its ends."
        ),
    ),
    "notation.plunge-out-of-range": (
        "error",
        to_translate(
            "The plunge {plunge_deg:g} in “{text}” is over 90. Enter the trend first, as in"
            " 130/25, or use an arrow, as in 25 → 130."
        ),
    ),
    "notation.dip-out-of-range": (
        "error",
        to_translate(
            "The dip {dip_deg:g} in “{text}” is over 90. Enter 132/41 (azimuth first) or 41 → 132."
            " For an overturned bed, set the overturned flag."
        ),
    ),
}
