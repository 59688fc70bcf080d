"""Features as the table that a copied command reads."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from PySide6.QtWidgets import QWidget

from vomstudio.ui.base.studio import Studio
from vomstudio.ui.widgets.copied_command import CommandArguments, copy_with_file


def copy_with_table(
    parent: QWidget,
    studio: Studio,
    proposed: str,
    ids: Iterable[str],
    words: Callable[[Path], CommandArguments],
) -> None:
    """Ask where the orientation table of these features shall be written, write it, and copy the
    command. proposed : its name, which ends in .csv"""
    from vomstudio.project.exports.export import write_csv
    from vomstudio.project.tables.project_table import project_table

    only = set(ids)

    def write(path: Path) -> None:
        write_csv(path, project_table(studio.records, studio.measurements, only), force=True)

    copy_with_file(parent, studio, proposed, write, words)


def result_path(table: Path, ending: str) -> Path:
    """A result of the command: NAME_result.ENDING beside its table."""
    return table.with_name(f"{table.stem}_result.{ending}")
