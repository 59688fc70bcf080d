"""Rows of a file of features, before they become features of a project."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import read_small_file
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.orientation import Plane
from vomstudio.io.gate.stated_crs import StatedCrs
from vomstudio.io.text.column_names import normalise_name
from vomstudio.io.text.encodings import decode_text
from vomstudio.io.text.file_text import MAX_OBJECTS, refuse_many_lines
from vomstudio.io.text.orientation_columns import ALIASES
from vomstudio.io.text.rows import parse_number

LAYERS = ("stations", "contacts", "lithologies", "traces", "lineations")
"""Layers of this program's exports that are imported."""
WORLD = StatedCrs()
MAX_TABLE_BYTES = 256 << 20


@dataclass(frozen=True)
class ListedRow:
    """Row of a layer or table.

    Attributes
    ----------
    layer : str
        One of `LAYERS`, or "planes".
    points : (n, 3) float64
        Points as in the file; missing heights are NaN.
    values : mapping of str to Any
        Attributes by column name in lower case.
    frame : StatedCrs
        Frame of the points.
    groups : tuple of str
        Names of the layers or groups that contain the row, the innermost last.
    plane : Plane or None
        Orientation that the file states for the points.
    notes : str
        Notes if the row has none of its own.
    structure : str
        Name of the structure that contains the row, used as its set.
    """

    layer: str
    points: FloatArray
    values: Mapping[str, Any] = field(default_factory=dict)
    frame: StatedCrs = WORLD
    groups: tuple[str, ...] = ()
    plane: Plane | None = None
    notes: str = ""
    structure: str = ""

    def text(self, *names: str) -> str:
        """Return the text of the first of these columns that is not empty, or ""."""
        values = (self.values.get(name) for name in names)
        value = next(
            (
                value
                for value in values
                if value is not None and value == value and str(value).strip()
            ),
            "",
        )
        return str(value).strip()

    def label(self, number: int) -> str:
        """Return the name of the row for messages; `number` counts from 1."""
        return self.text("name", "number", "id") or tr("row {number}", number=number)


@dataclass
class ReadingReport:
    """Findings about reading a file, and the omitted parts with the reasons."""

    findings: list[Finding] = field(default_factory=list)
    skipped: list[tuple[str, Finding]] = field(default_factory=list)


def stated_plane(values: Mapping[str, Any]) -> Plane | None:
    """Return the plane in the columns of dip direction and dip of a row, or None.

    Strikes are not used, because their convention is not known.

    Parameters
    ----------
    values : mapping of str to Any
        Attributes by column name.
    """
    angles: dict[str, float] = {}
    for name, value in values.items():
        normalised_name = normalise_name(name)
        for meaning in ("dip direction", "dip"):
            if normalised_name in ALIASES[meaning] and value is not None:
                number = parse_number(str(value).strip(), decimal_comma=True)
                if number is not None:
                    angles[meaning] = number
    return plane_from_angles(angles.get("dip direction"), angles.get("dip"))


def plane_from_angles(dip_direction_deg: float | None, dip_deg: float | None) -> Plane | None:
    """Return the plane with these angles, or None if one is missing or out of range.

    Parameters
    ----------
    dip_direction_deg, dip_deg : float or None
    """
    if dip_direction_deg is None or dip_deg is None:
        return None
    # NaN is out of range.
    if not (abs(dip_direction_deg) <= 720.0 and 0.0 <= dip_deg <= 90.0):
        return None
    return Plane(dip_direction_deg, dip_deg)


def to_number(text: str | None) -> float:
    """Return the number in a cell, or NaN.

    Parameters
    ----------
    text : str or None
    """
    value = None if text is None else parse_number(text.strip(), decimal_comma=False)
    return math.nan if value is None else value


def read_table_lines(path: Path) -> list[str]:
    """Return the lines of a text table.

    Parameters
    ----------
    path : Path

    Raises
    ------
    InputError
        If the file cannot be read, is not text, or has too many lines.
    """
    try:
        lines = (
            decode_text(read_small_file(path, MAX_TABLE_BYTES)).removeprefix("\ufeff").splitlines()
        )
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(Finding("table.unreadable", reason=error), file=path) from error
    refuse_many_lines(path, len(lines), MAX_OBJECTS)
    return lines
