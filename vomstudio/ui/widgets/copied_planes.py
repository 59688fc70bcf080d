"""Tables of features that are read by a copied command."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from PySide6.QtWidgets import QWidget

from vomstudio.ui.base.studio import Studio
from vomstudio.ui.widgets.copied_command import CommandArguments, copy_with_file


def copy_with_table(
    parent: QWidget,
    studio: Studio,
    proposed_text: str,
    ids: Iterable[str],
    arguments: Callable[[Path], CommandArguments],
) -> None:
    """Ask for a file, write the orientations of features to it, and copy the command.

    Parameters
    ----------
    proposed_text : str
        Proposed file name, which ends in .csv.
    """
    from vomstudio.project.exports.export import write_csv
    from vomstudio.project.tables.project_table import project_table

    selected_ids = set(ids)

    def write(path: Path) -> None:
        write_csv(
            path, project_table(studio.records, studio.measurements, selected_ids), force=True
        )

    copy_with_file(parent, studio, proposed_text, write, arguments)


def result_path(table: Path, suffix: str) -> Path:
    """Return the path of a result next to its table: NAME_result.ENDING."""
    return table.with_name(f"{table.stem}_result.{suffix}")
