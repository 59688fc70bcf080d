"""Options without a command: `--version`, `--install-desktop`, `--uninstall-desktop`."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from vomstudio.cli.common.arguments import HelpRequested, Parser
from vomstudio.cli.common.first_word import COMMANDS
from vomstudio.cli.common.output import Output
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.version import __version__
from vomstudio.core.words import tr

GLOBAL_OPTIONS = ("--version", "--install-desktop", "--uninstall-desktop")
GRAPHICS_TIMEOUT_S = 30


def add_global_options(parser: Parser) -> None:
    """Add the options of the program itself."""
    parser.add_argument(
        "--version",
        action="store_true",
        help=tr("print the version; with --json also versions of Python, packages and graphics"),
    )
    desktop_group = parser.add_mutually_exclusive_group()
    desktop_group.add_argument(
        "--install-desktop",
        action="store_true",
        help=tr("add VOM Studio to the desktop menu of this user (Linux)"),
    )
    desktop_group.add_argument(
        "--uninstall-desktop",
        action="store_true",
        help=tr("remove the files that --install-desktop wrote"),
    )
    parser.add_argument("--json", action="store_true", help=tr("print one JSON object on stdout"))


def run_global_option(args: argparse.Namespace, output: Output) -> None:
    """Run an option that does not need a command, such as ``--version``.

    Raises
    ------
    HelpRequested
        For ``--version`` without ``--json``; contains the version.
    UsageError
        If there is neither a command nor such an option.
    """
    if args.version:
        if not args.json:
            raise HelpRequested(f"VOM Studio {__version__}")
        output.result(_versions())
    elif args.install_desktop:
        from vomstudio.core.files.desktop import install

        files = install()
        output.text("\n".join(map(str, files)))
        output.result({"files": files})
    elif args.uninstall_desktop:
        from vomstudio.core.files.desktop import uninstall

        files = uninstall()
        output.text(
            "\n".join(map(str, files))
            or tr("VOM Studio is not in the desktop menu, so nothing was removed.")
        )
        output.result({"files": files})
    else:
        raise UsageError(Finding("command.missing", commands=", ".join(COMMANDS)))


def _versions() -> dict[str, Any]:
    import platform

    from vomstudio.core.failures.report import packages

    return {
        "version": __version__,
        "python": platform.python_version(),
        "system": platform.platform(),
        "machine": platform.machine(),
        "packages": packages(),
        "graphics": _graphics_driver(),
    }


def _graphics_driver() -> dict[str, str] | None:
    """Return the graphics driver, or None if unknown.

    The driver is queried in a separate process because a broken driver may end the process.
    """
    import json
    import subprocess

    command = [sys.executable, "-P", "-m", "vomstudio", "--graphics"]
    try:
        output = subprocess.run(
            command, capture_output=True, text=True, check=True, timeout=GRAPHICS_TIMEOUT_S
        ).stdout
        versions: dict[str, str] = json.loads(output.splitlines()[-1])
    except (OSError, subprocess.SubprocessError, ValueError, IndexError):
        return None
    return versions
