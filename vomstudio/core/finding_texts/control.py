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
    "control.mark-scatter": (
        "warning",
        to_translate(
            "Marks of the control points scatter by {scatter_px:.0f} px. The stated errors include"
            " this. Check the marks, and the poses of the photos."
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
    "control.no-points": (
        "error",
        to_translate(
            "The file has no control points with coordinates. Add some, or choose another file."
        ),
    ),
    "control.no-marks": (
        "error",
        to_translate(
            "The file has no marks of control points in photos. Add some, or choose another file."
        ),
    ),
    "control.only-marks": (
        "error",
        to_translate(
            "The file has marks in photos and no control points. Use it as the file of marks."
        ),
    ),
    "control.only-points": (
        "error",
        to_translate(
            "The file has control points and no marks in photos. Use it as the file of control"
            " points."
        ),
    ),
    "control.unknown-format": (
        "error",
        to_translate("This is not a file of control points. Supported: {formats}."),
    ),
    "control.no-chunk": (
        "error",
        to_translate("The file has no chunk with markers. Export the markers in Metashape."),
    ),
    "control.several-chunks": (
        "error",
        to_translate("The file has {count} chunks with markers. Export the one that is needed."),
    ),
    "control.unknown-key": (
        "error",
        to_translate("{name} {key} is not in the file. Export it again."),
    ),
    "control.no-projection": (
        "error",
        to_translate(
            "The file does not begin with its projection, such as EPSG:32633 or WGS84 UTM 33N. Add"
            " it as the first line."
        ),
    ),
    "control.mark-repeated": (
        "error",
        to_translate(
            "'{label}' is already marked in {photo} (line {first_line}). Remove one of the marks."
        ),
    ),
    "control.other-coordinates": (
        "error",
        to_translate("'{label}' has other coordinates in line {first_line}. Correct one of them."),
    ),
    "control.repeated-point": (
        "error",
        to_translate("The point {label} is given twice. Leave one of them out."),
    ),
    "control.not-on-earth": (
        "error",
        to_translate(
            "{label} is not at a longitude and latitude. Correct its coordinates, or the CRS."
        ),
    ),
    "control.bar-of-one-point": (
        "error",
        to_translate("The scale bar begins and ends at {label}. Name two points."),
    ),
    "control.line-without-length": (
        "error",
        to_translate("Both ends of the line are at one place. Correct it."),
    ),
    "control.no-model-direction": (
        "error",
        to_translate(
            "Columns model_x, model_y and model_z must contain the normal of a plane, or the"
            " direction of a line, in the frame of the model."
        ),
    ),
    "control.no-photos": (
        "error",
        to_translate("There is no photo below the coordinate system. Add lines."),
    ),
}
