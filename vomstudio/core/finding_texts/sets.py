"""Texts of the findings about sets of planes."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.words import to_translate

TEXTS: dict[str, Entry] = {
    "sets.too-many": (
        "error",
        to_translate("{n} planes cannot form {sets} sets. Use a smaller number."),
    ),
    "sets.too-many-seeds": (
        "error",
        to_translate("{seeds} seeds make more sets than {max_sets}. Leave out seeds."),
    ),
    "sets.seed-not-a-plane": (
        "error",
        to_translate("“{text}” is not a plane. Write dip direction/dip, such as 120/45,300/80."),
    ),
    "sets.equal-seeds": (
        "error",
        to_translate("Two seeds are less than 1 degree apart. Leave out one of them."),
    ),
    "sets.not-a-scanline": (
        "error",
        to_translate("A scanline is two different points in metres: x,y,z,x,y,z."),
    ),
    "sets.no-places": (
        "error",
        to_translate("A scanline requires the places of the planes. Add the columns x, y, z."),
    ),
}
