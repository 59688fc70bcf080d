"""Positions of planes for set analysis, and tables of planes with their sets."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.spreadsheet_cells import comment_line, escape_foreign_cell, escape_formula
from vomstudio.core.findings import Finding
from vomstudio.geology.sets.discontinuities import Pieces
from vomstudio.io.text.column_names import normalise_name
from vomstudio.io.text.orientation_reading import OrientationTable
from vomstudio.io.text.wkt_columns import parse_wkt

SET, PROBABILITY, DISCONTINUITY = "set", "set_probability", "discontinuity"
_WKT_COLUMN = "wkt"


def extract_pieces(table: OrientationTable, positions: FloatArray | None) -> Pieces | None:
    """Return the position, extent and border of each plane in a table.

    The columns used are `area_m2`, `rms_m` with `lambda1` to `lambda3`, and `wkt` for the
    border.

    Parameters
    ----------
    table : OrientationTable
    positions : (n, 3) float or None
        World coordinates of the rows (`vomstudio.io.gate.point_tables.read_row_positions`).

    Returns
    -------
    Pieces or None
        Pieces; None if `positions` is None.

    Raises
    ------
    InputError
        If a border is not valid WKT.
    """
    if positions is None:
        return None
    n = len(positions)

    def numbers(*names: str) -> FloatArray:
        if not all(table.table.has(name) for name in names):
            return np.full((n, len(names)), np.nan)
        columns = [table.table.find(name) for name in names]
        return np.asarray(table.table.numbers(columns)[table.row_indices])

    rms, l1, l2, l3 = numbers("rms_m", "lambda1", "lambda2", "lambda3").T
    with np.errstate(divide="ignore", invalid="ignore"):
        normal_variance = rms**2
        tangential_variance = normal_variance * (l1 + l2) / (2.0 * l3)
    poles = table.vectors()
    normal_products = poles[:, :, None] * poles[:, None, :]
    scatters = (normal_variance - tangential_variance)[
        :, None, None
    ] * normal_products + tangential_variance[:, None, None] * np.eye(3)
    return Pieces(positions, scatters, numbers("area_m2")[:, 0], _rings(table, n))


def _rings(table: OrientationTable, n: int) -> tuple[FloatArray, ...]:
    if not table.table.has(_WKT_COLUMN):
        return tuple(np.zeros((0, 3)) for _ in range(n))
    import shapely

    cells = table.table.cells(table.table.find(_WKT_COLUMN))
    try:
        return parse_rings(
            [cells[row_index].strip() or None for row_index in table.row_indices.tolist()]
        )
    except shapely.errors.GEOSException as error:
        raise InputError(
            Finding("table.invalid-wkt"), file=table.path, field=_WKT_COLUMN
        ) from error


def parse_rings(texts: Sequence[str | None]) -> tuple[FloatArray, ...]:
    """Return the corners (k, 3) of each border in WKT; empty for a missing text.

    Raises
    ------
    shapely.errors.GEOSException
        If a text is not WKT.
    """
    return tuple(_outer_ring(shape) for shape in parse_wkt(texts))


def _outer_ring(shape: Any) -> FloatArray:
    """Return the corners (k, 3) of the largest polygon of a geometry with z coordinates.

    The first corner is not repeated. The result is empty for a geometry without such a polygon.
    """
    import shapely

    if shape is None or not shapely.has_z(shape):
        return np.zeros((0, 3))
    polygons = [part for part in shapely.get_parts(shape) if part.geom_type == "Polygon"]
    if not polygons:
        return np.zeros((0, 3))
    rings = [shapely.get_coordinates(polygon.exterior, include_z=True)[:-1] for polygon in polygons]
    return np.asarray(max(rings, key=_ring_area))


def _ring_area(ring: FloatArray) -> float:
    centred_ring = ring - ring.mean(axis=0)
    return float(
        np.linalg.norm(np.cross(centred_ring, np.roll(centred_ring, -1, axis=0)).sum(axis=0))
    )


def table_with_sets(
    table: OrientationTable,
    rows: Sequence[int],
    sets: Sequence[str],
    probability: Sequence[float],
    notes: Sequence[str] = (),
    discontinuity: Sequence[str] = (),
) -> str:
    """Return a table as text, with the set and its probability appended to each row.

    Existing columns with these names are renamed to `NAME_before`.

    Parameters
    ----------
    table : OrientationTable
    rows : (k,) sequence of int
        Rows that belong to a set.
    sets, probability : (k,) sequence
    notes : sequence of str
        Additional comments.
    discontinuity : (k,) sequence of str
        Discontinuities for an additional column; if empty, the column is omitted.
    """
    text_table = table.table
    delimiter = "," if text_table.delimiter == " " else text_table.delimiter
    out = io.StringIO()
    for line in (*text_table.comments, *notes):
        out.write(comment_line(line))
    writer = csv.writer(out, delimiter=delimiter, lineterminator="\n")
    names = text_table.names or _default_names(table)
    new_columns = [SET, PROBABILITY, *([DISCONTINUITY] if discontinuity else [])]
    new_names = {normalise_name(name) for name in new_columns}
    header = [f"{name}_before" if normalise_name(name) in new_names else name for name in names]
    writer.writerow([*map(escape_foreign_cell, header), *new_columns])
    cells = [[""] * len(new_columns) for _ in range(len(text_table))]
    has_commas = _has_decimal_commas(text_table.delimiter, text_table.rows)
    for k, (row, name, row_probability) in enumerate(zip(rows, sets, probability, strict=True)):
        probability_text = f"{row_probability:.6g}"
        cells[int(table.row_indices[row])] = [
            escape_formula(name),
            probability_text.replace(".", ",") if has_commas else probability_text,
            *([escape_formula(discontinuity[k])] if discontinuity else []),
        ]
    for row_cells, set_cells in zip(text_table.rows, cells, strict=True):
        writer.writerow([*map(escape_foreign_cell, row_cells), *set_cells])
    return out.getvalue()


def _default_names(table: OrientationTable) -> list[str]:
    """Return column names for a table that has no header.

    The first two columns are a dip direction or strike, and a dip.
    """
    first_column = table.table.numbers([0])[table.row_indices, 0]
    difference_deg = np.abs((first_column - table.dip_direction_deg + 180.0) % 360.0 - 180.0)
    name = "dip_direction_deg" if np.nanmedian(difference_deg) < 1.0 else "strike_rhr_deg"
    return [name, "dip_deg", *(f"column_{i + 1}" for i in range(2, table.table.width))]


def _has_decimal_commas(delimiter: str, rows: Sequence[Sequence[str]]) -> bool:
    """Return whether a table has decimal commas; decimal marks are not mixed within a table."""
    if delimiter not in ";\t":
        return False
    return any(
        "," in cell and cell.replace(",", "", 1).lstrip("-").isdigit()
        for row in rows[:50]
        for cell in row
    )
