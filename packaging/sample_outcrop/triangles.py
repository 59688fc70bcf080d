"""A mesh fine where it must be: right-triangulated irregular network over square tiles.

Every tile is two right triangles; a triangle is halved at the middle of its longest side as long as
that middle, or any below it, is off by more than allowed. Since a middle's error is that of both
triangles that share it, no cracks open (Evans, Kirkpatrick & Townsend 2001, Right-triangulated
irregular networks, Algorithmica 30, 264-286).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Ints = npt.NDArray[np.int64]


def triangulate(
    points: npt.NDArray[np.float64],
    allowed: npt.NDArray[np.float64],
    fine: npt.NDArray[np.bool_],
    tile: int,
    spare: int,
) -> list[Ints]:
    """Triangles (m, 3) of every tile, row by row from the first, as indices into points flattened.

    points (rows, columns, 3), allowed (rows, columns), m, fine (rows, columns): rows and columns
    are multiples of `tile`, a power of 2, plus 1. Halving stops `spare` times before single cells,
    except where `fine` asks for more. Triangles turn counter-clockwise with columns to the right
    and rows upward.
    """
    rows, columns, _ = points.shape
    across, up = (columns - 1) // tile, (rows - 1) // tile
    flat = points.reshape(-1, 3)
    limit = allowed.reshape(-1)
    corner = np.array([(r * tile) * columns + c * tile for r in range(up) for c in range(across)])
    right, above = tile, tile * columns
    # a, b: ends of the longest side; c: the right angle. Counter-clockwise.
    a = np.concatenate([corner, corner + right + above])
    b = np.concatenate([corner + right + above, corner])
    c = np.concatenate([corner + above, corner + right])
    owner = np.tile(np.arange(len(corner)), 2)
    levels = []
    top = (a, b, c)
    for _ in range(2 * int(np.log2(tile))):
        middle = _middle(a, b, columns)
        levels.append((a, b, middle))
        # (a, b, c) into (c, a, middle) and (b, c, middle), which turn alike.
        a, b, c = np.concatenate([c, b]), np.concatenate([a, c]), np.concatenate([middle, middle])
    need = np.zeros(len(flat), bool)
    below: Ints | None = None
    wanted_fine = fine.reshape(-1)
    for depth, (a, b, middle) in reversed(list(enumerate(levels))):
        off = wanted_fine[middle]
        if depth < len(levels) - spare:
            gap = np.linalg.norm(flat[middle] - 0.5 * (flat[a] + flat[b]), axis=1)
            off = off | (gap > limit[middle])
        need[middle[off]] = True
        if below is not None:
            n = len(middle)
            wanted = need[below]
            need[middle[wanted[:n] | wanted[n:]]] = True
        below = middle
    a, b, c = top
    done: list[tuple[Ints, Ints]] = []
    for _ in levels:
        middle = _middle(a, b, columns)
        split = need[middle]
        done.append((np.stack([a, b, c], axis=1)[~split], owner[~split]))
        a, b, c, middle, owner = a[split], b[split], c[split], middle[split], owner[split]
        a, b, c = np.concatenate([c, b]), np.concatenate([a, c]), np.concatenate([middle, middle])
        owner = np.tile(owner, 2)
    done.append((np.stack([a, b, c], axis=1), owner))
    triangles = np.concatenate([t for t, _ in done])
    owners = np.concatenate([o for _, o in done])
    return [triangles[owners == k] for k in range(len(corner))]


def _middle(a: Ints, b: Ints, columns: int) -> Ints:
    rows = (a // columns + b // columns) // 2
    return np.asarray(rows * columns + (a % columns + b % columns) // 2)
