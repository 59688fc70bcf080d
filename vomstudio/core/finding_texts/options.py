"""Texts of the findings about options of operations."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "option.not-a-choice": (
        "error",
        to_translate("“{value}” is not valid. Choose one of: {choices}."),
    ),
    "option.missing": ("error", to_translate("A value is required, not None. Specify one.")),
    "option.too-small": (
        "error",
        to_translate("{value} is too small. Use a number of at least {minimum}."),
    ),
    "option.out-of-range": (
        "error",
        to_translate("{value} is not valid. Use a number from {minimum} to {maximum}."),
    ),
    "option.none-given": ("error", to_translate("Specify one of these: {options}.")),
    "option.requires": (
        "error",
        to_translate("{option} needs {other}. Specify both, or omit {option}."),
    ),
    "option.clouds-only": (
        "error",
        to_translate(
            "{option} applies to point clouds, but the model is a mesh. Omit this option."
        ),
    ),
    "option.not-a-length": (
        "error",
        to_translate("{value} is not a valid length. Use a value above 0 and up to {maximum} m."),
    ),
    "option.conflict": (
        "error",
        to_translate("{option} and {other} exclude each other. Omit one of them."),
    ),
    "number.not-positive": (
        "error",
        to_translate("{value:g} is not a positive number. Correct it."),
    ),
    "frame.not-in-metres": (
        "error",
        to_translate(
            "The coordinate reference system {crs} is not in metres. Choose one in metres, such"
            " as a UTM zone."
        ),
    ),
    "number.invalid": (
        "error",
        to_translate("“{text}” is not a number. Correct it."),
    ),
    "number.not-whole": (
        "error",
        to_translate("“{text}” is not a whole number. Correct it."),
    ),
}
