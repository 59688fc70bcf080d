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
_MIN_DEGREES_OF_FREEDOM = 3.0
_MIN_ERROR = 1e-7
"""Minimum error as a share of the size, or in rad, even for a copy of the model."""


@dataclass(frozen=True, eq=False)
class JackknifeError:
    """Error of a fit by the block jackknife.

    Attributes
    ----------
    whitening : (d, 7) array
        See `SimilarityObservation`; includes the widening by Student's t.
    blocks : int
    side_m : float
        Size of a block.
    is_correlated : bool
        Whether neighbouring blocks are still correlated.
    """

    whitening: FloatArray
    blocks: int
    side_m: float
    is_correlated: bool


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
    block_indices, is_correlated = np.zeros(len(refinement.places), np.int64), True
    for target_count in _BLOCK_COUNTS:
        block_indices, extent = cut_into_blocks(
            refinement.places, target_count, _MIN_BLOCK_RADII * radius
        )
        is_correlated = _are_neighbours_correlated(refinement, block_indices)
        if not is_correlated:
            break
    count = int(block_indices.max()) + 1
    covariance = _covariance(refinement, block_indices)
    # Linear functions of the parameters that do not depend on the undetermined directions.
    column_scales = np.array(
        [1.0, 1.0, 1.0, 1.0, refinement.size, refinement.size, refinement.size]
    )
    functionals = refinement.determined_axes.T @ refinement.information
    root = np.linalg.cholesky(covariance + _MIN_ERROR**2 * functionals @ functionals.T)
    return JackknifeError(
        np.linalg.solve(root, functionals / column_scales), count, extent, is_correlated
    )


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
    block_indices = np.zeros(len(positions), np.int64)
    for _ in range(60):
        cells = np.floor((positions - low) / max(extent, 1e-12)).astype(np.int64)
        width = cells.max(axis=0) + 1
        keys = cells[:, 0] + width[0] * (cells[:, 1] + width[1] * cells[:, 2])
        block_indices = np.unique(keys, return_inverse=True)[1]
        count = int(block_indices.max()) + 1
        if count >= min(target, len(positions)) or (
            count >= _BLOCK_COUNTS[-1] and 0.9 * extent < min_side
        ):
            break
        extent *= 0.9
    return np.asarray(block_indices, np.int64), extent


def _are_neighbours_correlated(refinement: Refinement, block_indices: IntArray) -> bool:
    """Return whether neighbouring blocks are correlated (Moran's I; Cliff & Ord 1981)."""
    from scipy.spatial import cKDTree

    count = np.bincount(block_indices)
    size = len(count)
    if size < 10:
        return False
    centres = np.column_stack(
        [np.bincount(block_indices, refinement.places[:, axis]) / count for axis in range(3)]
    )
    mean = np.bincount(block_indices, refinement.influence) / np.sqrt(count)
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


def _covariance(refinement: Refinement, block_indices: IntArray) -> FloatArray:
    """Return the covariance (d, d) of the determined directions, widened by Student's t."""
    from scipy.stats import norm, t

    design = refinement.design @ refinement.determined_axes
    d = design.shape[1]
    blocks = int(block_indices.max()) + 1
    order = np.argsort(block_indices, kind="stable")
    starts = np.searchsorted(block_indices[order], np.arange(blocks))
    weighted_design = (design * refinement.slope[:, None])[order]
    block_information = np.add.reduceat(
        weighted_design[:, :, None] * design[order][:, None, :], starts, axis=0
    )
    block_influences = np.add.reduceat(
        (design * refinement.influence[:, None])[order], starts, axis=0
    )
    # In these directions the total information is 1; without a block, that of the block is missing.
    block_steps, block_inverses = np.zeros((blocks, d)), np.zeros((blocks, d, d))
    for block in range(blocks):
        values, axes = np.linalg.eigh((block_information[block] + block_information[block].T) / 2)
        block_inverses[block] = (axes / np.clip(1.0 - values, 1e-2, None)) @ axes.T
        block_steps[block] = block_inverses[block] @ block_influences[block]
    inverse_response = np.linalg.inv(refinement.response)
    covariance = inverse_response @ (block_steps.T @ block_steps) @ inverse_response.T
    factor = np.ones(d)
    for k in range(d):
        rows = block_inverses[:, k, :]
        variances = np.einsum("bi,bij,bj->b", rows, block_information, rows)
        cross_products = np.einsum("bi,bij->bj", rows, block_information)
        scatter = np.diag(variances) - cross_products @ cross_products.T
        degrees_of_freedom = float(np.trace(scatter)) ** 2 / max(float((scatter**2).sum()), 1e-300)
        factor[k] = t.ppf(0.975, max(degrees_of_freedom, _MIN_DEGREES_OF_FREEDOM)) / norm.ppf(0.975)
    return np.asarray(covariance * np.outer(factor, factor), np.float64)
