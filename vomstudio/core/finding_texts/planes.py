"""Texts of the findings about planes and traces."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.words import to_translate

TEXTS: dict[str, Entry] = {
    "trace.beside": (
        "warning",
        to_translate(
            "Points {start} to {end} are {offset_m:.2g} m beside the plane of the rest, behind rock"
            " without a contact. Set a way-point there, on the right contact."
        ),
    ),
    "lines.not-planar": (
        "warning",
        to_translate(
            "The lines are three-dimensional. They were analysed on the plane {plane}: scatter"
            " {scatter_m:.2g} m, {shortening_percent:.1f} % shorter than in space. --plane sets"
            " another."
        ),
    ),
    "lines.no-plane": (
        "error",
        to_translate(
            "The lines lie on one straight line, so they define no plane. State their plane"
            " (--plane DD/D)."
        ),
    ),
    "lines.no-heights": (
        "warning",
        to_translate(
            "Lines without heights: {lines}. They cannot be placed on the plane {plane}. Export"
            " them with heights."
        ),
    ),
    "lines.edge-on": (
        "error",
        to_translate(
            "The {option} is seen edge-on on the plane {plane} of the lines. Give it with heights"
            " (a circle as X,Y,Z,R)."
        ),
    ),
    "lines.closed": (
        "warning",
        to_translate(
            "Closed lines, such as outlines of patches, are not traces. Left out: {lines}."
        ),
    ),
}
