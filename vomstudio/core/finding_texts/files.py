"""Texts of the findings about files and folders."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.words import to_translate

TEXTS: dict[str, Entry] = {
    "uncoded": ("warning", "{text}"),
    "file.other-kind": (
        "error",
        to_translate("Cannot read this kind of file here: {title}. {remedy}"),
    ),
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
    "file.missing": (
        "error",
        to_translate("There is no such file. Check its name."),
    ),
    "file.is-folder": (
        "error",
        to_translate("This is a folder. Name a file in it."),
    ),
    "file.empty": (
        "error",
        to_translate("The file is empty. Export or copy it again."),
    ),
    "file.unreadable": (
        "error",
        to_translate("The file cannot be read ({reason}). Check its name and its disk."),
    ),
    "output.unwritable": (
        "error",
        to_translate("The file cannot be written ({reason}). Choose another place."),
    ),
    "folder.not-created": (
        "error",
        to_translate("The folder cannot be created ({reason}). Choose another place."),
    ),
}
