"""How near to a plane the surface is around each point."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

_BLOCK = 4096
_FEWEST = 10


def local_eigenvalues(points: npt.ArrayLike, radius: float) -> Array:
    """(n, 3) normalised eigenvalues l1 >= l2 >= l3 of the covariance of the neighbours of each
    point within `radius`; NaN where there are fewer than 10, since a few points look planar by
    chance.

    points : (n, 3) float64, any frame; radius in its units. Coplanarity is 1 / l3 and collinearity
    l1 / l2 (textbook eq. 20, 21).
    """
    from scipy.spatial import cKDTree

    xyz = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    xyz = xyz - xyz.mean(axis=0) if len(xyz) else xyz
    tree = cKDTree(xyz)
    result = np.full((len(xyz), 3), np.nan)
    # In blocks: the neighbourhoods of all points together may not fit into memory.
    for start in range(0, len(xyz), _BLOCK):
        block = xyz[start : start + _BLOCK]
        result[start : start + _BLOCK] = _block_eigenvalues(
            xyz, block, tree.query_ball_point(block, radius)
        )
    return result


def _block_eigenvalues(xyz: Array, centres: Array, neighbours: npt.NDArray[np.object_]) -> Array:
    result = np.full((len(centres), 3), np.nan)
    counts = np.array([len(each) for each in neighbours], dtype=np.int64)
    enough = counts >= _FEWEST
    if not enough.any():
        return result
    members = np.concatenate([neighbours[i] for i in np.flatnonzero(enough)]).astype(np.int64)
    n = counts[enough]
    starts = np.concatenate([[0], np.cumsum(n)[:-1]])
    local = xyz[members] - np.repeat(centres[enough], n, axis=0)
    local -= np.repeat(np.add.reduceat(local, starts) / n[:, None], n, axis=0)
    scatter = np.add.reduceat(local[:, :, None] * local[:, None, :], starts) / n[:, None, None]
    values = np.clip(np.linalg.eigvalsh(scatter)[:, ::-1], 0.0, None)
    total = values.sum(axis=1, keepdims=True)
    result[enough] = values / np.where(total > 0.0, total, np.nan)
    return result


def near_planar_share(points: npt.ArrayLike, radius: float, coplanarity: float = 100.0) -> float:
    """Share of the points whose neighbourhood is near-planar. Under 0.3, textbook 4.1.3 advises to
    interpret by hand rather than to extract automatically. NaN where nothing can be said."""
    smallest = local_eigenvalues(points, radius)[:, 2]
    known = smallest[np.isfinite(smallest)]
    return float((known * coplanarity <= 1.0).mean()) if len(known) else float("nan")
