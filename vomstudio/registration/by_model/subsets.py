"""Error of the fit of a model to a reference, estimated by a block jackknife.

The covariance of ICP treats all points as independent and is far too small, because the errors of
neighbouring points are correlated. The overlap is cut into blocks, and the fits without each block
give the error (to first order, in closed form), with the degrees of freedom of unequal blocks (Bell
& McCaffrey 2002, Survey Methodology 28, 169). Blocks must exceed the correlation length, so their
size is increased until neighbouring blocks are uncorrelated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.registration.by_model.refining import Refinement

_BLOCK_COUNTS = (100, 50, 25)
"""Numbers of blocks to try, until blocks are large enough."""
_MIN_BLOCK_RADII = 4.0
"""Minimum block size in radii; positions within two radii share points."""
_MORAN_LIMIT_SIGMAS = 2.33
"""Limit of Moran's I in standard deviations (significance 1 %)."""
_MIN_FREEDOM = 3.0
_MIN_ERROR = 1e-7
"""Minimum error as a share of the size, or in rad, even for a copy of the model."""


@dataclass(frozen=True, eq=False)
class JackknifeError:
    """Error of a fit by the block jackknife.

    Attributes
    ----------
    whitening : (d, 7) array
        See `combined.Combined`; includes the widening by Student's t.
    blocks : int
    side_m : float
        Size of a block.
    is_alike : bool
        Whether neighbouring blocks are still correlated.
    """

    whitening: FloatArray
    blocks: int
    side_m: float
    is_alike: bool


def jackknife_error(refinement: Refinement, radius: float) -> JackknifeError:
    """Estimate the error of a fit by leaving out parts.

    Parameters
    ----------
    refinement : Refinement
    radius : float
        Radius within which the points of each position are averaged, metres.

    Returns
    -------
    JackknifeError
    """
    extent = float(np.ptp(refinement.places, axis=0).max())
    block_of_place, is_alike = np.zeros(len(refinement.places), np.int64), True
    for count_target in _BLOCK_COUNTS:
        block_of_place, extent = cut_into_blocks(
            refinement.places, count_target, _MIN_BLOCK_RADII * radius
        )
        is_alike = _are_neighbours_alike(refinement, block_of_place)
        if not is_alike:
            break
    count = int(block_of_place.max()) + 1
    covariance = _covariance(refinement, block_of_place)
    # Linear functions of the parameters that do not depend on the undetermined directions.
    units = np.array([1.0, 1.0, 1.0, 1.0, refinement.size, refinement.size, refinement.size])
    functionals = refinement.determined.T @ refinement.information
    root = np.linalg.cholesky(covariance + _MIN_ERROR**2 * functionals @ functionals.T)
    return JackknifeError(np.linalg.solve(root, functionals / units), count, extent, is_alike)


def cut_into_blocks(positions: FloatArray, target: int, min_side: float) -> tuple[IntArray, float]:
    """Assign positions (k, 3) to cubic blocks.

    Returns
    -------
    blocks : (k,) array of int
        Index of the block of each position, from 0.
    side : float
        Side length of a block, at least `min_side` if there are enough blocks.
    """
    low = positions.min(axis=0)
    extent = float(np.ptp(positions, axis=0).max())
    block_of_place = np.zeros(len(positions), np.int64)
    for _ in range(60):
        cells = np.floor((positions - low) / max(extent, 1e-12)).astype(np.int64)
        width = cells.max(axis=0) + 1
        keys = cells[:, 0] + width[0] * (cells[:, 1] + width[1] * cells[:, 2])
        block_of_place = np.unique(keys, return_inverse=True)[1]
        count = int(block_of_place.max()) + 1
        if count >= min(target, len(positions)) or (
            count >= _BLOCK_COUNTS[-1] and 0.9 * extent < min_side
        ):
            break
        extent *= 0.9
    return np.asarray(block_of_place, np.int64), extent


def _are_neighbours_alike(refinement: Refinement, block_of_place: IntArray) -> bool:
    """Return whether neighbouring blocks are correlated (Moran's I; Cliff & Ord 1981)."""
    from scipy.spatial import cKDTree

    count = np.bincount(block_of_place)
    size = len(count)
    if size < 10:
        return False
    centres = np.column_stack(
        [np.bincount(block_of_place, refinement.places[:, axis]) / count for axis in range(3)]
    )
    mean = np.bincount(block_of_place, refinement.pull) / np.sqrt(count)
    mean = mean - mean.mean()
    neighbours = cKDTree(centres).query(centres, k=min(5, size))[1][:, 1:]
    weights = np.zeros((size, size))
    weights[np.repeat(np.arange(size), neighbours.shape[1]), neighbours.ravel()] = 1.0
    weights = (weights + weights.T) / 2
    total_weight = weights.sum()
    index = size / total_weight * float(mean @ weights @ mean) / max(float(mean @ mean), 1e-300)
    s1 = 2.0 * float((weights**2).sum())
    s2 = 4.0 * float((weights.sum(axis=1) ** 2).sum())
    variance = (size**2 * s1 - size * s2 + 3 * total_weight**2) / ((size**2 - 1) * total_weight**2)
    variance -= 1.0 / (size - 1) ** 2
    return bool(index + 1.0 / (size - 1) > _MORAN_LIMIT_SIGMAS * np.sqrt(max(variance, 0.0)))


def _covariance(refinement: Refinement, block_of_place: IntArray) -> FloatArray:
    """Return the covariance (d, d) of the determined directions, widened by Student's t."""
    from scipy.stats import norm, t

    design = refinement.design @ refinement.determined
    d = design.shape[1]
    blocks = int(block_of_place.max()) + 1
    order = np.argsort(block_of_place, kind="stable")
    starts = np.searchsorted(block_of_place[order], np.arange(blocks))
    subset_moves = (design * refinement.slope[:, None])[order]
    subset_sums = np.add.reduceat(
        subset_moves[:, :, None] * design[order][:, None, :], starts, axis=0
    )
    pulls = np.add.reduceat((design * refinement.pull[:, None])[order], starts, axis=0)
    # In these directions the total information is 1; without a block, that of the block is missing.
    subset_moments, subset_rotations = np.zeros((blocks, d)), np.zeros((blocks, d, d))
    for block in range(blocks):
        values, axes = np.linalg.eigh((subset_sums[block] + subset_sums[block].T) / 2)
        subset_rotations[block] = (axes / np.clip(1.0 - values, 1e-2, None)) @ axes.T
        subset_moments[block] = subset_rotations[block] @ pulls[block]
    inverse_response = np.linalg.inv(refinement.response)
    covariance = inverse_response @ (subset_moments.T @ subset_moments) @ inverse_response.T
    factor = np.ones(d)
    for k in range(d):
        rows = subset_rotations[:, k, :]
        variances = np.einsum("bi,bij,bj->b", rows, subset_sums, rows)
        cross_products = np.einsum("bi,bij->bj", rows, subset_sums)
        scatter = np.diag(variances) - cross_products @ cross_products.T
        degrees_of_freedom = float(np.trace(scatter)) ** 2 / max(float((scatter**2).sum()), 1e-300)
        factor[k] = t.ppf(0.975, max(degrees_of_freedom, _MIN_FREEDOM)) / norm.ppf(0.975)
    return np.asarray(covariance * np.outer(factor, factor), np.float64)
