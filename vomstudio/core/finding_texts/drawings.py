"""Texts of the findings about drawings."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "rose.rows-left-out": (
        "warning",
        *to_translate_n(
            "{set}: {count} row without azimuth or weight is left out.",
            "{set}: {count} rows without azimuth or weight are left out.",
        ),
    ),
    "rose.no-azimuth": (
        "warning",
        to_translate("{set} has no rose: none of its rows has an azimuth and a weight."),
    ),
    "contours.none": (
        "warning",
        to_translate("The density does not reach any contour level. Use lower levels."),
    ),
    "drawing.unchanged": (
        "info",
        to_translate("Features of the project that the drawing shows unchanged: {count}."),
    ),
    "drawing.edited": (
        "warning",
        to_translate(
            "Traces that were edited in the drawing: {names} ({count} in all). Update edited traces"
            " (--update) changes them in the project."
        ),
    ),
    "drawing.added": (
        "info",
        *to_translate_n(
            "Added {count} trace on {model}.",
            "Added {count} traces on {model}.",
        ),
    ),
    "drawing.no-lines": (
        "warning",
        to_translate(
            "{count} bodies and surfaces of the drawing are left out ({entities}): they have no"
            " lines."
        ),
    ),
    "drawing.only-bodies": (
        "error",
        to_translate(
            "The drawing has no such lines, only {count} bodies and surfaces ({entities}). Extract"
            " their edges as lines in CAD."
        ),
    ),
    "drawing.unreadable": (
        "error",
        to_translate(
            "The file cannot be read as a drawing. Save it as GeoPackage, GeoJSON, shapefile, DXF"
            " or SVG."
        ),
    ),
    "drawing.splines": (
        "error",
        *to_translate_n(
            "{count} spline has only the points that it goes through. Turn it into a polyline and"
            " save the drawing again.",
            "{count} splines have only the points that they go through. Turn them into polylines"
            " and save the drawing again.",
        ),
    ),
    "drawing.nested-blocks": (
        "error",
        to_translate(
            "Blocks of the drawing contain each other so often that they become {count} entities."
            " Save it without nested blocks (exploded)."
        ),
    ),
    "drawing.no-polygons": (
        "error",
        to_translate("The file contains no polygons. Draw one around the area."),
    ),
    "drawing.no-traces": (
        "error",
        to_translate("The file contains no lines. Save the traces as lines, one for each trace."),
    ),
    "drawing.zero-length": (
        "error",
        to_translate("All lines have zero length. Pass at least one line with a length."),
    ),
    "drawing.several-layers": (
        "error",
        to_translate("The file has several layers: {layers}. Name one of them."),
    ),
    "drawing.paper-space": (
        "warning",
        *to_translate_n(
            "{count} shape of a sheet (paper space) is left out.",
            "{count} shapes of sheets (paper space) are left out.",
        ),
    ),
    "drawing.hidden": (
        "warning",
        *to_translate_n(
            "{count} shape that is hidden (off, frozen) is left out.",
            "{count} shapes that are hidden (off, frozen) are left out.",
        ),
    ),
    "drawing.dimensions": (
        "warning",
        to_translate("The dimensions and leaders of the drawing are left out."),
    ),
    "drawing.other-shapes": (
        "warning",
        *to_translate_n(
            "{count} shape of another kind is left out.",
            "{count} shapes of another kind are left out.",
        ),
    ),
    "drawing.invalid-shapes": (
        "warning",
        *to_translate_n(
            "{count} shape without length or area, or without finite coordinates, is left out.",
            "{count} shapes without length or area, or without finite coordinates, are left out.",
        ),
    ),
    "drawing.lines-as-area": (
        "info",
        *to_translate_n(
            "{count} closed line was taken as the outline of the area.",
            "{count} closed lines were taken as outlines of the area.",
        ),
    ),
    "drawing.separate-parts": (
        "warning",
        to_translate(
            "Parts of features that do not join count as separate traces: {count} more than"
            " features."
        ),
    ),
    "drawing.duplicates": (
        "warning",
        *to_translate_n(
            "{count} shape that is drawn twice counts once.",
            "{count} shapes that are drawn twice count once.",
        ),
    ),
}
