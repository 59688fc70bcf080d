"""The attitude of parallel beds by their traces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from vomstudio.geology.beds.parallel import parallel_beds
from vomstudio.geology.orientation import Plane


def bed_of(traces: Sequence[npt.ArrayLike]) -> tuple[Plane, float | None]:
    """The attitude of parallel beds by their traces (n, 3), with the half-angle of its 95 % cone in
    the worst direction, degrees. Raises GeometryError where they determine none."""
    arrays = [np.atleast_2d(np.asarray(trace, np.float64)) for trace in traces]
    offsets = np.concatenate([[0], np.cumsum([len(a) for a in arrays])])
    names = [str(i) for i in range(len(arrays))]
    found = parallel_beds(names, np.concatenate(arrays), offsets)
    return Plane(found.dip_direction_deg, found.dip_deg), found.max_confidence95_deg
