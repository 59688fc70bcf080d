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
    "log.line-not-given": (
        "error",
        to_translate("A log of a project needs one of its lines. Name it with --line."),
    ),
    "log.no-bed": (
        "error",
        to_translate("A log of a table needs the attitude of its beds. Give it with --bed DD/D."),
    ),
    "log.not-a-project": (
        "error",
        to_translate(
            "This option is for a line of a project, and {table} is a table. Leave it out."
        ),
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
}
