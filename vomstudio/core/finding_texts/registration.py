"""Texts of the findings about registrations."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.words import to_translate

TEXTS: dict[str, Entry] = {
    "registration.other-model": (
        "warning",
        to_translate(
            "{file} belongs to other files ({models}), so its errors are not used. Register the"
            " model again, or delete the file."
        ),
    ),
    "registration.damaged": (
        "warning",
        to_translate(
            "{file} cannot be used: {reason}. The model has no errors of registration. Restore the"
            " file, or register the model again."
        ),
    ),
    "registration.unknown-version": (
        "warning",
        to_translate(
            "{file} has version {version}, this program reads {known}. Its registration is not"
            " used. Update the program."
        ),
    ),
    "registration.other-frame": (
        "warning",
        to_translate(
            "The registration in {file} is not used: it places the model in {crs}, but {stated} is"
            " stated. Correct one of them."
        ),
    ),
    "registration.incomplete": (
        "warning",
        to_translate(
            "The earlier registration in {file} is not used for what the new one leaves free,"
            " because the coordinates of the file are not those of World."
        ),
    ),
    "registration.reference-error": (
        "info",
        to_translate(
            "With the error of the reference the model may be turned by {rotation95_deg:.2g}°"
            " (95 %) and its scale may be off by {scale95_percent:.2g} %."
        ),
    ),
    "registration.compass-alone": (
        "warning",
        to_translate(
            "North rests on compass readings alone: a common offset of ± {north_sigma_deg:g}°"
            " (1 sigma) is assumed. State how far they may all be off (--north-sigma)."
        ),
    ),
    "registration.parallel-level-lines": (
        "warning",
        to_translate(
            "The level lines run within {apart_deg:.0f}° of each other and count as one. Add a"
            " level line across them, or a plumb line."
        ),
    ),
    "registration.photo-upright": (
        "info",
        to_translate(
            "How the photos were held counts as an observation of the vertical, ± {sigma_deg:g}°"
            " (1 sigma)."
        ),
    ),
    "registration.which-end-up": (
        "warning",
        to_translate(
            "The lines tip the model by {tip_deg:.0f}° and do not show which end is up. Check that"
            " the model is not upside down."
        ),
    ),
    "registration.poor": (
        "warning",
        to_translate(
            "The model may be turned by {rotation95_deg:.2g}° (95 %), which makes planes on it"
            " poor. Add points, lines or readings."
        ),
    ),
}
