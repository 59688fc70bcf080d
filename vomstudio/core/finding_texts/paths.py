"""Texts of the findings about traces followed or proposed on a model or in a photo."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "path.off-model": (
        "error",
        to_translate(
            "Way-point {number} is {distance_m:.3g} m from the model (maximum {maximum_m:.3g}"
            " m). Give points on its surface, in its frame."
        ),
    ),
    "path.separate-parts": (
        "error",
        to_translate(
            "Way-points {first} and {second} are on separate parts of the model. Set way-points"
            " on one part."
        ),
    ),
    "path.beside-model": (
        "error",
        to_translate("The line in the photo does not cross the model. Draw it on the rock."),
    ),
    "path.outside-photo": (
        "error",
        to_translate("Way-point {number} is outside the photo {photo}. Give points inside."),
    ),
    "path.point-beside-model": (
        "error",
        to_translate(
            "Way-point {number} is off the model in the photo {photo}. Give points on the rock."
        ),
    ),
    "path.not-connected": (
        "error",
        to_translate(
            "Two way-points are not connected in the photo. Set them closer to each other."
        ),
    ),
    "path.not-shown": (
        "error",
        to_translate(
            "The photo {photo} does not show way-point {number}. Choose a photo that shows all"
            " of them."
        ),
    ),
    "path.no-surface": (
        "error",
        to_translate("The model has no surface that a path could follow. Choose another model."),
    ),
    "network.inputs-outputs": (
        "error",
        to_translate(
            "The network has {inputs} inputs and {outputs} outputs. One picture and one map of"
            " edges are needed."
        ),
    ),
    "network.input-shape": (
        "error",
        to_translate("The network takes {shape}. A picture of 1 x 3 x height x width is needed."),
    ),
    "network.input-size": (
        "error",
        to_translate(
            "The network takes pictures with sides of {side} pixels. Sides of {minimum} to"
            " {maximum} are possible."
        ),
    ),
    "network.not-loaded": (
        "error",
        to_translate(
            "OpenCV cannot load this network ({reason}). Export it again, with its weights"
            " inside and for an older opset."
        ),
    ),
    "network.failed": (
        "error",
        to_translate(
            "The network fails on a picture of {width} x {height} pixels ({reason}). Export it"
            " again."
        ),
    ),
    "network.output-shape": (
        "error",
        to_translate(
            "The network returns {shape} for a picture of {width} x {height} pixels. One"
            " probability for each pixel is needed."
        ),
    ),
    "network.not-finite": (
        "error",
        to_translate("The network returns values that are not numbers. Check its weights."),
    ),
    "network.not-probabilities": (
        "error",
        to_translate(
            "The network returns values from {low:.3g} to {high:.3g}. A probability is from 0"
            " to 1: end the network with a sigmoid."
        ),
    ),
    "path.no-other-photo": (
        "info",
        to_translate("No other photo shows the place, so none confirms the line."),
    ),
    "path.pixels-beside-model": (
        "warning",
        *to_translate_n(
            "{count} pixel of the line is off the model and was left out.",
            "{count} pixels of the line are off the model and were left out.",
        ),
    ),
    "path.hidden-rock": (
        "warning",
        *to_translate_n(
            "The line crosses {count} edge behind which rock is hidden in the photo. The trace"
            " is straight across it ({gap_m:.2g} m).",
            "The line crosses {count} edges behind which rock is hidden in the photo. The trace"
            " is straight across them (up to {gap_m:.2g} m).",
        ),
    ),
    "path.unconfirmed": (
        "warning",
        to_translate(
            "Other photos confirm only {share_percent:.0f} % of the line: elsewhere the model is"
            " inaccurate, or something moved. Look at the line in these photos."
        ),
    ),
    "path.reduced": (
        "warning",
        to_translate(
            "The model has {points:,} points. Lines were proposed from {used:,} of them, so the"
            " finest are missing."
        ),
    ),
}
