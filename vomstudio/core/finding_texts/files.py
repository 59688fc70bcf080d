"""Texts of the findings about files and folders."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

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
        to_translate("The file does not exist. Check its name."),
    ),
    "file.misspelt": (
        "error",
        to_translate("The file or folder does not exist. Did you mean “{nearest}”?"),
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
    "file.no-permission": (
        "error",
        to_translate("You have no permission to read this file. Change its permissions."),
    ),
    "file.damaged": (
        "error",
        to_translate(
            "The {format} file is damaged or not valid: {reason}. Copy or export it again."
        ),
    ),
    "file.truncated": (
        "error",
        to_translate(
            "The file ends too early: {size:,} of {expected:,} bytes are there. Copy it again."
        ),
    ),
    "file.blank": (
        "error",
        to_translate("A part of the file is blank (from byte {byte}). Copy or save it again."),
    ),
    "file.inflated": (
        "error",
        to_translate(
            "The file describes far more data than it contains: parts are repeated or empty without"
            " end. Export it again without them."
        ),
    ),
    "file.exceeds-memory": (
        "error",
        to_translate(
            "The file needs more than the free memory. Divide it, or export a part of it."
        ),
    ),
    "file.unknown-type": (
        "error",
        to_translate("The extension '{suffix}' is not one that can be read. Supported: {formats}."),
    ),
    "output.unknown-format": (
        "error",
        to_translate(
            "The extension '{suffix}' is not one that can be written. Choose one of: {formats}."
        ),
    ),
    "output.other-registration": (
        "error",
        to_translate(
            "This file contains the registration of another model. Choose another name for the"
            " output."
        ),
    ),
    "file.declares-entity": (
        "error",
        to_translate(
            "The file declares an entity ({name}), which such files do not need. Remove it."
        ),
    ),
    "file.too-many-parts": (
        "error",
        to_translate(
            "The file has more than {limit:,} {parts}, more than can be meant. Simplify or divide"
            " it."
        ),
    ),
    "file.missing-element": (
        "error",
        to_translate("The element has no {name}. Add it."),
    ),
    "file.number-count": (
        "error",
        *to_translate_n(
            "There is {count} number; {needed} are needed.",
            "There are {count} numbers; {needed} are needed.",
        ),
    ),
    "file.not-regular": (
        "error",
        to_translate("This is a folder, a device or a pipe, not a file. Name a file."),
    ),
    "file.other-format": (
        "error",
        to_translate(
            "This is not a valid {format} file. Export it again, or correct its extension."
        ),
    ),
    "file.silent-pipe": (
        "error",
        to_translate("Nothing is written into this pipe. Name a file."),
    ),
    "file.device-in-folder": (
        "error",
        to_translate("This is a device or a pipe. Remove it from the folder."),
    ),
    "file.too-large": (
        "error",
        to_translate(
            "The file is larger than {limit_mb} MB, which no file of its kind is. Check what it is."
        ),
    ),
    "file.not-removed": (
        "error",
        to_translate(
            "The file cannot be removed ({reason}). Change the permissions of its folder."
        ),
    ),
    "output.no-name": (
        "error",
        to_translate("This does not name a file. Give the output a file name."),
    ),
    "output.is-folder": (
        "error",
        to_translate("This is a folder. Give the output a file name."),
    ),
    "output.is-device": (
        "error",
        to_translate("This is a device or a pipe. Give the output a file name."),
    ),
    "output.is-stdout": (
        "error",
        to_translate("Files are not written to standard output. Give the output a file name."),
    ),
    "output.is-input": (
        "error",
        to_translate("The command reads this file. Choose another output."),
    ),
    "output.exists": (
        "error",
        to_translate(
            "This file exists already. Choose another name, or use --force if the command has it."
        ),
    ),
    "output.write-protected": (
        "error",
        to_translate("This file is write-protected. Choose another name."),
    ),
    "output.same-names": (
        "error",
        to_translate("Two of the outputs have the same name. Give each its own."),
    ),
    "output.no-folder": (
        "error",
        to_translate("The folder {folder} does not exist. Create it, or choose another."),
    ),
    "output.folder-is-file": (
        "error",
        to_translate("{folder} is a file, not a folder. Choose another folder."),
    ),
    "output.folder-in-use": (
        "error",
        to_translate(
            "Another reconstruction is running in this folder ({holder}). Wait for it, or name"
            " another folder."
        ),
    ),
    "output.outside-folder": (
        "error",
        to_translate("This place is outside of {folder}. Choose one inside."),
    ),
    "output.link": (
        "error",
        to_translate(
            "{link} is a link, and links in this folder are not followed for writing. Replace it by"
            " its target, or remove it."
        ),
    ),
    "output.no-backup": (
        "error",
        to_translate(
            "The file cannot be renamed before it is replaced ({reason}). Change the permissions of"
            " its folder."
        ),
    ),
    "disk.full": (
        "error",
        to_translate("The disk is full. Free some space, or save elsewhere."),
    ),
    "disk.read-only": (
        "error",
        to_translate("The disk is read-only. Make it writable, or save elsewhere."),
    ),
    "disk.no-permission": (
        "error",
        to_translate(
            "You have no permission to write to this folder. Change it, or save elsewhere."
        ),
    ),
    "disk.name-too-long": (
        "error",
        to_translate("This name is too long for the file system. Choose a shorter one."),
    ),
    "disk.failed": (
        "error",
        to_translate(
            "Cannot write to the disk ({reason}). Finished results are kept. Free some space or"
            " choose another folder, and start again."
        ),
    ),
    "desktop.not-linux": (
        "error",
        to_translate(
            "Only Linux desktops have such a menu entry. Start VOM Studio by its command."
        ),
    ),
    "project.locked": (
        "error",
        to_translate("The project is open in another window ({holder}). Close it there first."),
    ),
    "project.unwritable": (
        "error",
        to_translate(
            "The project folder cannot be written ({reason}). Copy it to a writable place and open"
            " the copy."
        ),
    ),
    "project.folder-missing": (
        "error",
        to_translate(
            "The project's folder is no longer there: it was deleted or renamed, or its drive was"
            " removed. Restore it."
        ),
    ),
    "settings.unreadable": (
        "warning",
        to_translate("{file}: the settings cannot be read ({reason}). The defaults are used."),
    ),
    "settings.invalid-value": (
        "warning",
        to_translate("{file}, {setting}: {reason}. The default is used."),
    ),
    "file.newer-version": (
        "error",
        to_translate(
            "The file was written by a newer version of this program. Update the program."
        ),
    ),
    "folder.missing": (
        "error",
        to_translate("The folder does not exist. Choose another one."),
    ),
    "folder.not-a-folder": (
        "error",
        to_translate("This is a file, not a folder. Choose a folder."),
    ),
    "folder.unreadable": (
        "error",
        to_translate("The folder cannot be read ({reason}). Change its permissions."),
    ),
    "picture.place-unreadable": (
        "warning",
        to_translate(
            "The picture is georeferenced, but its place cannot be read. Export it as GeoTIFF."
        ),
    ),
    "picture.unknown-kind": (
        "error",
        to_translate(
            "The picture is damaged, or of a kind that cannot be read. Save it as JPEG, PNG or"
            " TIFF."
        ),
    ),
    "picture.unknown-tiff": (
        "error",
        to_translate(
            "The TIFF is damaged, or of a kind that cannot be read (16 bits per channel). Save it"
            " with 8 bits per channel."
        ),
    ),
    "file.encoding": (
        "warning",
        to_translate("The file is {encoding} text, not UTF-8. Check names with accents."),
    ),
    "file.package-missing": (
        "error",
        to_translate(
            "E57 files need the package pye57. Install it with pip install 'vomstudio[e57]', or"
            " convert the file to LAZ."
        ),
    ),
    "file.name-encoding": (
        "error",
        to_translate("The name of the file is not UTF-8. Rename it."),
    ),
}
