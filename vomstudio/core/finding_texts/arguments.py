"""Texts of the findings about arguments passed to Python functions."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "argument.wrong-type": (
        "error",
        to_translate("A value of type {type} is not valid. Use {expected}."),
    ),
    "argument.empty": (
        "error",
        to_translate("The argument contains no values. Pass at least one."),
    ),
    "argument.requires-type": (
        "error",
        to_translate(
            "{option} requires {argument} to be of type {expected}. Change {argument}, or leave out"
            " {option}."
        ),
    ),
    "array.masked": (
        "error",
        to_translate("The array has masked values, which are not numbers. Remove these rows."),
    ),
    "array.not-numbers": (
        "error",
        to_translate(
            "A value of type {type} cannot be converted to an array of numbers. Pass numbers only,"
            " in rows of equal length."
        ),
    ),
    "array.not-points": (
        "error",
        to_translate(
            "An array of shape ({shape}) does not contain points (n, 3). Transpose an array (3,"
            " n), or write one point as [[x, y, z]]."
        ),
    ),
    "array.shape": (
        "error",
        to_translate("The array has the shape ({shape}). Pass an array of shape {expected}."),
    ),
    "array.lengths-differ": (
        "error",
        to_translate(
            "{name} has {count} rows, but {other} has {other_count}, so they cannot be paired. Pass"
            " the same number of rows."
        ),
    ),
    "array.not-finite": (
        "error",
        *to_translate_n(
            "{count} row has a value that is not finite or too large (row {first_row}, counted"
            " from 0). Correct or remove it.",
            "{count} rows have values that are not finite or too large (first: row {first_row},"
            " counted from 0). Correct or remove them.",
        ),
    ),
    "array.no-such-point": (
        "error",
        *to_translate_n(
            "{count} face refers to a point that does not exist (row {first_row}, counted from 0)."
            " Correct or remove it.",
            "{count} faces refer to points that do not exist (first: row {first_row}, counted from"
            " 0). Correct or remove them.",
        ),
    ),
    "array.not-positive": (
        "error",
        *to_translate_n(
            "{count} row has a value that is not positive (row {first_row}, counted from 0)."
            " Correct it.",
            "{count} rows have values that are not positive (first: row {first_row}, counted from"
            " 0). Correct them.",
        ),
    ),
    "array.not-flags": (
        "error",
        to_translate(
            "Each of the {count} points needs True or False. Pass a Boolean array of shape"
            " ({count},)."
        ),
    ),
    "array.no-such-element": (
        "error",
        to_translate(
            "The elements of a patch must be indices from 0 to {maximum}, or {total} Boolean"
            " values, one per face or point. Correct the array."
        ),
    ),
    "array.rows-left-out": (
        "warning",
        *to_translate_n(
            "{count} row without finite coordinates was left out.",
            "{count} rows without finite coordinates were left out.",
        ),
    ),
    "text.invalid-characters": (
        "error",
        to_translate("The text contains characters that cannot be stored in a file. Remove them."),
    ),
    "path.invalid": (
        "error",
        to_translate("This is not a valid file name ({reason}). Correct it."),
    ),
}
