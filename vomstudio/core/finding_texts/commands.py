"""Texts of the findings about words on the command line."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "command.missing": (
        "error",
        to_translate("No command was given. Choose one of: {commands}. See vomstudio --help."),
    ),
    "command.unknown": (
        "error",
        to_translate(
            "“{value}” is neither a command nor a file (similar: {nearest}). The commands are:"
            " {commands}. See vomstudio --help."
        ),
    ),
    "command.misspelt": (
        "error",
        to_translate(
            "“{value}” is not valid here. Did you mean “{nearest}”? See {program} --help."
        ),
    ),
    "command.unknown-argument": (
        "error",
        to_translate("“{value}” is not an argument of this command. See {program} --help."),
    ),
    "command.arguments-missing": (
        "error",
        to_translate("The command also needs {names}. See {program} --help."),
    ),
    "command.invalid": ("error", to_translate("{problem}. See {program} --help.")),
    "command.copied": ("info", to_translate("The command has been copied to the clipboard.")),
    "command.copied-with-file": (
        "info",
        to_translate("The command has been copied to the clipboard. Its input is {file}."),
    ),
    "command.window-options": (
        "error",
        to_translate("The window accepts files and folders, but no options. See vomstudio --help."),
    ),
    "command.internal-error": (
        "error",
        to_translate(
            "An internal error occurred ({type}: {error}). Please report it with this command"
            " (VOMSTUDIO_DEBUG=1 shows the traceback)."
        ),
    ),
    "system.refused": (
        "error",
        to_translate(
            "The operating system refused the operation ({reason}). Check names and permissions,"
            " and try again."
        ),
    ),
}
