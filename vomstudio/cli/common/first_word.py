"""What the first words of the command line are: a command, options, or files for the window."""

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
)
"""The words after `vomstudio` that are commands, each the name of its module here."""


def is_for_window(words: Sequence[str]) -> bool:
    """Whether the window opens: without words, or with files and folders that are there."""
    if words and words[0] in COMMANDS:
        return False
    return all(not word.startswith("-") and _is_there(word) for word in words)


def check_first_word(words: Sequence[str]) -> None:
    """Raises UsageError for what is neither a command nor there, with the nearest that is."""
    if not words or words[0] in COMMANDS or words[0].startswith("-"):
        return
    missing = next((word for word in words if not _may_be_meant(word)), None)
    if missing is None:
        option = next(word for word in words if word.startswith("-"))
        raise UsageError(Finding("command.window-options"), field=option)
    if missing != words[0] or _looks_like_a_path(missing):
        raise _no_such_file(missing)
    nearest = nearest_of(missing.casefold(), COMMANDS)
    finding = Finding(
        "command.unknown", value=missing, nearest=nearest, commands=", ".join(COMMANDS)
    )
    raise UsageError(finding, field="COMMAND")


def _may_be_meant(word: str) -> bool:
    return word.startswith("-") or _is_there(word)


def _is_there(word: str) -> bool:
    # pathlib raises for names that are too long, and where a folder may not be entered.
    return os.path.exists(word)


def nearest_of(word: str, names: Sequence[str], alike: float = 0.6) -> str | None:
    """The name that a misspelt word is nearest to; None where none is near. alike : share of
    letters in common, of difflib"""
    import difflib

    found = difflib.get_close_matches(word, names, 1, alike)
    return found[0] if found else None


def _looks_like_a_path(word: str) -> bool:
    return len(Path(word).parts) > 1 or bool(Path(word).suffix)


def _no_such_file(word: str) -> UsageError:
    path = Path(word)
    try:
        beside = sorted(other.name for other in path.parent.iterdir())
    except OSError:
        return UsageError(Finding("folder.missing"), file=path.parent)
    if nearest := nearest_of(path.name, beside):
        return UsageError(Finding("file.misspelt", nearest=path.with_name(nearest)), file=word)
    return UsageError(Finding("file.missing"), file=word)
