"""Texts of the findings about sections, planes extended through a model, and logs."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "section.no-length": (
        "error",
        to_translate(
            "The line of the section has zero length. Draw it between two different points."
        ),
    ),
    "section.several-lines": (
        "error",
        to_translate("The file contains {count} lines. Keep only the line of the section."),
    ),
    "section.too-few-points": (
        "error",
        to_translate(
            "A section line needs at least two points. Write x and y of each point in one row."
        ),
    ),
    "section.line-missing": (
        "error",
        to_translate(
            "Draw a line on the outcrop, or select a trace or measured polyline and use it."
        ),
    ),
    "section.not-a-point": (
        "error",
        to_translate("“{text}” is not a point. Use the form x,y,z: World coordinates in metres."),
    ),
    "section.no-planes": (
        "error",
        to_translate("The table has no plane with x, y and z. Add the positions of the planes."),
    ),
    "section.misses-model": (
        "error",
        to_translate(
            "The section does not intersect the model. Check the plane and its point, or the line."
        ),
    ),
    "section.thin-slab": (
        "error",
        to_translate(
            "Only {count} points lie within {half_m:.3g} m of the section, too few for a line."
            " Move the section, or use a thicker slab (--slab)."
        ),
    ),
    "section.along-direction": (
        "error",
        to_translate(
            "The projection direction lies in the section (within {limit_deg:g}°). Choose a"
            " direction at {recommended_deg:g}° or more to the section."
        ),
    ),
    "section.along-domain": (
        "error",
        to_translate(
            "The axis of domain {domain} lies in the section (within {limit_deg:g}°). Choose a"
            " section at {recommended_deg:g}° or more to it."
        ),
    ),
    "section.grazing-direction": (
        "warning",
        to_translate(
            "The projection direction is only {angle_deg:.0f}° from the section: each degree of"
            " error displaces features by {cost_percent:.0f} % of their distance from the section."
        ),
    ),
    "section.grazing-domain": (
        "warning",
        to_translate(
            "The axis of domain {domain} is only {angle_deg:.0f}° from the section: each degree of"
            " error displaces features by {cost_percent:.0f} % of their distance from the section."
        ),
    ),
    "section.pieces-without-features": (
        "warning",
        to_translate(
            "Parts of the section within {limit_deg:g}° of the projection direction show no"
            " features."
        ),
    ),
    "section.domain-without-axis": (
        "warning",
        to_translate(
            "Domain {domain} has no axis of its own ({reason}) and is projected perpendicular to"
            " the section."
        ),
    ),
    "section.lines-left-out": (
        "warning",
        *to_translate_n(
            "{count} row in the table is a line and is not projected.",
            "{count} rows in the table are lines and are not projected.",
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
        to_translate("The plane does not intersect the model. Check its attitude and its point."),
    ),
    "extension.beds-indistinct": (
        "warning",
        to_translate(
            "Far from its points, the error of the plane exceeds half the bed thickness, so beds"
            " cannot be distinguished there."
        ),
    ),
    "log.ambiguous-line": (
        "error",
        to_translate("Several lines are called {name}. Specify the id of one of them."),
    ),
    "log.no-line": (
        "error",
        to_translate(
            "The project has no trace, contact line or polyline called {name}. Lines with"
            " described beds: {names}."
        ),
    ),
    "log.no-type": (
        "error",
        to_translate("The project has no feature type called {name}. Choose one of: {names}."),
    ),
    "log.too-few-boundaries": (
        "error",
        to_translate(
            "A log needs two boundaries, but the number of traces within {reach:.3g} {unit} of the"
            " line is {count}. Increase the distance, or use the line's points."
        ),
    ),
    "log.no-bedding": (
        "error",
        to_translate(
            "No bedding trace is near the line. Choose the plane of a bed, or specify its"
            " attitude (--bed)."
        ),
    ),
    "log.overturned-beds": (
        "warning",
        *to_translate_n(
            "{count} boundary is on an overturned bed, but the log counts upwards. If younger"
            " beds lie below, mark the log as overturned.",
            "{count} boundaries are on overturned beds, but the log counts upwards. If younger"
            " beds lie below, mark the log as overturned.",
        ),
    ),
    "traces.none": (
        "error",
        to_translate("No trace has been drawn. Draw at least one."),
    ),
}
