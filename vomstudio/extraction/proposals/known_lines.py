"""Comparison of proposed and known lines, and way-points to follow a line again."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray

# Minimum share of a line that runs beside known lines for it to be the same contact.
_MIN_MATCHING_SHARE = 0.5


def match_known_lines(
    lines: Sequence[FloatArray], known_lines: Sequence[FloatArray], max_distance: float
) -> list[bool]:
    """Return which lines run along known lines.

    Parameters
    ----------
    lines, known_lines : sequences of (n, 3) arrays
    max_distance : float
        Maximum distance in the unit of the lines.

    Returns
    -------
    list of bool
        Whether at least half of each line is within `max_distance` of the known lines combined.
    """
    from scipy.spatial import cKDTree

    dense_lines = [_densify_line(line, max_distance) for line in known_lines if len(line)]
    if not dense_lines:
        return [False] * len(lines)
    tree = cKDTree(np.concatenate(dense_lines))
    return [
        bool(
            (
                tree.query(_densify_line(line, max_distance), distance_upper_bound=max_distance)[0]
                <= max_distance
            ).mean()
            >= _MIN_MATCHING_SHARE
        )
        for line in lines
    ]


def simplify_line(line: FloatArray, max_distance: float, max_points: int) -> IntArray:
    """Select vertices to simplify a line (Douglas & Peucker 1973, Cartographica 10, 112).

    Parameters
    ----------
    line : (n, 3) array
    max_distance : float
        Maximum distance of a vertex from the simplified line.
    max_points : int
        Maximum number of vertices.

    Returns
    -------
    (k,) int array
        Rows of the selected vertices, including both ends.
    """
    rows = [0, len(line) - 1]
    while len(rows) < max_points:
        deviations = [
            _find_farthest_vertex(line, start_row, end_row) for start_row, end_row in pairwise(rows)
        ]
        max_deviation, row = max(deviations, default=(0.0, 0))
        if max_deviation <= max_distance:
            break
        rows = sorted({*rows, row})
    return np.array(sorted(set(rows)), np.int64)


def _find_farthest_vertex(line: FloatArray, first_row: int, last_row: int) -> tuple[float, int]:
    """Return the distance and row of the vertex farthest from the chord between two vertices."""
    if last_row - first_row < 2:
        return 0.0, first_row
    start, step = line[first_row], line[last_row] - line[first_row]
    inner_vertices = line[first_row + 1 : last_row] - start
    projections = np.clip(inner_vertices @ step / max(float(step @ step), 1e-300), 0.0, 1.0)
    distance = np.linalg.norm(inner_vertices - projections[:, None] * step, axis=1)
    row = int(distance.argmax())
    return float(distance[row]), first_row + 1 + row


def _densify_line(line: FloatArray, max_distance: float) -> FloatArray:
    """Resample a line in equal steps of at most half of `max_distance`, within limits."""
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    arc_lengths = np.concatenate([[0.0], np.cumsum(steps)])
    count = int(np.clip(np.ceil(2.0 * arc_lengths[-1] / max_distance), 1, 100_000)) + 1
    position = np.linspace(0.0, arc_lengths[-1], count)
    return np.column_stack([np.interp(position, arc_lengths, axis) for axis in line.T])
