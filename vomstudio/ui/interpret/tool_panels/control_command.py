"""Control points, known lines and compass readings as the command that places a model by them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from PySide6.QtWidgets import QWidget

from vomstudio.document.kinds.control_point import ControlPoint
from vomstudio.document.kinds.known_line import KnownLine
from vomstudio.document.records import ReadNorth
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.forms.copied_command import Word, copy_command, copy_with_file, numbers_text
from vomstudio.ui.interpret.tool_panels.readings import Readings, used_north


def copy_register(
    parent: QWidget,
    studio: Studio,
    model: Path,
    points: Sequence[ControlPoint],
    lines: Sequence[KnownLine],
    crs: str | None,
    readings: Readings,
    north: ReadNorth | None,
    *,
    kept_scale: float | None = None,
    click_sigma_m: float | None = None,
) -> None:
    """Ask for the tables of points and readings, where there are some, and put the command on the
    clipboard. north : how azimuths are counted; kept_scale : metres per unit of the model's file
    click_sigma_m : error of the click on the model as typed, None for the default"""
    from vomstudio.io.control.writing import write_compass, write_pairs
    from vomstudio.workspace.placing.known_planes import compass_table
    from vomstudio.workspace.placing.read_north import as_the_command
    from vomstudio.workspace.placing.registering import pairs_of

    pairs = pairs_of(points)
    table = compass_table(lines, readings.seen)
    more: list[Word | tuple[str, Word]] = [] if crs is None else [("--crs", crs)]
    if kept_scale is not None:
        more += _keeping(kept_scale)
    if click_sigma_m is not None:
        more.append(("--click-sigma", click_sigma_m))
    turn = 0.0
    used = None if north is None else used_north(north, lines)
    if used is not None:
        counting = as_the_command(readings.compass, used, pairs, crs)
        if counting is None:
            turn, counting = used.turned_deg, [("--north-sigma", used.doubt_deg)]
        more += counting
    more = [*options(lines, turn), *more]
    if table is not None:
        table = replace(table, azimuth_deg=(table.azimuth_deg + turn) % 360.0)
    if not len(pairs.labels) and table is None:
        copy_command(studio, ["register", model, *more])
        return

    def write(file: Path) -> None:
        if len(pairs.labels):
            write_pairs(file, pairs)
        if table is not None:
            write_compass(_readings_file(file, pairs=len(pairs.labels) > 0), table)

    def words(file: Path) -> list[Word | tuple[str, Word]]:
        said: list[Word | tuple[str, Word]] = ["register", model]
        if len(pairs.labels):
            said.append(("--pairs", file))
        if table is not None:
            beside = _readings_file(file, pairs=len(pairs.labels) > 0)
            said.append(("--orientations", beside))
        return [*said, *more]

    proposed = "pairs.csv" if len(pairs.labels) else "readings.csv"
    copy_with_file(parent, studio, proposed, write, words)


def _keeping(scale: float) -> list[Word | tuple[str, Word]]:
    """The scale that is kept; other than 1 it is that of an earlier placement, which the file does
    not have."""
    from vomstudio.registration.length_evidence import KEPT

    if abs(scale - 1.0) < 1e-9:
        return ["--keep-scale"]
    return [("--scale", numbers_text([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, scale, KEPT * scale]))]


def _readings_file(file: Path, *, pairs: bool) -> Path:
    """The file that was chosen, or one beside it where that is for the points."""
    return file.with_name(f"{file.stem}_readings{file.suffix}") if pairs else file


def options(lines: Sequence[KnownLine], turned_deg: float = 0.0) -> list[tuple[str, Word]]:
    """Lines whose ends were clicked, as the command takes them. turned_deg : added to azimuths"""
    from vomstudio.workspace.placing.known_lines import usable

    names = {"level": "--level", "plumb": "--plumb", "azimuth": "--bearing", "length": "--scale"}
    said: list[tuple[str, Word]] = []
    for line in usable(lines):
        value = line.value
        if line.kind == "azimuth" and value is not None and turned_deg:
            value = (value + turned_deg) % 360.0
        known = [each for each in (value, line.sigma) if each is not None]
        text = numbers_text([*line.vertices[0], *line.vertices[-1], *known])
        said.append((names[line.kind], text))
    return said
