"""Neighbouring sets that no gap parts: pieces of one girdle, as the poles of a bent bed make."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.geology.statistics import orientation_tensor

LEVEL = 0.05
LEAST_BETWEEN = 12
"""Poles between two means; of fewer an even spread and two clusters look alike."""
LONGER = 3.0
"""Along the great circle the two sets spread by so many times as much as across it."""


def without_gap(
    poles: FloatArray, group: npt.ArrayLike, means: FloatArray
) -> Sequence[tuple[int, int]]:
    """Pairs of sets between whose means (k, 3) the poles (n, 3), with groups (n,), -1 for none,
    lie as densely as about them. In an even spread along the great circle through both means each
    third of the way holds as many; two clusters leave the middle third emptier, and the chance of
    so few in an even spread is then below 5 % (binomial)."""
    from scipy.stats import binom

    of = np.asarray(group, np.int64)
    found = []
    for i in range(len(means)):
        for j in range(i + 1, len(means)):
            first, second = means[i], means[j]
            if first @ second < 0:
                second = -second
            way = math.acos(min(1.0, float(first @ second)))
            own = poles[(of == i) | (of == j)]
            values, _ = orientation_tensor(own)
            if values[1] < LONGER**2 * values[2]:
                continue
            along = second - (first @ second) * first
            along /= np.linalg.norm(along)
            at = np.arctan2(own @ along, own @ first)
            at = (at + math.pi / 2.0) % math.pi - math.pi / 2.0
            third = np.floor(at / way * 3.0)
            between = (third >= 0) & (third <= 2)
            n, middle = int(between.sum()), int(np.sum(third == 1))
            if n >= LEAST_BETWEEN and binom.cdf(middle, n, 1.0 / 3.0) >= LEVEL:
                found.append((i, j))
    return found
