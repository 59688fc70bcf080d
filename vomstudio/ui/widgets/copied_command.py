"""A dialog or panel as a line for the shell that gives the same result."""

from __future__ import annotations

import shlex
import subprocess
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QToolButton, QWidget

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.records import Model
from vomstudio.ui.base import theme
from vomstudio.ui.base.command_targets import ask_for_target
from vomstudio.ui.base.studio import Studio

CommandArgument = str | Path | float
CommandArguments = Sequence[CommandArgument | tuple[str, CommandArgument]]
"""Of a command; an option with its value is a pair."""


class CopyCommandButton(QToolButton):
    """Says in its tooltip what it copies, or why it cannot now."""

    def __init__(self, clicked: Callable[[], object], what: str) -> None:
        """what : goes with the command, as a part of a sentence"""
        super().__init__()
        self._what = what
        self.setIcon(theme.icon("console"))
        self.setText(tr("Copy as command"))
        self.setAccessibleName(tr("Copy as command"))
        self.setObjectName("copy_command")
        self.clicked.connect(lambda _=False: clicked())
        self.allow(None)

    def allow(self, why_not: Finding | None) -> None:
        """why_not : None where it can be copied now"""
        self.setEnabled(why_not is None)
        self.setToolTip(
            tr("{button}: {more}", button=tr("Copy as command"), more=why_not or self._what)
        )


def format_command_line(words: CommandArguments) -> str:
    """A command with its arguments, quoted for the shell of this system. Numbers keep all their
    digits."""
    said: list[str] = []
    for word in words:
        if isinstance(word, tuple):
            option, value = word[0], _text(word[1])
            # A value that begins so would be taken for an option.
            said += [f"{option}={value}"] if value.startswith("-") else [option, value]
        else:
            said.append(_text(word))
    return subprocess.list2cmdline(said) if sys.platform == "win32" else shlex.join(said)


def format_numbers(values: Iterable[float]) -> str:
    """Numbers with all their digits, between commas."""
    return ",".join(_text(float(value)) for value in values)


def _text(word: CommandArgument) -> str:
    return repr(word).removesuffix(".0") if isinstance(word, float) else str(word)


def copy_command(studio: Studio, words: CommandArguments, file: Path | None = None) -> None:
    """Put `vomstudio` and these words on the clipboard. file : what was written for it"""
    QGuiApplication.clipboard().setText(format_command_line(["vomstudio", *words]))
    if file is None:
        studio.info(Finding("command.copied"))
    else:
        studio.info(Finding("command.copied-with-file", file=file))


def copy_with_file(
    parent: QWidget,
    studio: Studio,
    proposed: str,
    write: Callable[[Path], object],
    words: Callable[[Path], CommandArguments],
) -> None:
    """Ask where what the command reads shall be written, write it, and copy the command. proposed :
    name of the file, whose ending it gets. write : may raise VomError; it replaces what is there,
    as the dialog has asked"""
    ending = Path(proposed).suffix.removeprefix(".")
    formats = {ending: ending.upper()}
    path = ask_for_target(parent, studio, tr("File for the command"), proposed, formats)
    if path is None:
        return
    try:
        write(path)
    except VomError as error:
        studio.fail(error)
        return
    copy_command(studio, words(path), path)


def model_arguments(studio: Studio, model: Model) -> CommandArguments | None:
    """The file of a model and the option by which it stands as it does in this project; None where
    the file was not found."""
    path = studio.project.find_model(model)
    return None if path is None else [path, ("--project", studio.project.folder)]
