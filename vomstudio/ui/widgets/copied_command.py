"""Copying of a dialog or panel as a shell command with the same result."""

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
"""Arguments of a command; an option and its value form a pair."""


class CopyCommandButton(QToolButton):
    """Button that copies a command; its tooltip describes the command or why it is disabled.

    Parameters
    ----------
    description : str
        Description of the command, as part of a sentence.
    """

    def __init__(self, clicked_callback: Callable[[], object], description: str) -> None:
        super().__init__()
        self._description = description
        self.setIcon(theme.icon("console"))
        self.setText(tr("Copy as command"))
        self.setAccessibleName(tr("Copy as command"))
        self.setObjectName("copy_command")
        self.clicked.connect(lambda _=False: clicked_callback())
        self.set_enabled(None)

    def set_enabled(self, disabled_reason: Finding | None) -> None:
        """Enable the button, or disable it with a reason."""
        self.setEnabled(disabled_reason is None)
        self.setToolTip(
            tr(
                "{button}: {more}",
                button=tr("Copy as command"),
                more=disabled_reason or self._description,
            )
        )


def format_command_line(arguments: CommandArguments) -> str:
    """Return a command, quoted for the shell of this system.

    Numbers are written with full precision.
    """
    parts: list[str] = []
    for argument in arguments:
        if isinstance(argument, tuple):
            option, value = argument[0], _argument_text(argument[1])
            # A value with a leading dash would be parsed as an option.
            parts += [f"{option}={value}"] if value.startswith("-") else [option, value]
        else:
            parts.append(_argument_text(argument))
    return subprocess.list2cmdline(parts) if sys.platform == "win32" else shlex.join(parts)


def format_numbers(values: Iterable[float]) -> str:
    """Return numbers with full precision, separated by commas."""
    return ",".join(_argument_text(float(value)) for value in values)


def _argument_text(argument: CommandArgument) -> str:
    return repr(argument).removesuffix(".0") if isinstance(argument, float) else str(argument)


def copy_command(studio: Studio, arguments: CommandArguments, file: Path | None = None) -> None:
    """Copy a `vomstudio` command to the clipboard.

    Parameters
    ----------
    file : Path, optional
        File that was written for the command.
    """
    QGuiApplication.clipboard().setText(format_command_line(["vomstudio", *arguments]))
    if file is None:
        studio.info(Finding("command.copied"))
    else:
        studio.info(Finding("command.copied-with-file", file=file))


def copy_with_file(
    parent: QWidget,
    studio: Studio,
    default_name: str,
    write: Callable[[Path], object],
    arguments: Callable[[Path], CommandArguments],
) -> None:
    """Ask for the input file of a command, write it, and copy the command.

    Parameters
    ----------
    default_name : str
        Proposed file name, with its extension.
    write : callable
        Writes the file and may raise VomError. It replaces an existing file, which the dialog has
        confirmed.
    arguments : callable
        Returns the arguments of the command from the path of the file.
    """
    suffix = Path(default_name).suffix.removeprefix(".")
    formats = {suffix: suffix.upper()}
    path = ask_for_target(parent, studio, tr("File for the command"), default_name, formats)
    if path is None:
        return
    try:
        write(path)
    except VomError as error:
        studio.fail(error)
        return
    copy_command(studio, arguments(path), path)


def find_model_arguments(studio: Studio, model: Model) -> CommandArguments | None:
    """Return the file of a model and the option for its placement in the project.

    Returns None if the file was not found.
    """
    path = studio.project.find_model(model)
    return None if path is None else [path, ("--project", studio.project.folder)]
