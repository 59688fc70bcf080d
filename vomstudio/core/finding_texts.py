"""The catalogue of findings: severity and text of every code.

A text says what happened, with the value or file, and what to do, in at most 25 words (STYLE of the
project). Placeholders are those of `str.format`.
"""

from __future__ import annotations

from typing import Literal

from vomstudio.words import to_translate

TEXTS: dict[str, tuple[Literal["info", "warning", "error"], str]] = {
    "uncoded": ("warning", "{text}"),
    # --- frames --------------------------------------------------------------------------------
    "frame.assumed": (
        "warning",
        to_translate(
            "{file} states no frame. Assumed: {up} up, unit {unit}, CRS {crs}. Options --up, --unit"
            " and --crs change this."
        ),
    ),
    "frame.not-metric": (
        "error",
        to_translate(
            "Lengths in {crs} are {scale:.4g} times those on the ground there, and differ by"
            " {anisotropy_percent:.2g} % with direction. Use {suggested_crs}."
        ),
    ),
    "frame.undefined-place": (
        "error",
        to_translate("{crs} is not defined where the data lie. Check the CRS and the coordinates."),
    ),
    "frame.outside-area": (
        "warning",
        to_translate(
            "The data lie outside the area of use of {crs}; lengths there are {scale:.5g} times"
            " those on the ground. Check the CRS, or use {suggested_crs}."
        ),
    ),
    "frame.reprojected": (
        "info",
        to_translate("Coordinates were converted from {crs} to {to_crs}."),
    ),
    "frame.unit-converted": (
        "info",
        to_translate(
            "The file states x and y in {unit} and heights in {height_unit}. All were converted to"
            " metres."
        ),
    ),
    "frame.maybe-degrees": (
        "warning",
        to_translate(
            "x and y look like degrees: within 180 and 90, spanning {span:.2g} for {height:.2g} of"
            " height. State the CRS with --crs and convert with --to-crs."
        ),
    ),
    "frame.crs-replaced": (
        "warning",
        to_translate("{file} states {file_crs}; the given {crs} is used instead."),
    ),
    # --- registrations -------------------------------------------------------------------------
    "registration.other-model": (
        "warning",
        to_translate(
            "{file} belongs to other files ({models}), so its errors are not used. Register the"
            " model again, or delete the file."
        ),
    ),
    "registration.damaged": (
        "warning",
        to_translate(
            "{file} cannot be used: {reason}. The model has no errors of registration. Restore the"
            " file, or register the model again."
        ),
    ),
    "registration.unknown-version": (
        "warning",
        to_translate(
            "{file} has version {version}, this program reads {known}. Its registration is not"
            " used. Update the program."
        ),
    ),
    "registration.other-frame": (
        "warning",
        to_translate(
            "The registration in {file} is not used: it places the model in {crs}, but {stated} is"
            " stated. Correct one of them."
        ),
    ),
    "registration.incomplete": (
        "warning",
        to_translate(
            "The earlier registration in {file} is not used for what the new one leaves free,"
            " because the coordinates of the file are not those of World."
        ),
    ),
    "registration.reference-error": (
        "info",
        to_translate(
            "With the error of the reference the model may be turned by {rotation95_deg:.2g}°"
            " (95 %) and its scale may be off by {scale95_percent:.2g} %."
        ),
    ),
}
