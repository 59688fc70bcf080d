"""Tables of orientations as arguments of commands."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.cli.common.arguments import Parser
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.io.text.table_options import TableOptions

if TYPE_CHECKING:
    from vomstudio.io.text.orientation_reading import OrientationTable


def add_table_options(parser: Parser) -> None:
    """Add ``--azimuth``, ``--columns`` and ``--layer``.

    Parameters
    ----------
    parser : Parser
    """
    add_options(parser, TableOptions)


def read_table_picks(
    args: argparse.Namespace, path: str | Path, *, repeats: bool = False, azimuth_only: bool = False
) -> OrientationTable:
    """Read a table of orientations, or a project, by the options of a command.

    Parameters
    ----------
    args : Namespace
        Parsed arguments.
    path : str or Path
    repeats, azimuth_only : bool
        As for `vomstudio.project.picks.read_picks`.

    Raises
    ------
    InputError, UsageError
    """
    from vomstudio.io.text.column_mapping import parse_columns
    from vomstudio.project.picks import read_picks

    options = parse_options(args, TableOptions)
    return read_picks(
        path,
        options.azimuth,
        columns=parse_columns(options.columns),
        layer=options.layer,
        repeats=repeats,
        azimuth_only=azimuth_only,
    )
