"""Texts of the findings about sets of planes."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "sets.too-many": (
        "error",
        to_translate("{n} planes cannot form {sets} sets. Use a smaller number."),
    ),
    "sets.too-many-seeds": (
        "error",
        to_translate("{seeds} seeds make more sets than {max_sets}. Leave out seeds."),
    ),
    "sets.seed-not-a-plane": (
        "error",
        to_translate("“{text}” is not a plane. Write dip direction/dip, such as 120/45,300/80."),
    ),
    "sets.equal-seeds": (
        "error",
        to_translate("Two seeds are less than 1 degree apart. Leave out one of them."),
    ),
    "sets.not-a-scanline": (
        "error",
        to_translate("A scanline is two different points in metres: x,y,z,x,y,z."),
    ),
    "sets.no-places": (
        "error",
        to_translate("A scanline requires the places of the planes. Add the columns x, y, z."),
    ),
    "sets.too-few-planes": (
        "error",
        *to_translate_n(
            "Sets need at least {minimum} planes; there is {count} here. Pick more, or "
            "choose others.",
            "Sets need at least {minimum} planes; there are {count} here. Pick more, or "
            "choose others.",
        ),
    ),
    "sets.too-few-without-set": (
        "error",
        *to_translate_n(
            "Sets need at least {minimum} planes, and {count} is without a set. Include "
            "those that have one already.",
            "Sets need at least {minimum} planes, and {count} are without a set. Include "
            "those that have one already.",
        ),
    ),
    "sets.replaced": (
        "info",
        *to_translate_n(
            "{count} plane has a set already, which accepting replaces.",
            "{count} planes have a set already, which accepting replaces.",
        ),
    ),
    "sets.left-out": (
        "info",
        *to_translate_n(
            "{count} plane has a set already and is left out.",
            "{count} planes have a set already and are left out.",
        ),
    ),
    "sets.types-pooled": (
        "info",
        to_translate("Types are pooled: {types}."),
    ),
    "sets.no-common-frame": (
        "info",
        to_translate(
            "No spacing: the planes are on several models that have no common coordinates."
        ),
    ),
    "sets.not-in-metres": (
        "info",
        to_translate("No spacing: the planes have no coordinates in metres."),
    ),
    "sets.partly-in-metres": (
        "info",
        *to_translate_n(
            "{count} plane has no coordinates in metres. The spacing is that of the others.",
            "{count} planes have no coordinates in metres. The spacing is that of the others.",
        ),
    ),
    "sets.none-distinct": (
        "info",
        to_translate(
            "No set stands out from an even scatter. A set needs at least {minimum} planes, "
            "or a seed."
        ),
    ),
    "sets.parallel": (
        "info",
        to_translate("Where all planes of a set are parallel, κ has no limit."),
    ),
    "sets.planes-changed": (
        "info",
        to_translate("The planes have changed. Propose sets again."),
    ),
    "sets.no-proposal": (
        "info",
        to_translate("There is no proposal. Propose sets first."),
    ),
    "repeats.none": (
        "info",
        to_translate(
            "Nothing was picked again yet. Choose Offer picks again: a tenth of the picks "
            "shows how far one may be off."
        ),
    ),
}
