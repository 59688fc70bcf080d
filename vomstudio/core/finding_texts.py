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
    # --- files ---------------------------------------------------------------------------------
    "file.unsafe-schema": (
        "error",
        to_translate(
            "The file contains the {kind} '{name}', which can run without end or hide rows."
            " Export its tables to a new file, or ask for another copy."
        ),
    ),
    "file.picture-too-large": (
        "error",
        to_translate(
            "The picture of {width} x {height} pixels needs {needed_mb} MB; for this file"
            " {limit_mb} MB are allowed. Reduce it, or close other programs."
        ),
    ),
    "file.picture-header": (
        "error",
        to_translate(
            "The header of the picture is not valid: {reason}. Save it again with another program."
        ),
    ),
    "file.memory-exceeded": (
        "error",
        to_translate(
            "Reading was stopped: it takes more memory than the size of the file justifies. Export"
            " the file again."
        ),
    ),
}
