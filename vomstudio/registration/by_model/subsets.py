"""How well a fit of a model to a reference is known, from repeated subsets of it.

ICP's own covariance takes every point as independent and is far too small: the errors of
neighbours are alike. So the overlap is cut into blocks, and the fits without one of them after the
other show how much they disagree (the jackknife over blocks, here to first order in closed form),
with the degrees of freedom that so many unequal blocks leave (Bell & McCaffrey 2002, Survey
Methodology 28, 169). Blocks must be larger than the distance over which errors are alike: they grow
until neighbours are no more alike than chance makes them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.registration.by_model.refining import Refined

_BLOCKS = (100, 50, 25)
"""So many are wanted, as long as they do not prove to be too small."""
_RADII = 4.0
"""Places within two radii share points: blocks are larger than that."""
_ALIKE = 2.33
"""Standard deviations: by chance one in a hundred."""
_LEAST_FREE = 3.0
_EXACT = 1e-7
"""Of the size, and rad: no fit is known better, even of a model to its own copy."""


@dataclass(frozen=True, eq=False)
class Spread:
    """whitening : (d, 7) see `combined.Combined`, with Student's widening in it
    blocks : how many; side_m : of a block; alike : neighbouring blocks miss alike even so
    """

    whitening: FloatArray
    blocks: int
    side_m: float
    alike: bool


def spread_of(found: Refined, radius: float) -> Spread:
    """The errors of what a fit has determined. radius : within which places have their points"""
    side = float(np.ptp(found.places, axis=0).max())
    named, alike = np.zeros(len(found.places), np.int64), True
    for wanted in _BLOCKS:
        named, side = cut_into_blocks(found.places, wanted, _RADII * radius)
        alike = _neighbours_alike(found, named)
        if not alike:
            break
    count = int(named.max()) + 1
    covariance = _covariance(found, named)
    # Functionals of the seven numbers: what is not determined has no part in them.
    units = np.array([1.0, 1.0, 1.0, 1.0, found.size, found.size, found.size])
    told = found.held.T @ found.information
    root = np.linalg.cholesky(covariance + _EXACT**2 * told @ told.T)
    return Spread(np.linalg.solve(root, told / units), count, side, alike)


def cut_into_blocks(places: FloatArray, wanted: int, least: float) -> tuple[IntArray, float]:
    """(k,) the block of each place, from 0 on; and the side of these cubes, at least `least` as
    long as there are enough of them."""
    low = places.min(axis=0)
    side = float(np.ptp(places, axis=0).max())
    named = np.zeros(len(places), np.int64)
    for _ in range(60):
        cells = np.floor((places - low) / max(side, 1e-12)).astype(np.int64)
        wide = cells.max(axis=0) + 1
        keys = cells[:, 0] + wide[0] * (cells[:, 1] + wide[1] * cells[:, 2])
        named = np.unique(keys, return_inverse=True)[1]
        count = int(named.max()) + 1
        if count >= min(wanted, len(places)) or (count >= _BLOCKS[-1] and 0.9 * side < least):
            break
        side *= 0.9
    return np.asarray(named, np.int64), side


def _neighbours_alike(found: Refined, named: IntArray) -> bool:
    """Whether the mean misses of neighbouring blocks are alike (Moran's I; Cliff & Ord 1981)."""
    from scipy.spatial import cKDTree

    count = np.bincount(named)
    size = len(count)
    if size < 10:
        return False
    middle = np.column_stack(
        [np.bincount(named, found.places[:, axis]) / count for axis in range(3)]
    )
    mean = np.bincount(named, found.pull) / np.sqrt(count)
    mean = mean - mean.mean()
    near = cKDTree(middle).query(middle, k=min(5, size))[1][:, 1:]
    weights = np.zeros((size, size))
    weights[np.repeat(np.arange(size), near.shape[1]), near.ravel()] = 1.0
    weights = (weights + weights.T) / 2
    total = weights.sum()
    index = size / total * float(mean @ weights @ mean) / max(float(mean @ mean), 1e-300)
    s1 = 2.0 * float((weights**2).sum())
    s2 = 4.0 * float((weights.sum(axis=1) ** 2).sum())
    variance = (size**2 * s1 - size * s2 + 3 * total**2) / ((size**2 - 1) * total**2)
    variance -= 1.0 / (size - 1) ** 2
    return bool(index + 1.0 / (size - 1) > _ALIKE * np.sqrt(max(variance, 0.0)))


def _covariance(found: Refined, named: IntArray) -> FloatArray:
    """(d, d) of the determined directions, each known to its Student's t."""
    from scipy.stats import norm, t

    moves = found.moves @ found.held
    d = moves.shape[1]
    blocks = int(named.max()) + 1
    order = np.argsort(named, kind="stable")
    begins = np.searchsorted(named[order], np.arange(blocks))
    each = (moves * found.slope[:, None])[order]
    inside = np.add.reduceat(each[:, :, None] * moves[order][:, None, :], begins, axis=0)
    pulls = np.add.reduceat((moves * found.pull[:, None])[order], begins, axis=0)
    # The information of all is 1 in these directions, and less by its own without a block.
    adjusted, turns = np.zeros((blocks, d)), np.zeros((blocks, d, d))
    for block in range(blocks):
        values, axes = np.linalg.eigh((inside[block] + inside[block].T) / 2)
        turns[block] = (axes / np.clip(1.0 - values, 1e-2, None)) @ axes.T
        adjusted[block] = turns[block] @ pulls[block]
    real = np.linalg.inv(found.response)
    covariance = real @ (adjusted.T @ adjusted) @ real.T
    factor = np.ones(d)
    for k in range(d):
        left = turns[:, k, :]
        own = np.einsum("bi,bij,bj->b", left, inside, left)
        across = np.einsum("bi,bij->bj", left, inside)
        scatter = np.diag(own) - across @ across.T
        free = float(np.trace(scatter)) ** 2 / max(float((scatter**2).sum()), 1e-300)
        factor[k] = t.ppf(0.975, max(free, _LEAST_FREE)) / norm.ppf(0.975)
    return np.asarray(covariance * np.outer(factor, factor), np.float64)
