"""Cut-offs of a bed on both sides of a fault: which is on the hanging wall, and where they end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Plane


@dataclass(frozen=True, eq=False)
class CutOffs:
    """hanging_wall, footwall : (3,) World, the points of both traces next to the fault; swapped :
    the second trace is the one on the hanging wall"""

    hanging_wall: FloatArray
    footwall: FloatArray
    swapped: bool


def cut_offs(
    one: npt.ArrayLike, other: npt.ArrayLike, fault: Plane, through: npt.ArrayLike
) -> CutOffs:
    """Of traces (n, 3) of one bed. through : (3,) a point on the fault. The hanging wall is on the
    side of the fault's upward normal; of a vertical fault that is the side toward which its dip
    direction points. Raises GeometryError where both traces are on one side."""
    normal, centre = fault.normal(), np.asarray(through, np.float64)
    traces = [np.atleast_2d(np.asarray(t, np.float64)) for t in (one, other)]
    heights = [(trace - centre) @ normal for trace in traces]
    first, second = (float(h.mean()) for h in heights)
    if (first > 0) == (second > 0):
        raise GeometryError(Finding("displacement.one-side"))
    points = [
        trace[int(np.argmin(np.abs(height)))] for trace, height in zip(traces, heights, strict=True)
    ]
    swapped = second > 0
    hanging, foot = points[::-1] if swapped else points
    return CutOffs(hanging, foot, swapped)
