"""Interpretation of the first word: a command, an option, or a file for the window."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding

COMMANDS = (
    "demo",
    "info",
    "convert",
    "fit",
    "stats",
    "fold",
    "sets",
    "repeats",
    "stereonet",
    "rose",
    "slope",
    "slip",
    "fractures",
    "displacement",
    "threepoint",
    "log",
    "ortho",
    "dem",
    "section",
    "extend",
    "surface",
    "measurable",
    "facets",
    "trace",
    "plan",
    "check",
    "frames",
    "reconstruct",
    "register",
    "compare",
    "project",
    "export",
    "completion",
)
"""Names of the commands, which equal the names of their modules."""


def opens_window(arguments: Sequence[str]) -> bool:
    """Return whether to open the window: if there are no words, or only existing paths.

    A first word that equals the name of a command never opens the window.
    """
    if arguments and arguments[0] in COMMANDS:
        return False
    return all(not word.startswith("-") and _path_exists(word) for word in arguments)


def check_first_word(arguments: Sequence[str]) -> None:
    """Raise UsageError if the first word is neither a command nor an option.

    The words must not open the window (`opens_window`). The error contains the most similar command
    or file.
    """
    if not arguments or arguments[0] in COMMANDS or arguments[0].startswith("-"):
        return
    unknown_word = next((word for word in arguments if not _is_option_or_path(word)), None)
    if unknown_word is None:
        option = next(word for word in arguments if word.startswith("-"))
        raise UsageError(Finding("command.window-options"), field=option)
    if unknown_word != arguments[0] or _is_path_like(unknown_word):
        raise _missing_file_error(unknown_word)
    suggestion = nearest_word(unknown_word.casefold(), [*COMMANDS, "--help", "--version"])
    finding = Finding(
        "command.unknown", value=unknown_word, nearest=suggestion, commands=", ".join(COMMANDS)
    )
    raise UsageError(finding, field="COMMAND")


def _is_option_or_path(word: str) -> bool:
    return word.startswith("-") or _path_exists(word)


def _path_exists(word: str) -> bool:
    # pathlib raises errors for names that are too long and for inaccessible folders.
    return os.path.exists(word)


def nearest_word(word: str, names: Sequence[str], min_similarity: float = 0.6) -> str | None:
    """Return the only name that starts with a word, or else the most similar name, or None.

    Parameters
    ----------
    word : str
    names : sequence of str
    min_similarity : float, optional
        Minimum similarity ratio, see `difflib`.

    Returns
    -------
    str or None
    """
    import difflib

    prefix_matches = [name for name in names if len(word) > 1 and name.startswith(word)]
    if len(prefix_matches) == 1:
        return prefix_matches[0]
    matches = difflib.get_close_matches(word, names, 1, min_similarity)
    return matches[0] if matches else None


def _is_path_like(word: str) -> bool:
    return len(Path(word).parts) > 1 or bool(Path(word).suffix)


def _missing_file_error(word: str) -> UsageError:
    path = Path(word)
    try:
        neighbours = sorted(sibling.name for sibling in path.parent.iterdir())
    except OSError:
        return UsageError(Finding("folder.missing"), file=path.parent)
    if suggestion := nearest_word(path.name, neighbours):
        return UsageError(Finding("file.misspelt", nearest=path.with_name(suggestion)), file=word)
    return UsageError(Finding("file.missing"), file=word)
