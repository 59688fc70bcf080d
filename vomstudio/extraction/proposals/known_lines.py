"""Which proposed lines run along lines that are known already, and by which way-points a line can
be followed again."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray

# More than half of a line beside a known one shows the same.
_SAME_SHARE = 0.5


def run_along(lines: Sequence[FloatArray], known: Sequence[FloatArray], reach: float) -> list[bool]:
    """Whether at least half of each of the lines (n, 3) lies within reach of the known ones (m, 3)
    together."""
    from scipy.spatial import cKDTree

    dense = [_dense(line, reach) for line in known if len(line)]
    if not dense:
        return [False] * len(lines)
    tree = cKDTree(np.concatenate(dense))
    return [
        bool(
            (tree.query(_dense(line, reach), distance_upper_bound=reach)[0] <= reach).mean()
            >= _SAME_SHARE
        )
        for line in lines
    ]


def way_points(line: FloatArray, reach: float, most: int) -> IntArray:
    """Rows of the vertices of a line (n, 3) that are kept of it, its ends among them: those by
    which straight pieces are off by at most reach, or `most`, after Douglas and Peucker (1973),
    Cartographica 10, 112."""
    kept = [0, len(line) - 1]
    while len(kept) < most:
        found = [_farthest(line, one, other) for one, other in pairwise(kept)]
        off, row = max(found, default=(0.0, 0))
        if off <= reach:
            break
        kept = sorted({*kept, row})
    return np.array(sorted(set(kept)), np.int64)


def _farthest(line: FloatArray, one: int, other: int) -> tuple[float, int]:
    """How far the farthest vertex between two lies from the straight piece, and its row."""
    if other - one < 2:
        return 0.0, one
    start, step = line[one], line[other] - line[one]
    inner = line[one + 1 : other] - start
    along = np.clip(inner @ step / max(float(step @ step), 1e-300), 0.0, 1.0)
    off = np.linalg.norm(inner - along[:, None] * step, axis=1)
    row = int(off.argmax())
    return float(off[row]), one + 1 + row


def _dense(line: FloatArray, reach: float) -> FloatArray:
    """With points between the vertices, at most half of reach apart, and their number not without
    bounds."""
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    far = np.concatenate([[0.0], np.cumsum(steps)])
    count = int(np.clip(np.ceil(2.0 * far[-1] / reach), 1, 100_000)) + 1
    at = np.linspace(0.0, far[-1], count)
    return np.column_stack([np.interp(at, far, axis) for axis in line.T])
