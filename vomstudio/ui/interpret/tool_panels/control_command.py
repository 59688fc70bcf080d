"""Control points and known lines as the command that places a model by them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtWidgets import QWidget

from vomstudio.document.kinds.control_point import ControlPoint
from vomstudio.document.kinds.known_line import KnownLine
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.forms.copied_command import Word, copy_command, copy_with_file
from vomstudio.ui.interpret.tool_panels.control_words import options


def copy_register(
    parent: QWidget,
    studio: Studio,
    model: Path,
    points: Sequence[ControlPoint],
    lines: Sequence[KnownLine],
    crs: str | None,
    doubt_deg: float,
) -> None:
    """Ask for the table of the points, where there are some, and put the command on the clipboard.
    doubt_deg : by which all azimuths may be off alike, 0 for none"""
    from vomstudio.io.control.writing import write_pairs
    from vomstudio.workspace.placing.registering import pairs_of

    pairs = pairs_of(points)
    more: list[tuple[str, Word]] = [] if crs is None else [("--crs", crs)]
    more += options(lines)
    if doubt_deg:
        more.append(("--north-sigma", doubt_deg))
    if not len(pairs.labels):
        copy_command(studio, ["register", model, *more])
        return
    copy_with_file(
        parent, studio, "pairs.csv", lambda file: write_pairs(file, pairs),
        lambda file: ["register", model, ("--pairs", file), *more],
    )  # fmt: skip
