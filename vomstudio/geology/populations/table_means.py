"""The mean plane of a table, or of one set in it."""

from __future__ import annotations

import numpy as np

from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Plane
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.statistics import axial_mean


def mean_plane(table: OrientationRows, set_name: str | None = None) -> Plane:
    """Of the poles of the table's planes, by the orientation tensor.

    Raises UsageError for a set that is not in the table, GeometryError where there are no planes,
    or they have no mean.
    """
    chosen = np.asarray(table.is_plane, bool)
    if set_name is not None:
        sets = table.sets or ()
        known = sorted({name for name in sets if name})
        if set_name not in known:
            raise UsageError(
                Finding("sets.unknown", set=set_name, sets=known or None),
                file=table.path,
                field="--set",
            )
        chosen = chosen & (np.array(sets) == set_name)
    if not chosen.any():
        raise GeometryError(Finding("orientation.no-planes"), file=table.path)
    return Plane.from_normal(axial_mean(table.vectors()[chosen]).vector())
