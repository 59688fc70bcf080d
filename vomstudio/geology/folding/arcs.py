"""Poles along a great circle: the arc that holds them, its ends, and the same poles on one side."""

from __future__ import annotations

import math

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geology.statistics import flip_to


def rms(values: FloatArray) -> float:
    return math.sqrt(float(np.mean(np.asarray(values) ** 2)))


def arc_deg(poles: FloatArray, axes: FloatArray) -> float:
    """Shortest arc of the great circle that holds all poles: half a turn less the widest gap
    between neighbours, axially."""
    along = _along_deg(poles, axes)
    gaps = np.diff(np.append(along, along[0] + 180.0))
    return float(180.0 - gaps.max())


def arc_ends(poles: FloatArray, axes: FloatArray) -> tuple[int, int]:
    """The places of the poles at both ends of the arc that holds all."""
    angle = np.degrees(np.arctan2(poles @ axes[1], poles @ axes[0])) % 180.0
    order = np.argsort(angle)
    along = angle[order]
    first = int(np.argmax(np.diff(np.append(along, along[0] + 180.0))))
    return int(order[first]), int(order[(first + 1) % len(order)])


def _along_deg(poles: FloatArray, axes: FloatArray) -> FloatArray:
    """Angles along the great circle, sorted, from 0 to 180."""
    return np.sort(np.degrees(np.arctan2(poles @ axes[1], poles @ axes[0])) % 180.0)


def one_sided(poles: FloatArray, axes: FloatArray) -> FloatArray:
    """The poles, each by that end which lies in the arc that holds all of them."""
    angle = np.degrees(np.arctan2(poles @ axes[1], poles @ axes[0])) % 180.0
    along = np.sort(angle)
    gaps = np.diff(np.append(along, along[0] + 180.0))
    first = int(np.argmax(gaps))
    middle = along[first] + gaps[first] + (180.0 - gaps[first]) / 2.0
    turn = math.radians(middle)
    return flip_to(poles, math.cos(turn) * axes[0] + math.sin(turn) * axes[1])
