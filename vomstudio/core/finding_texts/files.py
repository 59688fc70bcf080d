"""Texts of the findings about files and folders."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "uncoded": ("warning", "{text}"),
    "file.other-kind": (
        "error",
        to_translate("This kind of file cannot be read here: {title}. {remedy}"),
    ),
    "file.unsafe-schema": (
        "error",
        to_translate(
            "The file contains the {kind} '{name}', which may never finish or may hide rows."
            " Export its tables to a new file."
        ),
    ),
    "file.picture-too-large": (
        "error",
        to_translate(
            "The picture of {width} x {height} pixels needs {needed_mb} MB ({limit_mb} MB"
            " available). Reduce it, or close other programs."
        ),
    ),
    "file.picture-header": (
        "error",
        to_translate(
            "The picture has an invalid header: {reason}. Save it again with another program."
        ),
    ),
    "file.memory-exceeded": (
        "error",
        to_translate(
            "Reading was stopped because it needed more memory than expected for a file of this"
            " size. Export the file again."
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
        to_translate("This is a folder. Specify a file in it."),
    ),
    "file.is-project": (
        "error",
        to_translate(
            "This is a project. Specify a file instead, such as one that vomstudio export writes."
        ),
    ),
    "file.empty": (
        "error",
        to_translate("The file is empty. Export or copy it again."),
    ),
    "file.unreadable": (
        "error",
        to_translate("The file cannot be read ({reason}). Check its name and its drive."),
    ),
    "output.unwritable": (
        "error",
        to_translate("The file cannot be written ({reason}). Choose another location."),
    ),
    "folder.not-created": (
        "error",
        to_translate("The folder cannot be created ({reason}). Choose another location."),
    ),
    "file.no-permission": (
        "error",
        to_translate("You do not have permission to read this file. Change its permissions."),
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
            "The file is truncated: it has {size:,} of {expected:,} bytes. Copy it again."
        ),
    ),
    "file.blank": (
        "error",
        to_translate("Part of the file is blank (from byte {byte}). Copy or save it again."),
    ),
    "file.inflated": (
        "error",
        to_translate(
            "The file describes far more data than it contains, through endless or repeated"
            " references. Export it again without them."
        ),
    ),
    "file.exceeds-memory": (
        "error",
        to_translate(
            "The file needs more memory than is available. Divide it, or export a part of it."
        ),
    ),
    "file.unknown-type": (
        "error",
        to_translate("Files with the extension '{suffix}' cannot be read. Supported: {formats}."),
    ),
    "output.unknown-format": (
        "error",
        to_translate(
            "Files with the extension '{suffix}' cannot be written. Choose one of: {formats}."
        ),
    ),
    "output.other-registration": (
        "error",
        to_translate(
            "This file contains the registration of another model. Choose another output name."
        ),
    ),
    "file.declares-entity": (
        "error",
        to_translate("The file declares an entity ({name}), which is not allowed here. Remove it."),
    ),
    "file.too-many-parts": (
        "error",
        to_translate("The file has more than {limit:,} {parts}. Simplify or divide it."),
    ),
    "file.missing-element": (
        "error",
        to_translate("The element {name} is missing. Add it."),
    ),
    "file.number-count": (
        "error",
        *to_translate_n(
            "Found {count} number, but {needed} are required.",
            "Found {count} numbers, but {needed} are required.",
        ),
    ),
    "file.not-regular": (
        "error",
        to_translate("This is a folder, a device or a pipe. Specify a regular file."),
    ),
    "file.other-format": (
        "error",
        to_translate(
            "This is not a valid {format} file. Export it again, or correct its extension."
        ),
    ),
    "file.silent-pipe": (
        "error",
        to_translate("This pipe sends no data. Specify a file."),
    ),
    "file.device-in-folder": (
        "error",
        to_translate("This is a device or a pipe. Remove it from the folder."),
    ),
    "file.too-large": (
        "error",
        to_translate(
            "The file is larger than {limit_mb} MB, the limit for this kind of file. Check that"
            " it is the right file."
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
        to_translate("The output has no file name. Add one."),
    ),
    "output.is-folder": (
        "error",
        to_translate("This is a folder. Specify an output file name."),
    ),
    "output.is-device": (
        "error",
        to_translate("This is a device or a pipe. Specify an output file name."),
    ),
    "output.is-stdout": (
        "error",
        to_translate("Files are not written to standard output. Specify an output file name."),
    ),
    "output.is-input": (
        "error",
        to_translate("This file is an input of the command. Choose another output."),
    ),
    "output.exists": (
        "error",
        to_translate(
            "This file already exists. Choose another name, or use --force if the command"
            " supports it."
        ),
    ),
    "output.write-protected": (
        "error",
        to_translate("This file is write-protected. Choose another name."),
    ),
    "output.same-names": (
        "error",
        to_translate("Two outputs have the same name. Use different names."),
    ),
    "output.no-folder": (
        "error",
        to_translate("The folder {folder} does not exist. Create it, or choose another folder."),
    ),
    "output.folder-is-file": (
        "error",
        to_translate("{folder} is a file, not a folder. Choose another folder."),
    ),
    "output.folder-in-use": (
        "error",
        to_translate(
            "Another reconstruction is running in this folder ({holder}). Wait until it"
            " finishes, or use another folder."
        ),
    ),
    "output.outside-folder": (
        "error",
        to_translate("This location is outside {folder}. Choose one inside."),
    ),
    "output.link": (
        "error",
        to_translate(
            "{link} is a link, which is not followed when writing in this folder. Replace it with"
            " its target, or remove it."
        ),
    ),
    "output.no-backup": (
        "error",
        to_translate(
            "The existing file cannot be renamed before it is replaced ({reason}). Change the"
            " permissions of its folder."
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
            "You do not have permission to write to this folder. Change its permissions, or save"
            " elsewhere."
        ),
    ),
    "disk.name-too-long": (
        "error",
        to_translate("The name is too long for the file system. Choose a shorter one."),
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
            "A desktop menu entry is only available on Linux. Start VOM Studio with its command."
        ),
    ),
    "project.locked": (
        "error",
        to_translate("The project is open in another window ({holder}). Close it there first."),
    ),
    "project.unwritable": (
        "error",
        to_translate(
            "The project folder is not writable ({reason}). Copy it to a writable location and"
            " open the copy."
        ),
    ),
    "project.folder-missing": (
        "error",
        to_translate(
            "The project folder no longer exists: it was deleted or renamed, or its drive was"
            " removed. Restore it."
        ),
    ),
    "settings.unreadable": (
        "warning",
        to_translate("{file}: the settings cannot be read ({reason}). Default settings are used."),
    ),
    "settings.invalid-value": (
        "warning",
        to_translate("{file}, {setting}: {reason}. The default value is used."),
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
            "The picture is georeferenced, but its position cannot be read. Export it as GeoTIFF."
        ),
    ),
    "picture.unknown-kind": (
        "error",
        to_translate(
            "The picture is damaged or has an unsupported format. Save it as JPEG, PNG or TIFF."
        ),
    ),
    "picture.unknown-tiff": (
        "error",
        to_translate(
            "The TIFF is damaged or has an unsupported format, such as 16 bits per channel. Save"
            " it with 8 bits per channel."
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
        to_translate("The file name is not valid UTF-8. Rename the file."),
    ),
}
