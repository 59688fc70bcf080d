"""Texts of the findings about stereonets, rose diagrams and their figures."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "net.not-three-numbers": (
        "error",
        to_translate("“{text}” does not consist of three numbers. Use the form 125/26/30."),
    ),
    "net.number-of-planes": (
        "error",
        to_translate(
            "Intersections are drawn for 2 to {maximum} planes, but {count} are given. Change the"
            " number of planes."
        ),
    ),
    "net.no-errors": (
        "error",
        to_translate(
            "The table has no plane errors. Add the columns {columns}, as in tables written by"
            " this program."
        ),
    ),
    "net.too-many-levels": (
        "error",
        to_translate("There are {count} contour levels. Use at most {maximum}."),
    ),
    "net.nowhere-dense": (
        "info",
        to_translate("The density is below all contour levels."),
    ),
    "net.no-girdle": ("info", to_translate("Not a girdle (K above 1): {sets}")),
    "rose.several-sets": (
        "error",
        to_translate(
            "These axes can contain only one rose, but the table has the sets {sets}. Select one"
            " set, or omit ax."
        ),
    ),
    "rose.left-out": (
        "info",
        *to_translate_n(
            "{count:,} feature without this angle is left out.",
            "{count:,} features without this angle are left out.",
        ),
    ),
    "rose.left-out-by-length": (
        "info",
        *to_translate_n(
            "{count:,} feature without this angle or a length is left out.",
            "{count:,} features without this angle or a length are left out.",
        ),
    ),
    "net.few-for-contours": (
        "warning",
        to_translate(
            "{set}: {count} orientations are too few for reliable contours; the counting circle"
            " covers {share_percent:.0f} % of the net."
        ),
    ),
    "net.not-levels": (
        "error",
        to_translate("“{text}” is not a list of levels above 0. Use the form 2,4,6."),
    ),
    "rose.uneven-bins": (
        "error",
        to_translate(
            "{range_deg:g}° cannot be divided into bins of {bin_deg:g}°. Use a width such as 5, 10,"
            " 15 or 30."
        ),
    ),
    "figure.not-a-color": (
        "error",
        to_translate(
            "“{text}” does not specify the colour of a set. Use the form Bedding=#0072b2."
        ),
    ),
    "rose.no-lines": (
        "error",
        to_translate(
            "This angle is defined for lines only, but the table has none. For planes, use --of"
            " strike."
        ),
    ),
    "rose.no-planes": (
        "error",
        to_translate("The table has no planes with a strike. For lines, use --of trend."),
    ),
    "figure.no-font": (
        "error",
        to_translate("The font “{font}” is not installed. Install it, or choose another font."),
    ),
    "figure.not-a-size": (
        "error",
        to_translate("“{text}” is not a size in millimetres. Use the form 170x115."),
    ),
}
