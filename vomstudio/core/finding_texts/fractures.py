"""Texts of the findings about fracture trace maps."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "fractures.not-a-window": (
        "error",
        to_translate(
            "“{text}” is not a window. Enter two corners as x, y, x, y, or all corners of a"
            " polygon."
        ),
    ),
    "fractures.not-a-scanline": (
        "error",
        to_translate("“{text}” is not a scanline. Enter x, y of its start, its bends and its end."),
    ),
    "fractures.not-numbers": (
        "error",
        to_translate(
            "“{text}” is not a list of numbers. Enter numbers separated by commas, such as 0, 0,"
            " 5, 2.5."
        ),
    ),
    "fractures.not-a-circle": (
        "error",
        to_translate(
            "“{text}” is not a circle. Enter centre and radius in metres, such as 10,20,5."
        ),
    ),
    "fractures.not-a-strike-range": (
        "error",
        to_translate("“{text}” is not a range of strikes. Enter ranges such as 340-020,060-100."),
    ),
    "fractures.sets-not-of-traces": (
        "error",
        to_translate(
            "The number of sets ({sets}) differs from the number of traces. Specify one set for"
            " each trace."
        ),
    ),
    "fractures.scanline-without-length": (
        "error",
        to_translate("The scanline has zero length. Draw it across the traces."),
    ),
    "fractures.area-without-size": (
        "error",
        to_translate("The area has zero size. Draw a polygon around the traces."),
    ),
    "fractures.area-elsewhere": (
        "error",
        to_translate(
            "The area does not overlap the traces. Check that both are in the same coordinate"
            " reference system."
        ),
    ),
    "fractures.scanline-without-traces": (
        "warning",
        to_translate("No trace crosses the scanline. Draw it across the traces."),
    ),
    "fractures.weights-capped": (
        "info",
        *to_translate_n(
            "{count} Terzaghi weight was reduced to the maximum of {maximum:g}.",
            "{count} Terzaghi weights were reduced to the maximum of {maximum:g}.",
        ),
    ),
    "fractures.one-face": (
        "info",
        to_translate(
            "All values refer to one face: fractures nearly parallel to it are missed, and lengths"
            " are trace lengths, not fracture sizes."
        ),
    ),
    "fractures.area-beyond-traces": (
        "warning",
        to_translate(
            "{share_percent:.0f} % of the area is outside the outermost traces. If this part was"
            " not mapped, P20 and P21 are too small. Specify the mapped area."
        ),
    ),
    "fractures.no-traces": (
        "warning",
        to_translate("The area contains no traces. Choose another area."),
    ),
    "fractures.few-lengths": (
        "info",
        to_translate(
            "A length distribution needs traces of at least {minimum} different lengths with both"
            " ends visible."
        ),
    ),
    "fractures.self-crossing": (
        "warning",
        *to_translate_n(
            "{count} trace crosses itself (row {rows}). The crossing is not counted as a node.",
            "{count} traces cross themselves (rows {rows}). The crossings are not counted as"
            " nodes.",
        ),
    ),
    "fractures.overlaps": (
        "warning",
        *to_translate_n(
            "{count} pair of traces overlaps: the overlap has no node, and its length counts"
            " twice. Delete one trace.",
            "{count} pairs of traces overlap: the overlaps have no nodes, and their lengths count"
            " twice. Delete one trace of each pair.",
        ),
    ),
    "fractures.other-nodes": (
        "warning",
        *to_translate_n(
            "More than four branches meet at {count} point, which is not an I, Y or X node. Reduce"
            " the tolerance.",
            "More than four branches meet at {count} points, which are not I, Y or X nodes. Reduce"
            " the tolerance.",
        ),
    ),
    "area.self-crossing": (
        "warning",
        *to_translate_n(
            "The outline of the area crosses itself. Its parts total {area_m2:.6g} m² (signed sum:"
            " {signed_area_m2:.6g} m²). Correct the outline.",
            "The outlines of {count} areas cross themselves. Their parts total {area_m2:.6g} m²"
            " (signed sum: {signed_area_m2:.6g} m²). Correct the outlines.",
        ),
    ),
    "fractures.no-mark": (
        "error",
        to_translate("Drag on the map to draw the circle or scanline, or enter its coordinates."),
    ),
    "fractures.no-cells": (
        "error",
        to_translate(
            "No cell of {grid} is marked as done or empty. Mark the inspected cells with the Cells"
            " tool."
        ),
    ),
}
