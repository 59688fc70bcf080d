"""The options for the look of a printed figure: letters, symbols, lines, colours."""

from __future__ import annotations

import argparse
import re
from collections.abc import Collection, Mapping

from vomstudio.errors import UsageError
from vomstudio.words import tr

_COLOR = re.compile(r"#[0-9a-fA-F]{6}")


def add_look(parser: argparse.ArgumentParser, *, symbols: bool) -> None:
    """symbols : the figure has symbols of a size"""
    parser.add_argument("--font", metavar="NAME", help=tr("font of the figure"))
    sizes = [
        ("--font-size", tr("of the letters, in points (default 8)")),
        ("--symbol-size", tr("of the symbols, in points (default 4.5)")),
        ("--line-width", tr("of the lines, in points (default 0.8)")),
    ]
    for option, of in sizes:
        if symbols or option != "--symbol-size":
            parser.add_argument(option, type=float, metavar="PT", help=of)
    parser.add_argument("--grey", action="store_true", help=tr("without colours"))
    parser.add_argument(
        "--color",
        action="append",
        default=[],
        metavar="SET=#RRGGBB",
        help=tr("colour of a set; may be given again"),
    )


def colors_of(args: argparse.Namespace) -> dict[str, str]:
    """By the name of a set. Raises UsageError for what is no colour."""
    found = {}
    for text in args.color:
        name, equals, color = text.rpartition("=")
        if not equals or not name or not _COLOR.fullmatch(color):
            raise UsageError(
                tr("“{text}” is no colour of a set; write it like Bedding=#0072b2.", text=text),
                field="--color",
            )
        found[name] = color
    return found


def colors_among(colors: Mapping[str, str], names: Collection[str]) -> dict[str, str]:
    """By the names of the sets that there are; planes and lines of one name have the same colour.
    Raises UsageError for a set that is not there."""
    found: dict[str, str] = {}
    for name, color in colors.items():
        meant = [n for n in names if n in (name, f"{name} (planes)", f"{name} (lines)")]
        if not meant:
            raise UsageError(
                tr(
                    "There is no set {set}. The sets are {names}.", set=name, names=", ".join(names)
                ),
                field="--color",
            )
        found |= dict.fromkeys(meant, color)
    return found
