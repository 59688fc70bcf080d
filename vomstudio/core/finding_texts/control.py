"""Texts of the findings about control points and marks."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.words import to_translate

TEXTS: dict[str, Entry] = {
    "control.swapped-columns": (
        "warning",
        to_translate(
            "Two axes of the coordinates look exchanged ({labels}), or heights are depths. Exchange"
            " the columns, or change the sign of the heights."
        ),
    ),
    "control.swapped-degrees": (
        "error",
        to_translate(
            "{label}: longitude {longitude:.4f} and latitude {latitude:.4f} look exchanged."
            " Exchange the columns."
        ),
    ),
    "control.other-unit": (
        "warning",
        to_translate(
            "Coordinates ({axes}) look like {unit}, not metres. Multiply them by {factor:.4g}."
        ),
    ),
    "control.far-away": (
        "warning",
        to_translate(
            "{labels}: {distance_m:,.0f} m from the other points, which lie within {extent_m:,.0f}"
            " m. Check the digits and the zone."
        ),
    ),
    "control.scale-of-unit": (
        "warning",
        to_translate(
            "The registration scales the model by {scale:.4g}, as from metres to {unit}. If the"
            " model is in metres, multiply the coordinates by {factor:.4g}."
        ),
    ),
    "control.some-in-degrees": (
        "warning",
        to_translate(
            "x and y of {labels} look like degrees, those of the others like metres. Convert them"
            " to the CRS of the others."
        ),
    ),
    "control.height-offset": (
        "warning",
        to_translate(
            "Heights of {labels} fit the others with {offset_m:+.3g} m added. Ellipsoidal and"
            " orthometric heights, or two benchmarks, may be mixed."
        ),
    ),
    "control.drift": (
        "warning",
        to_translate(
            "Errors of neighbouring control points are correlated ({correlation:.2f}), as by a"
            " drifting receiver. The stated errors include this. Use a base station."
        ),
    ),
    "control.click-error-unknown": (
        "info",
        to_translate(
            "The click on the model is taken as exact, since its resolution is not known. Give the"
            " click error if there is one."
        ),
    ),
    "control.marks-scattered": (
        "error",
        to_translate(
            "The marks of the control points are {scatter_px:.0f} px off each other: they cannot"
            " show the same points. Check labels, photos and poses."
        ),
    ),
    "control.few-marks": (
        "warning",
        to_translate(
            "Points with fewer than two right marks in photos of the model were not used: {labels}."
            " Mark them again."
        ),
    ),
    "control.marks-disagree": (
        "warning",
        to_translate(
            "The marks of these points do not meet in one place, so the points were not used:"
            " {labels}. Check their marks."
        ),
    ),
}
