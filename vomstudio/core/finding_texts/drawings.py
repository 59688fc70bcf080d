"""Texts of the findings about drawings."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "rose.rows-left-out": (
        "warning",
        *to_translate_n(
            "{set}: {count} row without an azimuth or weight is left out.",
            "{set}: {count} rows without an azimuth or weight are left out.",
        ),
    ),
    "rose.no-azimuth": (
        "warning",
        to_translate(
            "{set} has no rose diagram, because none of its rows has both an azimuth and a weight."
        ),
    ),
    "contours.none": (
        "warning",
        to_translate("The density does not reach any contour level. Use lower levels."),
    ),
    "drawing.unchanged": (
        "info",
        to_translate("Features that are the same in the drawing and the project: {count}."),
    ),
    "drawing.edited": (
        "warning",
        to_translate(
            "Traces edited in the drawing: {names} ({count} in all). Update edited traces"
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
            "{count} bodies and surfaces in the drawing have no lines and are left out"
            " ({entities})."
        ),
    ),
    "drawing.only-bodies": (
        "error",
        to_translate(
            "The drawing contains no lines, only {count} bodies and surfaces ({entities}). Extract"
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
            "{count} spline is stored only as points that it passes through. Convert it to a"
            " polyline and save the drawing again.",
            "{count} splines are stored only as points that they pass through. Convert them to"
            " polylines and save the drawing again.",
        ),
    ),
    "drawing.nested-blocks": (
        "error",
        to_translate(
            "The nested blocks of the drawing expand to {count} entities. Explode the blocks and"
            " save it again."
        ),
    ),
    "drawing.no-polygons": (
        "error",
        to_translate("The file contains no polygons. Draw one around the area."),
    ),
    "drawing.no-traces": (
        "error",
        to_translate("The file contains no lines. Save each trace as a line."),
    ),
    "drawing.zero-length": (
        "error",
        to_translate("All lines have zero length. Use at least one longer line."),
    ),
    "drawing.several-layers": (
        "error",
        to_translate("The file has several layers: {layers}. Specify one of them."),
    ),
    "drawing.unknown-layer": (
        "error",
        to_translate("The file has no layer “{layer}”. Choose one of: {layers}."),
    ),
    "drawing.paper-space": (
        "warning",
        *to_translate_n(
            "{count} shape in a layout (paper space) is left out.",
            "{count} shapes in layouts (paper space) are left out.",
        ),
    ),
    "drawing.hidden": (
        "warning",
        *to_translate_n(
            "{count} hidden shape (layer off or frozen) is left out.",
            "{count} hidden shapes (layer off or frozen) are left out.",
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
            "{count} shape without length, area or finite coordinates is left out.",
            "{count} shapes without length, area or finite coordinates are left out.",
        ),
    ),
    "drawing.lines-as-area": (
        "info",
        *to_translate_n(
            "{count} closed line is used as the outline of the area.",
            "{count} closed lines are used as outlines of the area.",
        ),
    ),
    "drawing.separate-parts": (
        "warning",
        to_translate(
            "Disconnected parts of features are counted as separate traces. Additional traces:"
            " {count}."
        ),
    ),
    "drawing.duplicates": (
        "warning",
        *to_translate_n(
            "{count} shape that is drawn twice is counted once.",
            "{count} shapes that are drawn twice are counted once.",
        ),
    ),
}
