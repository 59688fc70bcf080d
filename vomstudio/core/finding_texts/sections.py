"""Texts of the findings about sections, planes extended through a model, and logs."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "section.no-length": (
        "error",
        to_translate(
            "The line of the section has no length. Draw it between two different points."
        ),
    ),
    "section.several-lines": (
        "error",
        to_translate(
            "The file contains {count} lines. Keep one, which is the line of the section."
        ),
    ),
    "section.too-few-points": (
        "error",
        to_translate("A line of section needs at least two points. Give x and y of each in a row."),
    ),
    "section.line-missing": (
        "error",
        to_translate(
            "Draw a line on the outcrop, or select a trace or a measured polyline and take it."
        ),
    ),
    "section.not-a-point": (
        "error",
        to_translate("“{text}” is not a point. Write x,y,z: World coordinates in metres."),
    ),
    "section.no-planes": (
        "error",
        to_translate("The table has no plane with x, y and z. Add the places of the planes."),
    ),
    "section.misses-model": (
        "error",
        to_translate(
            "The section does not meet the model. Check the plane and its point, or the line."
        ),
    ),
    "section.thin-slab": (
        "error",
        to_translate(
            "{count} points lie within {half_m:.3g} m of the section, too few for a line. Move the"
            " section, or use a thicker slab (--slab)."
        ),
    ),
    "section.along-direction": (
        "error",
        to_translate(
            "The direction of projection lies in the section (within {limit_deg:g}°). Choose one"
            " that meets it at {recommended_deg:g}° or more."
        ),
    ),
    "section.along-domain": (
        "error",
        to_translate(
            "The axis of domain {domain} lies in the section (within {limit_deg:g}°). Choose a"
            " section that meets it at {recommended_deg:g}° or more."
        ),
    ),
    "section.grazing-direction": (
        "warning",
        to_translate(
            "The direction of projection meets the section at {angle_deg:.0f}° only: each degree of"
            " its error moves features by {cost_percent:.0f} % of their distance from it."
        ),
    ),
    "section.grazing-domain": (
        "warning",
        to_translate(
            "The axis of domain {domain} meets the section at {angle_deg:.0f}° only: each degree of"
            " its error moves features by {cost_percent:.0f} % of their distance from it."
        ),
    ),
    "section.pieces-without-features": (
        "warning",
        to_translate(
            "Pieces of the section within {limit_deg:g}° of the direction of projection show no"
            " features."
        ),
    ),
    "section.domain-without-axis": (
        "warning",
        to_translate(
            "Domain {domain} has no axis of its own ({reason}) and is projected at right angles to"
            " the section."
        ),
    ),
    "section.lines-left-out": (
        "warning",
        *to_translate_n(
            "{count} row of the table is a line and is not projected.",
            "{count} rows of the table are lines and are not projected.",
        ),
    ),
    "section.planes-without-place": (
        "warning",
        *to_translate_n(
            "{count} plane without x, y and z is not projected (line {lines}).",
            "{count} planes without x, y and z are not projected (lines {lines}).",
        ),
    ),
    "extension.misses-model": (
        "error",
        to_translate("The plane does not meet the model. Check its attitude and its point."),
    ),
    "extension.beds-indistinct": (
        "warning",
        to_translate(
            "Far from its points the error of the plane exceeds half the thickness, so that beds"
            " cannot be distinguished there."
        ),
    ),
    "log.ambiguous-line": (
        "error",
        to_translate("Several lines are called {name}. Give the id of one."),
    ),
    "log.no-line": (
        "error",
        to_translate(
            "The project has no trace, contact line or polyline {name}. Lines with described beds:"
            " {names}."
        ),
    ),
    "log.no-type": (
        "error",
        to_translate("The project has no feature type {name}. Choose one of: {names}."),
    ),
    "log.too-few-boundaries": (
        "error",
        to_translate(
            "{count} of the traces come within {reach:.3g} {unit} of the line; a log needs two"
            " boundaries. Allow a larger distance, or use the points of the line."
        ),
    ),
    "log.no-bedding": (
        "error",
        to_translate(
            "No trace of the bedding is near the line. Choose the plane of a bed, or give its"
            " attitude (--bed)."
        ),
    ),
    "log.overturned-beds": (
        "warning",
        *to_translate_n(
            "{count} boundary is on a bed marked as overturned, while the log counts upwards. State"
            " that the beds are overturned if younger ones lie below.",
            "{count} boundaries are on beds marked as overturned, while the log counts upwards."
            " State that the beds are overturned if younger ones lie below.",
        ),
    ),
    "traces.none": (
        "error",
        to_translate("No trace was drawn. Draw at least one."),
    ),
}
