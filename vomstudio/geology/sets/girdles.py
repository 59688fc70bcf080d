"""Neighbouring sets that are parts of one girdle, such as the poles of a folded bed."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.geology.statistics import orientation_tensor

SIGNIFICANCE = 0.05
MIN_POLES_BETWEEN = 12
"""Minimum number of poles between two means; fewer poles cannot distinguish a girdle from two
clusters.
"""
MIN_ELONGATION = 3.0
"""Minimum ratio of the spread of both sets along the great circle to the spread across it."""


def find_pairs_without_gap(
    poles: FloatArray, group: npt.ArrayLike, means: FloatArray
) -> Sequence[tuple[int, int]]:
    """Find pairs of sets that are not separated by a gap in the density of poles.

    For a uniform distribution along the great circle through both means, each third of the distance
    contains equal numbers of poles. Between two clusters the middle third contains fewer, with a
    binomial p-value below 5 % for a uniform distribution. Pairs with few poles between the means,
    or without a clear elongation along the circle, are not tested.

    Parameters
    ----------
    poles : (n, 3) ndarray
    group : (n,) array_like of int
        Set of each pole; -1 if it belongs to none.
    means : (k, 3) ndarray

    Returns
    -------
    list of (int, int)
    """
    from scipy.stats import binom

    groups = np.asarray(group, np.int64)
    pairs = []
    for i in range(len(means)):
        for j in range(i + 1, len(means)):
            first_mean, second_mean = means[i], means[j]
            if first_mean @ second_mean < 0:
                second_mean = -second_mean
            angle = math.acos(min(1.0, float(first_mean @ second_mean)))
            members = poles[(groups == i) | (groups == j)]
            eigenvalues, _ = orientation_tensor(members)
            if eigenvalues[1] < MIN_ELONGATION**2 * eigenvalues[2]:
                continue
            cross_axis = second_mean - (first_mean @ second_mean) * first_mean
            cross_axis /= np.linalg.norm(cross_axis)
            positions = np.arctan2(members @ cross_axis, members @ first_mean)
            positions = (positions + math.pi / 2.0) % math.pi - math.pi / 2.0
            thirds = np.floor(positions / angle * 3.0)
            is_between = (thirds >= 0) & (thirds <= 2)
            n, middle_count = int(is_between.sum()), int(np.sum(thirds == 1))
            if n >= MIN_POLES_BETWEEN and binom.cdf(middle_count, n, 1.0 / 3.0) >= SIGNIFICANCE:
                pairs.append((i, j))
    return pairs
