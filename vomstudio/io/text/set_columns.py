"""Places of planes for their sets, and the table of planes with the sets behind."""

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
from vomstudio.io.text.column_names import plain
from vomstudio.io.text.orientation_reading import OrientationTable
from vomstudio.io.text.wkt_columns import shapes_of

SET, PROBABILITY, DISCONTINUITY = "set", "set_probability", "discontinuity"
_WKT = "wkt"


def pieces_of(table: OrientationTable, places: FloatArray | None) -> Pieces | None:
    """Return position, extent and border of each plane of a table.

    Read are area_m2, rms_m with lambda1 to lambda3, and a border `wkt`.

    Parameters
    ----------
    table : OrientationTable
    places : (n, 3) float or None
        World coordinates of the rows (`vomstudio.io.gate.point_tables.read_places`).

    Returns
    -------
    Pieces or None
        None without places.

    Raises
    ------
    InputError
        For a border that is not WKT.
    """
    if places is None:
        return None
    n = len(places)

    def numbers(*names: str) -> FloatArray:
        if not all(table.table.has(name) for name in names):
            return np.full((n, len(names)), np.nan)
        columns = [table.table.find(name) for name in names]
        return np.asarray(table.table.numbers(columns)[table.kept])

    rms, l1, l2, l3 = numbers("rms_m", "lambda1", "lambda2", "lambda3").T
    with np.errstate(divide="ignore", invalid="ignore"):
        across = rms**2
        along = across * (l1 + l2) / (2.0 * l3)
    poles = table.vectors()
    own = poles[:, :, None] * poles[:, None, :]
    scatters = (across - along)[:, None, None] * own + along[:, None, None] * np.eye(3)
    return Pieces(places, scatters, numbers("area_m2")[:, 0], _rings(table, n))


def _rings(table: OrientationTable, n: int) -> tuple[FloatArray, ...]:
    if not table.table.has(_WKT):
        return tuple(np.zeros((0, 3)) for _ in range(n))
    import shapely

    cells = table.table.cells(table.table.find(_WKT))
    try:
        return rings_of([cells[i].strip() or None for i in table.kept.tolist()])
    except shapely.errors.GEOSException as error:
        raise InputError(Finding("table.invalid-wkt"), file=table.path, field=_WKT) from error


def rings_of(texts: Sequence[str | None]) -> tuple[FloatArray, ...]:
    """(k, 3) corners of each border in WKT, none where there is no text. Raises shapely's
    GEOSException for what is no geometry."""
    return tuple(_outer_ring(shape) for shape in shapes_of(texts))


def _outer_ring(shape: Any) -> FloatArray:
    """(k, 3) corners of the largest polygon of a geometry in space, in order, the first not
    repeated; none where there is none or it has no third coordinate."""
    import shapely

    if shape is None or not shapely.has_z(shape):
        return np.zeros((0, 3))
    polygons = [part for part in shapely.get_parts(shape) if part.geom_type == "Polygon"]
    if not polygons:
        return np.zeros((0, 3))
    rings = [shapely.get_coordinates(p.exterior, include_z=True)[:-1] for p in polygons]
    return np.asarray(max(rings, key=_area_of_ring))


def _area_of_ring(ring: FloatArray) -> float:
    own = ring - ring.mean(axis=0)
    return float(np.linalg.norm(np.cross(own, np.roll(own, -1, axis=0)).sum(axis=0)))


def table_with_sets(
    table: OrientationTable,
    rows: Sequence[int],
    sets: Sequence[str],
    probability: Sequence[float],
    notes: Sequence[str] = (),
    discontinuity: Sequence[str] = (),
) -> str:
    """The table as it was read, as text, with the set and its probability behind; rows : (k,) of
    `table` that have them. Columns that had these names are called `..._before`. notes : lines more
    for the head. discontinuity : (k,) of each, for one more column; none for none."""
    text = table.table
    delimiter = "," if text.delimiter == " " else text.delimiter
    out = io.StringIO()
    for line in (*text.comments, *notes):
        out.write(comment_line(line))
    writer = csv.writer(out, delimiter=delimiter, lineterminator="\n")
    names = text.names or _names_of(table)
    new = [SET, PROBABILITY, *([DISCONTINUITY] if discontinuity else [])]
    taken = {plain(name) for name in new}
    heads = [f"{name}_before" if plain(name) in taken else name for name in names]
    writer.writerow([*map(escape_foreign_cell, heads), *new])
    cells = [[""] * len(new) for _ in range(len(text))]
    commas = _has_decimal_commas(text.delimiter, text.rows)
    for k, (row, name, share) in enumerate(zip(rows, sets, probability, strict=True)):
        number = f"{share:.6g}"
        cells[int(table.kept[row])] = [
            escape_formula(name),
            number.replace(".", ",") if commas else number,
            *([escape_formula(discontinuity[k])] if discontinuity else []),
        ]
    for own, more in zip(text.rows, cells, strict=True):
        writer.writerow([*map(escape_foreign_cell, own), *more])
    return out.getvalue()


def _names_of(table: OrientationTable) -> list[str]:
    """Heads for a table without: its first two columns are a dip direction or strike, and a dip."""
    first = table.table.numbers([0])[table.kept, 0]
    off = np.abs((first - table.dip_direction_deg + 180.0) % 360.0 - 180.0)
    name = "dip_direction_deg" if np.nanmedian(off) < 1.0 else "strike_rhr_deg"
    return [name, "dip_deg", *(f"column_{i + 1}" for i in range(2, table.table.width))]


def _has_decimal_commas(delimiter: str, rows: Sequence[Sequence[str]]) -> bool:
    """Points and commas are not mixed in one table."""
    if delimiter not in ";\t":
        return False
    return any(
        "," in cell and cell.replace(",", "", 1).lstrip("-").isdigit()
        for row in rows[:50]
        for cell in row
    )
