"""Whether a face bends as a whole, so that its plane is the attitude of this place alone.

A face with roughness as long as itself is a piece of a wave: its plane may be known well, and the
attitude of the surface over several such faces differs from it by as much as the face bends. How
much that is, a quadratic surface through the means of equal cells of the face tells; of roughness
that is shorter than the face it explains little.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.geometry.patches import equal_cells

MAX_POINTS = 6_000
CELLS, MIN_CELLS, POINTS_PER_CELL = 6, 4, 4
CHANCE = 0.01
MIN_EXPLAINED = 0.4
"""Share of the scatter of the cells' means about the plane that the quadratic surface explains."""
SIGMAS = 4.0
"""Width of a disc with even points, in their standard deviation."""


def bend_of(points: npt.ArrayLike, normal: npt.ArrayLike) -> float | None:
    """Return by how much the attitude of a face differs from one edge to the opposite one.

    Parameters
    ----------
    points : (n, 3)
        Of the face, in any frame; every k-th of more than 6,000 is used.
    normal : (3,)
        Of its plane.

    Returns
    -------
    float or None
        Degrees, in the direction in which it bends most; None of faces that do not bend by more
        than chance (1 %), whose roughness is shorter than they are, or of too few points.
    """
    from scipy.special import fdtrc

    xyz = np.asarray(points, np.float64).reshape(-1, 3)
    xyz = xyz[:: max(1, -(-len(xyz) // MAX_POINTS))]
    side = min(CELLS, int(np.sqrt(len(xyz) / POINTS_PER_CELL)))
    n = np.asarray(normal, np.float64)
    if side < MIN_CELLS or not np.isfinite(n).all():
        return None
    local = xyz - xyz.mean(axis=0)
    flat, h = local @ np.linalg.svd(n[None])[2][1:].T, local @ n
    v, u = (flat @ np.linalg.eigh(flat.T @ flat)[1]).T
    cell = equal_cells(u, v, side)
    count = np.bincount(cell)
    a, b, mean = (np.bincount(cell, x) / count for x in (u, v, h))
    wide, high = float(a.std()), float(b.std())
    if not (wide > 0.0 and high > 0.0):
        return None
    a, b = a / wide, b / high
    plane = np.column_stack([np.ones_like(a), a, b])
    curved = np.column_stack([plane, a * a, a * b, b * b])
    found = np.linalg.lstsq(curved, mean, rcond=None)[0]
    straight = mean - plane @ np.linalg.lstsq(plane, mean, rcond=None)[0]
    left = mean - curved @ found
    before, after = float(straight @ straight), float(left @ left)
    free = len(mean) - curved.shape[1]
    if before - after < MIN_EXPLAINED * before or not before > 0.0:
        return None
    if after > 0.0 and fdtrc(3, free, (before - after) / 3.0 / (after / free)) > CHANCE:
        return None
    second = np.array(
        [
            [2.0 * found[3] / wide**2, found[4] / wide / high],
            [found[4] / wide / high, 2.0 * found[5] / high**2],
        ]
    )
    across = SIGMAS * np.diag([float(u.std()), float(v.std())])
    return float(2.0 * np.degrees(np.arctan(0.5 * np.linalg.norm(second @ across, 2))))
