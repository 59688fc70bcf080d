"""Arguments of a command that are generated from an options class."""

from __future__ import annotations

import argparse
from typing import Any, TypeVar

from vomstudio.cli.common.arguments import Parser
from vomstudio.core.options import Declaration, declarations
from vomstudio.core.words import tr

Options = TypeVar("Options")


def add_options(parser: Parser, options: type[Any]) -> None:
    """Add an argument for each option of a class (`vomstudio.core.options.option`).

    Options that the parser already has, from a class with the same base, are not added again.
    """
    for item in declarations(options):
        if item.flag in parser._option_string_actions:
            continue
        settings: dict[str, Any] = {"dest": item.name, "help": help_text(item).replace("%", "%%")}
        if item.kind is bool:
            settings["action"] = (
                "store_true" if item.default is False else argparse.BooleanOptionalAction
            )
        elif item.choices is not None:
            settings["choices"] = list(item.choices)
        else:
            settings["metavar"] = metavar(item)
            if item.is_repeated:
                settings["action"] = "append"
            if item.flag_value is not None:
                settings |= {"nargs": "?", "const": item.flag_value}
            if item.kind is not str:
                settings["type"] = item.kind
        if item.is_required:
            settings["required"] = True
        parser.add_argument(item.flag, **settings)


def help_text(declaration: Declaration) -> str:
    """Return the help text of an option with its default."""
    text = tr(declaration.help)
    if declaration.is_repeated:
        return tr("{help}; may be repeated", help=text)
    default = tr(declaration.automatic) if declaration.automatic else declaration.default
    if default is None or default is False:
        return text
    if isinstance(default, float):
        default = f"{default:g}"
    return tr("{help} (default: {default})", help=text, default=default)


def metavar(declaration: Declaration) -> str:
    """Return the placeholder for the value of an option, such as DEG."""
    if declaration.metavar is not None:
        return declaration.metavar
    if declaration.unit is not None:
        return declaration.unit.upper()
    return "N" if declaration.kind is int else "X" if declaration.kind is float else "TEXT"


def parse_options(args: argparse.Namespace, options: type[Options]) -> Options:
    """Return the options object for the parsed command. Raises UsageError."""
    values = {item: getattr(args, item.name, None) for item in declarations(options)}
    return options(
        **{
            item.name: tuple(value) if item.is_repeated else value
            for item, value in values.items()
            if value is not None
        }
    )
