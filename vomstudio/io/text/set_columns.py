"""Places of planes for their sets, and the table of planes with the sets behind."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from vomstudio.errors import InputError
from vomstudio.io.text.orientation_reading import OrientationTable
from vomstudio.io.text.tables import coordinate_columns, plain

SET, PROBABILITY = "set", "set_probability"


def places_of(table: OrientationTable) -> npt.NDArray[np.float64] | None:
    """(n, 3) x, y, z of the rows, NaN where they are empty; None where the table has no such
    columns."""
    if table.table.names is None:
        return None
    try:
        found = table.table.numbers(coordinate_columns(table.table))
    except InputError:
        return None
    return np.asarray(found[table.kept])


def table_with_sets(
    table: OrientationTable,
    rows: Sequence[int],
    sets: Sequence[str],
    probability: Sequence[float],
    notes: Sequence[str] = (),
) -> str:
    """The table as it was read, as text, with the set and its probability behind; rows : (k,) of
    `table` that have them. Columns that had these names are called `..._before`. notes : lines more
    for the head."""
    text = table.table
    delimiter = "," if text.delimiter == " " else text.delimiter
    out = io.StringIO()
    for line in (*text.comments, *notes):
        out.write(f"# {line}\n")
    writer = csv.writer(out, delimiter=delimiter, lineterminator="\n")
    names = text.names or _names_of(table)
    taken = {plain(SET), plain(PROBABILITY)}
    writer.writerow(
        [f"{name}_before" if plain(name) in taken else name for name in names] + [SET, PROBABILITY]
    )
    cells = [["", ""] for _ in range(len(text))]
    for row, name, share in zip(rows, sets, probability, strict=True):
        number = f"{share:.6g}"
        cells[int(table.kept[row])] = [
            name,
            number.replace(".", ",") if _has_decimal_commas(text.delimiter, text.rows) else number,
        ]
    for own, more in zip(text.rows, cells, strict=True):
        writer.writerow([*own, *more])
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
    return any("," in cell and cell.replace(",", "", 1).lstrip("-").isdigit()
               for row in rows[:50] for cell in row)  # fmt: skip
