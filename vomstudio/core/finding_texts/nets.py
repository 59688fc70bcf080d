"""Texts of the findings about stereonets, rose diagrams and their figures."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "net.not-three-numbers": (
        "error",
        to_translate("“{text}” is not three numbers such as 125/26/30. Correct it."),
    ),
    "net.number-of-planes": (
        "error",
        to_translate(
            "Intersections are drawn of 2 to {maximum} planes, but there are {count}. Choose other"
            " planes."
        ),
    ),
    "net.no-errors": (
        "error",
        to_translate(
            "The table has no errors of planes. Add the columns {columns}, as in tables that this"
            " program writes."
        ),
    ),
    "net.too-many-levels": (
        "error",
        to_translate("There are {count} levels of contours. Use at most {maximum}."),
    ),
    "net.nowhere-dense": ("info", to_translate("Nowhere dense enough for a contour.")),
    "net.no-girdle": ("info", to_translate("No girdle (K above 1): {sets}")),
    "rose.several-sets": (
        "error",
        to_translate("Axes contain one rose, but the table has the sets {sets}. Select one."),
    ),
    "rose.left-out": (
        "info",
        *to_translate_n(
            "{count:,} without such an angle is left out.",
            "{count:,} without such an angle are left out.",
        ),
    ),
    "rose.left-out-by-length": (
        "info",
        *to_translate_n(
            "{count:,} without such an angle or a length is left out.",
            "{count:,} without such an angle or a length are left out.",
        ),
    ),
    "net.few-for-contours": (
        "warning",
        to_translate(
            "{set}: {count} orientations are few for contours; the counting circle covers"
            " {share_percent:.0f} % of the net."
        ),
    ),
    "net.not-levels": (
        "error",
        to_translate("“{text}” is not a list of levels above 0. Write it like 2,4,6."),
    ),
    "rose.uneven-bins": (
        "error",
        to_translate(
            "Bins of {bin_deg:g}° do not divide {range_deg:g}° evenly. Use a width such as 5, 10,"
            " 15 or 30."
        ),
    ),
    "figure.not-a-color": (
        "error",
        to_translate("“{text}” is not the colour of a set. Write it like Bedding=#0072b2."),
    ),
    "rose.no-lines": (
        "error",
        to_translate("The table has no lines with such an angle. For planes use --of strike."),
    ),
    "rose.no-planes": (
        "error",
        to_translate("The table has no planes with a strike. For lines use --of trend."),
    ),
    "figure.no-font": (
        "error",
        to_translate("The font “{font}” is not installed. Install it, or choose another."),
    ),
    "figure.not-a-size": (
        "error",
        to_translate("“{text}” is not a size in millimetres. Write it like 170x115."),
    ),
}
