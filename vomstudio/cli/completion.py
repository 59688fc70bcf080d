"""`vomstudio completion`: completion of commands and options by a shell."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from vomstudio.cli.common.arguments import Subparsers, add_command
from vomstudio.cli.common.output import Output
from vomstudio.core.words import tr

if TYPE_CHECKING:
    from vomstudio.cli.common.shell_completion import CommandWords

SHELLS = ("bash", "zsh", "fish")


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``completion`` command.

    Parameters
    ----------
    subparsers : Subparsers
    """
    parser = add_command(
        subparsers,
        "completion",
        run,
        help_=tr("Print a shell completion script for commands and options"),
    )
    parser.add_argument("shell", choices=SHELLS, help=tr("shell that reads the script"))


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio completion``.

    Parameters
    ----------
    args : Namespace
        Parsed arguments.
    out : Output
        Object that receives the results, warnings and progress.
    """
    from vomstudio.cli.common.entry import build_parser
    from vomstudio.cli.common.shell_completion import (
        bash_script,
        command_words,
        fish_script,
        zsh_script,
    )

    commands: list[CommandWords] = command_words(build_parser(()))
    write = {"bash": bash_script, "zsh": zsh_script, "fish": fish_script}[args.shell]
    script = write(commands)
    out.result({"shell": args.shell, "script": script})
    out.text(script.rstrip("\n"))
