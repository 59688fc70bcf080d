"""Copying of the `register` command with control points, known lines and readings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from PySide6.QtWidgets import QWidget

from vomstudio.core.options import option_words
from vomstudio.geometry.registrations import NorthReference
from vomstudio.project.kinds.control_point import ControlPoint
from vomstudio.project.kinds.known_line import KnownLine
from vomstudio.registration.register_options import RegisterOptions
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.readings import Readings, placement_north
from vomstudio.ui.widgets.copied_command import (
    CommandArguments,
    copy_command,
    copy_with_file,
    format_numbers,
)


def copy_register_command(
    parent: QWidget,
    studio: Studio,
    model: Path,
    points: Sequence[ControlPoint],
    lines: Sequence[KnownLine],
    crs: str | None,
    readings: Readings,
    north: NorthReference | None,
    *,
    fixed_scale: float | None = None,
    click_sigma_m: float | None = None,
) -> None:
    """Save points and readings as tables, if any, and copy the command to the clipboard.

    Parameters
    ----------
    north : NorthReference or None
        North reference of the azimuths.
    fixed_scale : float or None
        Fixed scale in metres per unit of the model file.
    click_sigma_m : float or None
        Standard error of a click on the model in metres, or None for the default.
    """
    from vomstudio.io.control.writing import write_compass, write_pairs
    from vomstudio.studio.placing.known_planes import compass_table
    from vomstudio.studio.placing.read_north import to_register_options
    from vomstudio.studio.placing.registering import control_pairs

    pairs = control_pairs(points)
    table = compass_table(lines, readings.directions)
    turned_deg = 0.0
    options = RegisterOptions()
    north_reference = None if north is None else placement_north(north, lines)
    if north_reference is not None:
        north_options = to_register_options(readings.compass, north_reference, pairs, crs)
        if north_options is None:
            turned_deg, north_options = (
                north_reference.turned_deg,
                RegisterOptions(north_sigma_deg=north_reference.doubt_deg),
            )
        options = north_options
    options = add_known_lines(options, lines, turned_deg)
    options = replace(options, crs=crs, click_sigma_m=click_sigma_m)
    if fixed_scale is not None:
        options = add_fixed_scale(options, fixed_scale)
    if table is not None:
        table = replace(table, azimuth_deg=(table.azimuth_deg + turned_deg) % 360.0)
    if not len(pairs.labels) and table is None:
        copy_command(studio, ["register", model, *option_words(options)])
        return

    def write(file: Path) -> None:
        if len(pairs.labels):
            write_pairs(file, pairs)
        if table is not None:
            write_compass(_readings_file(file, includes_pairs=len(pairs.labels) > 0), table)

    def build_command(file: Path) -> CommandArguments:
        readings_file = _readings_file(file, includes_pairs=len(pairs.labels) > 0)
        files = replace(
            options,
            pairs=str(file) if len(pairs.labels) else None,
            orientations=None if table is None else str(readings_file),
        )
        return ["register", model, *option_words(files)]

    default_name = "pairs.csv" if len(pairs.labels) else "readings.csv"
    copy_with_file(parent, studio, default_name, write, build_command)


def add_fixed_scale(options: RegisterOptions, scale: float) -> RegisterOptions:
    """Return the options of `register` with a fixed scale in metres per model unit.

    A scale other than 1 comes from an earlier registration. The model file does not contain it, so
    it is passed as a known length.
    """
    from vomstudio.registration.length_evidence import FIXED_SCALE_ERROR

    if abs(scale - 1.0) < 1e-9:
        return replace(options, keep_scale=True)
    text = format_numbers([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, scale, FIXED_SCALE_ERROR * scale])
    return replace(options, scale=(*options.scale, text))


def _readings_file(file: Path, *, includes_pairs: bool) -> Path:
    """Return the path of the readings table: `file` itself unless it contains point pairs."""
    return file.with_name(f"{file.stem}_readings{file.suffix}") if includes_pairs else file


def add_known_lines(
    options: RegisterOptions, lines: Sequence[KnownLine], turned_deg: float = 0.0
) -> RegisterOptions:
    """Return the options of `register` with the known lines added.

    Parameters
    ----------
    options : RegisterOptions
    lines : sequence of KnownLine
    turned_deg : float
        Correction in degrees that is added to the azimuths.
    """
    from vomstudio.studio.placing.known_lines import placement_lines

    names = {"level": "level", "plumb": "plumb", "azimuth": "bearing", "length": "scale"}
    texts: dict[str, list[str]] = {name: [] for name in names.values()}
    for line in placement_lines(lines):
        value = line.value
        if line.kind == "azimuth" and value is not None and turned_deg:
            value = (value + turned_deg) % 360.0
        numbers = [item for item in (value, line.sigma) if item is not None]
        text = format_numbers([*line.vertices[0], *line.vertices[-1], *numbers])
        texts[names[line.kind]].append(text)
    values: dict[str, Any] = {name: tuple(item) for name, item in texts.items()}
    return replace(options, **values)
