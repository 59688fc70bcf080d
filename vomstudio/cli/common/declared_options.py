"""Arguments of a command, generated from an options class."""

from __future__ import annotations

import argparse
from typing import Any, TypeVar

from vomstudio.cli.common.arguments import Parser
from vomstudio.core.options import declarations
from vomstudio.words import tr

Options = TypeVar("Options")


def add_options(parser: Parser, options: type[Any]) -> None:
    """Add an argument for each option of a class (`vomstudio.core.options.option`)."""
    for each in declarations(options):
        words: dict[str, Any] = {"dest": each.name, "help": tr(each.help)}
        if each.choices is not None:
            words["choices"] = list(each.choices)
        elif each.metavar is not None:
            words["metavar"] = each.metavar
        parser.add_argument(each.flag, **words)


def options_from(args: argparse.Namespace, options: type[Options]) -> Options:
    """Return the options object of a parsed command. Raises UsageError."""
    given = {each.name: getattr(args, each.name, None) for each in declarations(options)}
    return options(**{name: value for name, value in given.items() if value is not None})
