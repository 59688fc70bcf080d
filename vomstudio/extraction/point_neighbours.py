"""The points around single points of a cloud: neighbours, normals, how far they scatter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, Int32Array, IntArray
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.extraction.kernels import local_planes
from vomstudio.geometry.kernels.cell_lists import block_planes, cell_moments, nearest_in_block
from vomstudio.geometry.kernels.jit import for_kernels
from vomstudio.geometry.nearby.cell_grid import CellGrid, create_cell_grid
from vomstudio.geometry.nearby.point_grid import run_in_blocks

NEIGHBOURS = 12
"""Of a point of a cloud, that it hands a facet on to."""
AROUND = (16, 32, 64, 96)
"""Points from which a normal is taken; more where noise makes neighbours' normals differ."""
QUIET = 0.25
"""Of the angle: neighbouring normals may differ by so much at the median."""
MANY = 50_000
"""In clouds of fewer points every point is looked at by itself."""
_TRIED = 4_000
_BLOCK = 20_000
# A plane has a variation near 0; with noise of 1.7 spacings that of the most points is above this,
# and at an edge of 90 degrees 0.1.
_DROWNED, _QUIET_PART = 0.11, 0.2
# Of a mesh with noise of one side half of this.
_FLAT_AROUND = 0.08
# A hundred points that fill a block are above it in 98 of 100 cases; of those of a plane that has
# as many as are scattered around it hardly any are.
_SCATTERED, _IN_BLOCK, _IN_CELL = 0.22, 60, 4.0


@dataclass(frozen=True, eq=False)
class Seen:
    """Of k points: near (k, kept) their nearest, far (k,) how far the last of these is, normals
    (k, 3) and variation (k,) of the points around, which are that many (k,)"""

    near: Int32Array
    far: FloatArray
    normals: FloatArray
    variation: FloatArray
    around: IntArray


