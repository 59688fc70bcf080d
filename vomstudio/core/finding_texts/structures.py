"""Texts of the findings about folds, logs and slopes."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.words import to_translate

TEXTS: dict[str, Entry] = {
    "fold.too-few-planes": (
        "info",
        to_translate(
            "The axis rests on {n} planes, whose scatter is poorly known. Measure at least"
            " {wanted} before you rely on its 95 % error."
        ),
    ),
    "fold.too-few-sets": (
        "error",
        to_translate("Two or three different sets are needed, such as A,B."),
    ),
    "displacement.rake-without-strike": (
        "error",
        to_translate(
            "A horizontal fault has no strike to count a rake from. Give the trend and plunge of"
            " the slip."
        ),
    ),
    "slope.horizontal-face": (
        "error",
        to_translate("The face is horizontal, so nothing slides out of it. Give its dip."),
    ),
    "slope.pairs-of-one-set": (
        "info",
        to_translate(
            "{pairs:,} of {all_pairs:,} pairs are planes of one set; their intersections do not"
            " count as wedges."
        ),
    ),
    "fold.planes-not-good": (
        "warning",
        to_translate(
            "{not_good} of {used} planes of the fold axis are not good, and count like the others."
            " Improve them or leave them out."
        ),
    ),
    "log.beds-not-parallel": (
        "warning",
        to_translate(
            "The {count} traces of the bedding are not parallel, or too straight (±"
            " {error_deg:.1f}° at best). Take the plane of a bed."
        ),
    ),
    "displacement.no-pairs": (
        "error",
        to_translate(
            "Select two traces of one bed, on both sides of the fault, and add them. More "
            "pairs give a mean."
        ),
    ),
    "displacement.no-fault": (
        "error",
        to_translate("Select a plane that was picked on the fault, and take it."),
    ),
    "displacement.not-a-rake": (
        "error",
        to_translate(
            "{value:g} is not a rake from 0 to 180 degrees. Write a direction as trend and "
            "plunge, such as 120/45."
        ),
    ),
    "fold.needs-planes": (
        "error",
        to_translate(
            "A fold axis needs at least {minimum} bedding planes; there are {count}. Measure more."
        ),
    ),
    "fold.needs-selected-planes": (
        "error",
        to_translate(
            "A fold axis needs at least {minimum} selected bedding planes; there are "
            "{count}. Select more."
        ),
    ),
    "three-points.too-few": (
        "error",
        to_translate(
            "Pick three points or more of one surface on the outcrop, or type their coordinates."
        ),
    ),
    "three-points.no-error": (
        "info",
        to_translate(
            "Nothing is known of the error. State that of the points, or give more of them."
        ),
    ),
}
