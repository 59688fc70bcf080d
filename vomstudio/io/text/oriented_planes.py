"""Planes of an orientation table with positions and errors, for comparisons."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.geology.model_agreement import OrientedPlane
from vomstudio.io.text.orientation_reading import OrientationTable


def extract_planes(table: OrientationTable) -> list[OrientedPlane]:
    """Extract the planes of a table.

    Optional columns are name, x, y, z, extent_m, and total95_deg or else max_confidence95_deg.

    Raises
    ------
    InputError
        If the table has no planes.
    """
    if not table.is_plane.any():
        raise InputError(Finding("orientation.no-planes"), file=table.path)
    names = _words(table, "name") or list(table.ids)
    positions = np.column_stack([_numbers(table, axis) for axis in "xyz"])
    extent = _numbers(table, "extent_m")
    error = _numbers(table, "total95_deg")
    error = np.where(np.isfinite(error), error, _numbers(table, "max_confidence95_deg"))
    kinds = table.kinds or ("",) * len(table)
    normals = table.vectors()
    return [
        OrientedPlane(
            names[row] or table.ids[row],
            kinds[row],
            normals[row],
            positions[row] if np.isfinite(positions[row]).all() else None,
            float(extent[row]) if np.isfinite(extent[row]) else None,
            float(error[row]) if np.isfinite(error[row]) else None,
        )
        for row in np.flatnonzero(table.is_plane).tolist()
    ]


def _has_column(table: OrientationTable, column: str) -> bool:
    return column in (table.table.names or ())


def _words(table: OrientationTable, column: str) -> list[str]:
    return table.column(column) if _has_column(table, column) else []


def _numbers(table: OrientationTable, column: str) -> FloatArray:
    """Return a column (n,), NaN if it is missing."""
    if not _has_column(table, column):
        return np.full(len(table), np.nan)
    values = table.table.numbers([table.table.find(column)])
    return np.asarray(values[table.row_indices, 0], np.float64)
