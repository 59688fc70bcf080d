"""Text tables of pixel positions in a photo."""

from __future__ import annotations

from pathlib import Path

from vomstudio.core.arrays import FloatArray
from vomstudio.io.text.named_columns import NamedTable
from vomstudio.io.text.tables import read_table

COLUMN_NAMES = ("column", "col", "pixel x", "u")
ROW_NAMES = ("row", "pixel y", "v")


def read_pixels(path: str | Path) -> FloatArray | None:
    """Read pixel positions.

    Returns
    -------
    (n, 2) float64 or None
        Column and row. None unless the table has these columns and no z, or has two columns and no
        header.

    Raises
    ------
    InputError
        If the table is not valid; states line and column.
    """
    table = read_table(path, has_header=True)
    if table.names is None:
        if table.width != 2:
            return None
    elif table.has("z") or not any(table.has(name) for name in COLUMN_NAMES):
        return None
    return NamedTable(path, ("column", "row")).columns((COLUMN_NAMES, ROW_NAMES), ("column", "row"))
