"""Texts of the findings about traces followed or proposed on a model or in a photo."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "path.off-model": (
        "error",
        to_translate(
            "Way-point {number} is {distance_m:.3g} m from the model (maximum {maximum_m:.3g} m)."
            " Place it on the surface, in the model's frame."
        ),
    ),
    "path.separate-parts": (
        "error",
        to_translate(
            "Way-points {first} and {second} are on separate parts of the model. Place all"
            " way-points on one part."
        ),
    ),
    "path.beside-model": (
        "error",
        to_translate("The line in the photo does not cross the model. Draw it on the rock."),
    ),
    "path.outside-photo": (
        "error",
        to_translate("Way-point {number} is outside the photo {photo}. Place it inside."),
    ),
    "path.point-beside-model": (
        "error",
        to_translate(
            "Way-point {number} is off the model in the photo {photo}. Place it on the rock."
        ),
    ),
    "path.not-connected": (
        "error",
        to_translate(
            "No path in the photo connects two of the way-points. Place them closer together."
        ),
    ),
    "path.not-shown": (
        "error",
        to_translate(
            "The photo {photo} does not show way-point {number}. Choose a photo that shows all"
            " way-points."
        ),
    ),
    "path.no-surface": (
        "error",
        to_translate("The model has no surface that a path could follow. Choose another model."),
    ),
    "network.inputs-outputs": (
        "error",
        to_translate(
            "The network has {inputs} inputs and {outputs} outputs. It must have one input picture"
            " and one output edge map."
        ),
    ),
    "network.input-shape": (
        "error",
        to_translate(
            "The network expects an input of shape {shape}. The shape must be 1 x 3 x height x"
            " width."
        ),
    ),
    "network.input-size": (
        "error",
        to_translate(
            "The network expects pictures with sides of {side} pixels. Only {minimum} to"
            " {maximum} are supported."
        ),
    ),
    "network.not-loaded": (
        "error",
        to_translate(
            "OpenCV cannot load this network ({reason}). Export it again with embedded weights"
            " and an older opset."
        ),
    ),
    "network.failed": (
        "error",
        to_translate(
            "The network failed on a picture of {width} x {height} pixels ({reason}). Export the"
            " network again."
        ),
    ),
    "network.output-shape": (
        "error",
        to_translate(
            "The network returns an output of shape {shape} for a picture of {width} x {height}"
            " pixels. It must return one probability per pixel."
        ),
    ),
    "network.not-finite": (
        "error",
        to_translate("The network returns values that are not finite. Check its weights."),
    ),
    "network.not-probabilities": (
        "error",
        to_translate(
            "The network returns values from {low:.3g} to {high:.3g}, which are not"
            " probabilities. Add a sigmoid as its last layer."
        ),
    ),
    "path.no-other-photo": (
        "info",
        to_translate("No other photo shows this part, so the line is not confirmed."),
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
            "The line crosses {count} edge behind which rock is hidden. The trace is straight"
            " across this gap ({gap_m:.2g} m).",
            "The line crosses {count} edges behind which rock is hidden. The trace is straight"
            " across these gaps (up to {gap_m:.2g} m).",
        ),
    ),
    "path.unconfirmed": (
        "warning",
        to_translate(
            "Other photos confirm only {share_percent:.0f} % of the line. Elsewhere the model is"
            " inaccurate, or something moved. Check the line in these photos."
        ),
    ),
    "path.reduced": (
        "warning",
        to_translate(
            "The model has {points:,} points, of which {used:,} were searched. The finest lines"
            " may be missing."
        ),
    ),
}
