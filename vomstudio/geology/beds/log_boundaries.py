"""Boundaries of a log where the traces of beds cross its line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry.lines import nearest_approach


@dataclass(frozen=True, eq=False)
class Crossing:
    """name : of the trace; place (3,) on it, where it comes nearest to the line; distance_m between
    them there; along_m : the way along the line up to there"""

    name: str
    place: FloatArray
    distance_m: float
    along_m: float


def crossings(
    line: npt.ArrayLike, traces: Mapping[str, npt.ArrayLike], reach_m: float
) -> list[Crossing]:
    """line (n, 3) and traces (m, 3) World, metres; in the order along the line, those that come
    within reach_m of it. A trace that crosses the line more than once counts where it comes
    nearest."""
    walked = np.asarray(line, np.float64)
    low, high = walked.min(axis=0) - reach_m, walked.max(axis=0) + reach_m
    found = []
    for name, points in traces.items():
        trace = np.asarray(points, np.float64)
        if len(trace) < 2 or (trace.max(axis=0) < low).any() or (trace.min(axis=0) > high).any():
            continue
        near = nearest_approach(walked, trace)
        if near.distance <= reach_m:
            found.append(Crossing(name, near.place, near.distance, near.along))
    return sorted(found, key=lambda crossing: crossing.along_m)
