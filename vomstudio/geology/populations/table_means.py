"""Mean plane of a table, or of one of its sets."""

from __future__ import annotations

import numpy as np

from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Plane
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.statistics import axial_mean


def mean_plane(table: OrientationRows, set_name: str | None = None) -> Plane:
    """Compute the mean plane of a table from the orientation tensor of the poles.

    Raises
    ------
    UsageError
        If the table does not contain the set.
    GeometryError
        If the table or set contains no planes, or if they have no mean.
    """
    is_selected = np.asarray(table.is_plane, bool)
    if set_name is not None:
        sets = table.sets or ()
        known_sets = sorted({name for name in sets if name})
        if set_name not in known_sets:
            raise UsageError(
                Finding("sets.unknown", set=set_name, sets=known_sets or None),
                file=table.path,
                field="--set",
            )
        is_selected = is_selected & (np.array(sets) == set_name)
    if not is_selected.any():
        raise GeometryError(Finding("orientation.no-planes"), file=table.path)
    return Plane.from_normal(axial_mean(table.vectors()[is_selected]).vector())