def drowned(places: FloatArray) -> bool:
    """Whether the noise of points (n, 3) is so large beside their spacing that even the most
    that normals are taken from fill a volume rather than a surface; of a part that is quiet every
    point can be looked at by itself."""
    most = AROUND[-1]
    if len(places) < 4 * most:
        return False
    sample = np.arange(0, len(places), max(1, len(places) // _TRIED))
    near = np.ascontiguousarray(_tree(places).query(places[sample], k=most)[1], np.int32)
    # Of the nearest alone as well: two sheets near each other are quiet each.
    return all(
        float(np.quantile(np.nan_to_num(variation), _QUIET_PART)) > _DROWNED
        for _, variation in (
            _planes(places, sample, np.ascontiguousarray(near[:, :count]))
            for count in (AROUND[0], most)
        )
    )


def scattered(places: FloatArray) -> tuple[BoolArray, float]:
    """Which of points (n, 3) scatter in all directions as far as a hundred of them reach, so that
    none tells a plane; and the area that each of these stands for."""
    low = places.min(axis=0)
    grid = create_cell_grid(places - low, _IN_CELL)
    starts, near = grid.around()
    m = len(grid.keys)
    means, inner = np.empty((m, 3)), np.empty((m, 6))
    cell_moments(grid.places, grid.begins, means, inner)
    count, normals, spreads = np.empty(m, np.int64), np.empty((m, 3)), np.empty((m, 3))
    block_planes(0, m, grid.begins, means, inner, starts, near, count, normals, spreads)
    filled = (count >= _IN_BLOCK) & (spreads[:, 0] > _SCATTERED * spreads.sum(axis=1))
    area = grid.side**2 / _IN_CELL ** (2.0 / 3.0)
    return np.repeat(filled, np.diff(grid.begins))[grid.row_of], area


def normals_of_places(
    places: FloatArray, angle_deg: float, progress: Progress
) -> FloatArray | None:
    """(n, 3) normals of places by as many of those around as make neighbours' normals agree; None
    where these are not flat."""
    tree = _tree(places)
    around = _wanted_neighbours(tree, places, angle_deg, 0.5)
    normals, variation = np.empty((len(places), 3)), np.empty(len(places))

    def work(block: slice) -> None:
        rows = np.arange(block.start, block.stop)
        near = np.ascontiguousarray(tree.query(places[rows], k=around)[1], np.int32)
        normals[block], variation[block] = _planes(places, rows, near)

    run_in_blocks(work, len(places), progress, _BLOCK)
    return normals if float(np.nanmedian(variation)) < _FLAT_AROUND else None


def seen_around(
    grid: CellGrid,
    rows: IntArray,
    few: BoolArray | None,
    known: int | None,
    angle_deg: float,
    progress: Progress,
) -> tuple[int, Seen]:
    """How many points normals are taken from, `known` where that is, and what is around the points
    of these rows. few : the cells with so few points in and around them that the least number is
    enough, since noise of the same width is smaller beside their spacing; None where no cells are
    known."""
    progress.stage(tr("Finding neighbours"), None)
    places = grid.places
    whole = None if known and few is not None and len(places) >= MANY else _tree(places)
    # What lies in planes is quiet.
    share = 1.0 - 0.5 * len(places) / len(rows) if 2 * len(rows) > len(places) else 0.0
    known = known if len(rows) else AROUND[0]
    around = (
        min(known, len(places)) if known else _wanted_neighbours(whole, places, angle_deg, share)
    )
    k, kept = len(rows), min(NEIGHBOURS, len(places) - 1)
    seen = Seen(
        np.empty((k, kept), np.int32),
        np.empty(k),
        np.empty((k, 3)),
        np.empty(k),
        np.full(k, around),
    )
    progress.stage(tr("Computing normals"), k)
    if few is None or len(places) < MANY:
        _by_tree(whole, places, None, rows, np.arange(k), seen, progress)
        return around, seen
    cells = grid.cells_of(rows)
    thin = few[cells]
    seen.around[thin] = min(AROUND[0], around)
    left = np.ones(k, np.bool_)
    _by_blocks(grid, rows, cells, np.flatnonzero(~thin), seen, left, progress)
    rest = np.flatnonzero(left)
    if not len(rest):
        return around, seen
    among = None
    if whole is None:
        among = _enough(grid, few, np.unique(cells[left & ~thin]))
        among = None if len(among) < 2 * AROUND[-1] else among
        whole = _tree(places if among is None else for_kernels(places[among], np.float64))
    for own in (rest[~thin[rest]], rest[thin[rest]]):
        _by_tree(whole, places, among, rows, own, seen, progress)
    return around, seen


def _enough(grid: CellGrid, few: BoolArray, cells: IntArray) -> IntArray:
    """Rows of the points that tell what is around those in these cells, and in cells with few
    points: all that are in the latter or beside the former, and one of each other cell."""
    starts, near = grid.around()
    full = few.copy()
    full[cells] = True
    beside = np.zeros(len(full), np.bool_)
    beside[cells] = True
    full[near[np.repeat(beside, np.diff(starts))]] = True
    chosen = np.repeat(full, np.diff(grid.begins))
    chosen[grid.begins[:-1]] = True
    return np.flatnonzero(chosen)


def _by_blocks(
    grid: CellGrid,
    rows: IntArray,
    cells: IntArray,
    own: IntArray,
    seen: Seen,
    left: BoolArray,
    progress: Progress,
) -> None:
    """What is around those that are `own` among the rows, of which `left` becomes False where it is
    in their cell and those around."""
    if not len(own):
        return
    starts, near_cells = grid.around()
    around, kept = int(seen.around[own[0]]), seen.near.shape[1]

    def work(block: slice) -> None:
        at = own[block]
        near = np.empty((len(at), around), np.int32)
        squares, known = np.empty((len(at), around)), np.empty(len(at), np.bool_)
        asked = for_kernels(rows[at], np.int64)
        nearest_in_block(
            grid.places,
            grid.begins,
            starts,
            near_cells,
            grid.keys,
            grid.row,
            grid.layer,
            grid.side,
            asked,
            for_kernels(cells[at], np.int64),
            near,
            squares,
            known,
        )
        at, near = at[known], near[known]
        seen.normals[at], seen.variation[at] = _planes(grid.places, rows[at], near)
        seen.near[at], seen.far[at] = near[:, 1 : kept + 1], np.sqrt(squares[known, kept])
        left[at] = False

    run_in_blocks(work, len(own), progress, _BLOCK)


def _by_tree(
    tree: Any,
    places: FloatArray,
    among: IntArray | None,
    rows: IntArray,
    own: IntArray,
    seen: Seen,
    progress: Progress,
) -> None:
    """What is around those that are `own` among the rows, in a tree of the places, or of those of
    the rows `among`."""
    if not len(own):
        return
    around, kept = int(seen.around[own[0]]), seen.near.shape[1]

    def work(block: slice) -> None:
        at = own[block]
        distance, near = tree.query(places[rows[at]], k=around)
        near = np.ascontiguousarray(near if among is None else among[near], np.int32)
        seen.normals[at], seen.variation[at] = _planes(places, rows[at], near)
        seen.near[at], seen.far[at] = near[:, 1 : kept + 1], distance[:, kept]

    run_in_blocks(work, len(own), progress, _BLOCK)


def _tree(places: FloatArray) -> Any:
    from scipy.spatial import cKDTree

    return cKDTree(places, leafsize=16, compact_nodes=False, balanced_tree=False)


def _planes(places: FloatArray, rows: IntArray, near: Int32Array) -> tuple[FloatArray, FloatArray]:
    """Normal and variation of the points `near` (k, number) around those of the rows (k,)."""
    found = np.empty((len(rows), 3)), np.empty(len(rows))
    local_planes(places, for_kernels(places[rows], np.float64), near, *found)
    return found


def _wanted_neighbours(tree: Any, places: FloatArray, angle_deg: float, share: float) -> int:
    """How many neighbours make normals that agree with those beside them, on a sample; share : of
    the places that must agree, a half where they are all."""
    n = len(places)
    sample = np.arange(0, n, max(1, n // _TRIED))
    wanted = min(AROUND[0], n)
    for count in AROUND:
        wanted = min(count, n)
        _, rows = tree.query(places[sample], k=wanted)
        # The fourth neighbour, and the plane around it.
        beside = rows[:, min(4, wanted - 1)]
        _, others = tree.query(places[beside], k=wanted)
        sides = [
            _planes(places, at, np.ascontiguousarray(near, np.int32))[0]
            for at, near in ((sample, rows), (beside, others))
        ]
        cosine = np.abs((sides[0] * sides[1]).sum(axis=1))
        cosine = cosine[np.isfinite(cosine)]
        if not len(cosine):
            break
        if (
            np.degrees(np.arccos(min(float(np.quantile(cosine, 1.0 - share)), 1.0)))
            <= QUIET * angle_deg
        ):
            break
        if wanted == n:
            break
    return wanted
