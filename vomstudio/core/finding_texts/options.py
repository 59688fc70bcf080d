"""Texts of the findings about options of operations."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "option.not-a-choice": (
        "error",
        to_translate("“{value}” is not valid. Choose one of: {choices}."),
    ),
    "option.missing": ("error", to_translate("A value is needed, not None. Give one.")),
    "option.too-small": (
        "error",
        to_translate("{value} is too small. Use a number of at least {minimum}."),
    ),
    "option.out-of-range": (
        "error",
        to_translate("{value} is not valid. Use a number from {minimum} to {maximum}."),
    ),
    "option.none-given": ("error", to_translate("Give one of these: {options}.")),
    "option.requires": (
        "error",
        to_translate("{option} needs {other}. Give both, or leave out {option}."),
    ),
    "option.clouds-only": (
        "error",
        to_translate("The model is a mesh, and {option} is for point clouds. Leave it out."),
    ),
    "option.not-a-length": (
        "error",
        to_translate("{value} is not valid. Use a length above 0, at most {maximum} m."),
    ),
    "option.conflict": (
        "error",
        to_translate("{option} and {other} exclude each other. Leave out one of them."),
    ),
    "number.not-positive": (
        "error",
        to_translate("{value:g} is not a positive number. Correct it."),
    ),
    "frame.not-in-metres": (
        "error",
        to_translate(
            "The coordinate reference system {crs} is not in metres. Choose one that is, such as a"
            " UTM zone."
        ),
    ),
    "number.invalid": (
        "error",
        to_translate("“{text}” is not a number. Correct it."),
    ),
}
