"""Texts of the findings about drawings."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.words import to_translate

TEXTS: dict[str, Entry] = {
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
}
