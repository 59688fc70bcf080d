"""Texts of the findings about the notation of orientations."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "vector.invalid": (
        "error",
        to_translate("The {name} must be three finite numbers that are not all zero. Correct it."),
    ),
    "notation.empty": ("error", to_translate("The orientation is empty. Write it as 132/41.")),
    "notation.not-a-plane": (
        "error",
        to_translate(
            "“{text}” is not a plane. Write it as 132/41, 042/41 RHR, 042/41 SE or N42E 41SE."
        ),
    ),
    "notation.not-a-line": (
        "error",
        to_translate(
            "“{text}” is not a line. Write it as 130/25 (trend/plunge), 25 → 130 or N50W 25."
        ),
    ),
    "notation.not-an-azimuth": (
        "error",
        to_translate("“{text}” is not an azimuth. Write it as 045, N45E or NW."),
    ),
    "notation.not-a-rake": (
        "error",
        to_translate(
            "“{text}” is not a rake. Write it as 100, or as 80E from an end of the strike."
        ),
    ),
    "notation.not-an-angle": (
        "error",
        to_translate("“{text}” is not an angle. Write it as 45 or 7°30'."),
    ),
    "notation.signed-azimuth": (
        "error",
        to_translate("The azimuth in “{text}” has a sign. Write it from 0 to 360, without sign."),
    ),
    "notation.signed-dip": (
        "error",
        to_translate("The dip in “{text}” has a sign. Write it from 0 to 90, without sign."),
    ),
    "notation.unclear-minus": (
        "error",
        to_translate(
            "The minus in “{text}” may be a sign or a separator. Write 130/-25, or 130/25."
        ),
    ),
    "notation.no-quadrant": (
        "error",
        to_translate(
            "“{text}” lacks the quadrant to which the plane dips. Add it, as in N42E 41SE."
        ),
    ),
    "notation.needless-quadrant": (
        "error",
        to_translate("“{text}” has a dip direction and a quadrant. Leave out the quadrant."),
    ),
    "notation.one-angle": (
        "error",
        to_translate("“{text}” has only one angle. Write two, as in {example}."),
    ),
    "notation.other-side": (
        "error",
        to_translate(
            "A plane that strikes {strike} does not dip to {side} (“{text}”). A dip direction"
            " is written without a side, as in 132/41."
        ),
    ),
    "notation.unknown-word": (
        "error",
        to_translate(
            "“{word}” in “{text}” is not a number, compass point, rule or name of an angle."
            " Correct it."
        ),
    ),
    "notation.lone-direction": (
        "error",
        to_translate("“{text}” has a direction without dip. Write “dip direction 132, dip 41”."),
    ),
    "notation.no-number": (
        "error",
        to_translate("No number follows “{label}” in “{text}”. Add it."),
    ),
    "notation.bearing-out-of-range": (
        "error",
        to_translate("The angle of {bearing} in “{text}” is not from 0 to 90. Correct it."),
    ),
    "notation.azimuth-out-of-range": (
        "error",
        to_translate("The azimuth {azimuth_deg:g} in “{text}” is not from 0 to 360. Correct it."),
    ),
    "notation.rake-out-of-range": (
        "error",
        to_translate(
            "The rake {rake_deg:g} in “{text}” is over 90. From an end of the strike it is from"
            " 0 to 90."
        ),
    ),
    "notation.not-an-end": (
        "error",
        to_translate(
            "{end} is not an end of the strike {strike_deg:azimuth} (“{text}”). Name one of its"
            " ends."
        ),
    ),
    "notation.plunge-out-of-range": (
        "error",
        to_translate(
            "The plunge {plunge_deg:g} in “{text}” is over 90. Write the trend first, as in"
            " 130/25, or an arrow, as in 25 → 130."
        ),
    ),
    "notation.dip-out-of-range": (
        "error",
        to_translate(
            "The dip {dip_deg:g} in “{text}” is over 90. Write 132/41 (azimuth first) or 41 →"
            " 132. Overturned beds are flagged."
        ),
    ),
}
