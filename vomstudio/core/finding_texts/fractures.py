"""Texts of the findings about maps of fracture traces."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.words import to_translate

TEXTS: dict[str, Entry] = {
    "fractures.not-a-circle": (
        "error",
        to_translate(
            "“{text}” is not a circle. Write centre and radius in metres, such as 10,20,5."
        ),
    ),
    "fractures.not-a-strike-range": (
        "error",
        to_translate("“{text}” is not a range of strikes. Write ranges such as 340-020,060-100."),
    ),
    "fractures.sets-not-of-traces": (
        "error",
        to_translate("There are {sets} sets, but not as many traces. Give the set of each trace."),
    ),
    "fractures.no-mark": (
        "error",
        to_translate("Drag on the map to mark it, or type its numbers."),
    ),
    "fractures.no-cells": (
        "error",
        to_translate(
            "No cell of {grid} is marked as done or empty. Mark what was inspected with the "
            "tool Cells."
        ),
    ),
}
