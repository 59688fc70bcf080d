"""Tables of points with text: log boundaries, three-point problems, and pairs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.text.tables import TextTable

PAIR_COLUMNS = (
    "hanging_x",
    "hanging_y",
    "hanging_z",
    "footwall_x",
    "footwall_y",
    "footwall_z",
)


@dataclass(frozen=True, eq=False)
class Boundaries:
    """Points with names and notes.

    Parameters
    ----------
    points : (n, 3) float64
        Coordinates as in the file, or in the World frame (metres) from
        `vomstudio.io.gate.point_tables`.
    names, lithologies, notes : list of str
    dropped : tuple of int
        Lines of rows that have no coordinates.
    """

    points: FloatArray
    names: list[str]
    lithologies: list[str]
    notes: list[str]
    dropped: tuple[int, ...]
    findings: tuple[Finding, ...] = ()

    @property
    def warnings(self) -> tuple[Finding, ...]:
        """Findings about the frame and about rows without coordinates."""
        if not self.dropped:
            return self.findings
        return (
            *self.findings,
            Finding(
                "table.rows-left-out",
                count=len(self.dropped),
                needed=tr("coordinates"),
                lines=self.dropped,
            ),
        )


def extract_boundaries(table: TextTable) -> Boundaries:
    """Return the points of a table with their name, lithology and notes, if present.

    Without a header, the first three columns are x, y and z.

    Raises
    ------
    InputError
        If no row has coordinates.
    """
    columns = [table.find(name) for name in "xyz"] if table.names is not None else [0, 1, 2]
    if table.width < 3:
        raise InputError(
            Finding("table.column-count", count=table.width, columns=("x", "y", "z")),
            file=table.path,
        )
    points = table.numbers(columns)
    is_valid = np.isfinite(points).all(axis=1)
    if not is_valid.any():
        raise InputError(
            Finding("table.no-valid-rows", count=len(table), needed=tr("coordinates")),
            file=table.path,
        )
    rows = np.flatnonzero(is_valid)

    def column_texts(name: str) -> list[str] | None:
        return table.labels(table.find(name)) if table.has(name) else None

    texts = {name: column_texts(name) for name in ("name", "lithology", "notes")}
    names = texts["name"] or [str(i + 1) for i in range(len(table))]
    rocks, notes = (texts[name] or [""] * len(table) for name in ("lithology", "notes"))
    return Boundaries(
        points[rows],
        [names[i] for i in rows],
        [rocks[i] for i in rows],
        [notes[i] for i in rows],
        tuple(int(line) for line in table.line_numbers[~is_valid]),
    )


def extract_pairs(table: TextTable) -> tuple[list[str], FloatArray]:
    """Return names and coordinates of pairs of points on both sides of a fault.

    Returns
    -------
    names : list of str
    points : (n, 6) float64
        x, y, z on the hanging wall, followed by those on the footwall; NaN if missing.

    Raises
    ------
    InputError
        If the table contains no coordinates.
    """
    if table.names is None:
        if table.width != 6:
            raise InputError(
                Finding("table.column-count", count=table.width, columns=PAIR_COLUMNS),
                file=table.path,
            )
        points = table.numbers(range(6))
    else:
        points = table.numbers([table.find(name) for name in PAIR_COLUMNS])
    names = (
        table.labels(table.find("name"))
        if table.has("name")
        else [str(i + 1) for i in range(len(table))]
    )
    if not np.isfinite(points).any():
        raise InputError(
            Finding("table.no-valid-rows", count=len(table), needed=tr("coordinates")),
            file=table.path,
        )
    return names, points
