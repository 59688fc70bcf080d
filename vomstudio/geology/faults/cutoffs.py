"""Cutoffs of a bed at a fault, in the hanging wall and in the footwall."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Plane


@dataclass(frozen=True, eq=False)
class Cutoffs:
    """Cutoffs of a bed at a fault.

    Attributes
    ----------
    hanging_wall, footwall : (3,) ndarray
        Point of each trace that is nearest to the fault, in the World frame, m.
    is_swapped : bool
        True if the second trace is in the hanging wall.
    """

    hanging_wall: FloatArray
    footwall: FloatArray
    is_swapped: bool


def find_cutoffs(
    first_trace: npt.ArrayLike,
    second_trace: npt.ArrayLike,
    fault: Plane,
    fault_point: npt.ArrayLike,
) -> Cutoffs:
    """Find the cutoffs of two traces of one bed at a fault.

    The hanging wall is on the side of the upward normal of the fault; for a vertical fault, it is
    on the side toward which the dip direction points.

    Parameters
    ----------
    first_trace, second_trace : (n, 3) array_like
        Traces in the World frame, m.
    fault : Plane
    fault_point : (3,) array_like
        Point on the fault in the World frame, m.

    Returns
    -------
    Cutoffs

    Raises
    ------
    GeometryError
        If both traces are on the same side of the fault.
    """
    normal, centre = fault.normal(), np.asarray(fault_point, np.float64)
    traces = [np.atleast_2d(np.asarray(trace, np.float64)) for trace in (first_trace, second_trace)]
    heights = [(trace - centre) @ normal for trace in traces]
    first_height, second_height = (float(h.mean()) for h in heights)
    if (first_height > 0) == (second_height > 0):
        raise GeometryError(Finding("displacement.one-side"))
    points = [
        trace[int(np.argmin(np.abs(height)))] for trace, height in zip(traces, heights, strict=True)
    ]
    is_swapped = second_height > 0
    hanging_wall_point, footwall_point = points[::-1] if is_swapped else points
    return Cutoffs(hanging_wall_point, footwall_point, is_swapped)
