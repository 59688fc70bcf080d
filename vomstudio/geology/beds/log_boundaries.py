"""Boundaries of a log at which traces of beds cross its line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry.lines import nearest_approach


@dataclass(frozen=True, eq=False)
class Crossing:
    """Crossing of a trace with the line of a log.

    Attributes
    ----------
    name : str
        Name of the trace.
    position : (3,) ndarray
        Point of the trace that is nearest to the line, in the World frame, m.
    distance_m : float
        Distance between this point and the line, m.
    position_m : float
        Distance along the line, m.
    """

    name: str
    position: FloatArray
    distance_m: float
    position_m: float


def crossings(
    line: npt.ArrayLike, traces: Mapping[str, npt.ArrayLike], max_distance_m: float
) -> list[Crossing]:
    """Find the crossings of traces with the line of a log, in order along the line.

    Parameters
    ----------
    line : (n, 3) array_like
        Vertices of the line in the World frame, m.
    traces : mapping of str to (m, 3) array_like
        Points of each trace by name, in the World frame, m.
    max_distance_m : float
        Maximum distance between a trace and the line, m.

    Returns
    -------
    list of Crossing
        The closest approach of each trace that is within `max_distance_m`.
    """
    vertices = np.asarray(line, np.float64)
    low, high = vertices.min(axis=0) - max_distance_m, vertices.max(axis=0) + max_distance_m
    trace_crossings = []
    for name, points in traces.items():
        trace = np.asarray(points, np.float64)
        if len(trace) < 2 or (trace.max(axis=0) < low).any() or (trace.min(axis=0) > high).any():
            continue
        nearest = nearest_approach(vertices, trace)
        if nearest.distance <= max_distance_m:
            trace_crossings.append(
                Crossing(name, nearest.midpoint, nearest.distance, nearest.distance_along_line)
            )
    return sorted(trace_crossings, key=lambda crossing: crossing.position_m)
