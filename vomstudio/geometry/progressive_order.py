"""Progressive order of points, in which any leading part samples the whole cloud.

Space is divided recursively into eight cubes each, down to MAX_LEVEL. One point of every cube of a
level belongs to that level or a coarser one; the remaining points form an additional level. Each
level is therefore an even sample, with twice the linear density of the level above. Within a level,
neighbours in space are neighbours in the order (G. M. Morton's Z-shaped curve, 1966), and the order
is cut into nodes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import ByteArray, FloatArray, IntArray, IntegerArray, UInt64Array
from vomstudio.core.threads import PROCESSOR_COUNT, thread_pool

POINTS_PER_NODE = 50_000
MAX_LEVEL = 13
BLOCK_SIZE = 1 << 15
N_UNSHUFFLED_LEVELS = 5
"""Number of coarsest levels whose cubes are not shuffled; they contain points of every level."""
_MAX_THREADS = 4


@dataclass(frozen=True, eq=False)
class ProgressiveOrder:
    """Rows of the points of a cloud, node by node, coarse nodes first.

    Attributes
    ----------
    rows : (n,) ndarray of int
        Rows of the points with finite coordinates.
    starts : (k + 1,) ndarray of int
        Start of each node in `rows`, and the end of the last node.
    bounds : (k, 2, 3) ndarray
        Bounding boxes of the points of the nodes.
    spacing : (k,) ndarray
        Approximate distance between neighbouring points of the node and its ancestors together.
    parents : (k,) ndarray of int
        Row of the parent node, -1 for a node without a parent; a parent precedes its children.
    """

    rows: IntegerArray
    starts: IntArray
    bounds: FloatArray
    spacing: FloatArray
    parents: IntArray

    def __len__(self) -> int:
        return len(self.spacing)

    def is_valid(self, points: int) -> bool:
        """Return whether this is a valid arrangement of a cloud with the given number of points."""
        k = len(self)
        return bool(
            self.starts.shape == (k + 1,)
            and self.bounds.shape == (k, 2, 3)
            and self.parents.shape == (k,)
            and self.starts[0] == 0
            and self.starts[-1] == len(self.rows) <= points
            and (np.diff(self.starts) > 0).all()
            and np.isfinite(self.bounds).all()
            and (self.spacing > 0.0).all()
            and (self.parents < np.arange(k)).all()
            and (not len(self.rows) or (self.rows.min() >= 0 and self.rows.max() < points))
        )


def arrange(points: FloatArray, check: Callable[[], None] = lambda: None) -> ProgressiveOrder:
    """Arrange points in progressive order.

    This takes about 0.08 s for a million points on two processors, and 20 bytes per point.

    Parameters
    ----------
    points : (n, 3) ndarray
    check : callable, optional
        Called from time to time; may raise an exception to stop the computation.

    Returns
    -------
    ProgressiveOrder
    """
    if not len(points):
        no_rows = np.zeros(0, np.int64)
        return ProgressiveOrder(
            no_rows, np.zeros(1, np.int64), np.zeros((0, 2, 3)), np.zeros(0), no_rows
        )
    # A mapped file is an array subclass, which would slow down every block.
    points = np.asarray(points)
    with thread_pool(min(_MAX_THREADS, PROCESSOR_COUNT)) as pool:

        def map_blocks(work: Callable[[slice], None], count: int) -> None:
            def run_checked(start: int) -> None:
                check()
                work(slice(start, min(start + BLOCK_SIZE, count)))

            list(pool.map(run_checked, range(0, count, BLOCK_SIZE)))

        low, high = _compute_bounds(points, map_blocks)
        if not (np.isfinite(low).all() and np.isfinite(high).all()):
            finite_indices = np.flatnonzero(np.isfinite(points).all(axis=1))
            arrangement = arrange(points[finite_indices], check)
            return replace(
                arrangement, rows=finite_indices[arrangement.rows].astype(arrangement.rows.dtype)
            )
        cube_size = float((high - low).max()) * (1.0 + 1e-9) or 1.0
        row_bits = max(1, len(points).bit_length())
        depth = _depth(row_bits)
        keys = _pack_keys(points, low, cube_size, depth, row_bits, map_blocks)
        check()
        keys.sort()
        check()
        levels, spacing = _assign_levels(keys >> np.uint64(row_bits), cube_size, depth, map_blocks)
        check()
        order = np.argsort(levels, kind="stable")
        keys = keys.take(order)
        row_dtype = np.int32 if row_bits < 32 else np.int64
        rows: IntegerArray = (keys & np.uint64((1 << row_bits) - 1)).astype(row_dtype)
        starts, node_levels, parents = _cut_into_nodes(keys, np.bincount(levels, minlength=1))
        bounds = np.empty((len(parents), 2, 3))

        def store_bounds(node: int) -> None:
            check()
            node_points = points.take(rows[starts[node] : starts[node + 1]], axis=0)
            for axis in range(3):
                bounds[node, :, axis] = node_points[:, axis].min(), node_points[:, axis].max()

        list(pool.map(store_bounds, range(len(parents))))
    return ProgressiveOrder(rows, starts, bounds, spacing[node_levels], parents)


def _depth(row_bits: int) -> int:
    """Return the number of levels for which the curve position and the row fit into 64 bits."""
    return min(MAX_LEVEL, (64 - row_bits) // 3)


_RunBlocks = Callable[[Callable[[slice], None], int], None]


def _compute_bounds(points: FloatArray, run_blocks: _RunBlocks) -> tuple[FloatArray, FloatArray]:
    """Return the lower and upper bounds, which are not finite if any point is not finite."""
    lows, highs = [np.full(3, np.inf)], [np.full(3, -np.inf)]

    def reduce_block(part: slice) -> None:
        # Column by column: a reduction along rows of three is many times slower.
        lows.append(np.array([points[part, axis].min() for axis in range(3)]))
        highs.append(np.array([points[part, axis].max() for axis in range(3)]))

    run_blocks(reduce_block, len(points))
    return np.min(lows, axis=0), np.max(highs, axis=0)


def _pack_keys(
    points: FloatArray,
    low: FloatArray,
    cube_size: float,
    depth: int,
    row_bits: int,
    run_blocks: _RunBlocks,
) -> UInt64Array:
    """Pack curve positions and rows into integers, which sort faster than argsort."""
    keys = np.empty(len(points), np.uint64)
    tables = [_bit_table(axis, depth) for axis in range(3)]
    cells = 2**depth

    def encode(part: slice) -> None:
        code = np.zeros(part.stop - part.start, np.uint64)
        for axis in range(3):
            position = (points[part, axis] - low[axis]) * (cells / cube_size)
            code |= tables[axis][np.minimum(position.astype(np.int16), cells - 1)]
        _shuffle(code, depth)
        rows = np.arange(part.start, part.stop, dtype=np.uint64)
        keys[part] = code << np.uint64(row_bits) | rows

    run_blocks(encode, len(points))
    return keys


def _bit_table(axis: int, depth: int) -> UInt64Array:
    """Return the bits that each cell along an axis contributes to the curve position."""
    cells = np.arange(2**depth, dtype=np.uint64)
    bits = np.zeros(2**depth, np.uint64)
    for bit in range(depth):
        bits |= (cells >> np.uint64(bit) & np.uint64(1)) << np.uint64(3 * bit + axis)
    return bits


def _shuffle(code: UInt64Array, depth: int) -> None:
    """Permute the eight subcubes of every cube pseudorandomly.

    Otherwise, all points of a level would be in the same corner of their cubes and form a visible
    grid.
    """
    # The golden ratio spreads consecutive numbers (D. E. Knuth, The art of computer programming 3,
    # 6.4).
    ratio, shift_bits = np.uint64(0x9E3779B97F4A7C15), np.uint64(61)
    for level in range(depth, N_UNSHUFFLED_LEVELS, -1):
        parent_code = code >> np.uint64(3 * (depth - level + 1))
        parent_code *= ratio
        parent_code >>= shift_bits
        parent_code <<= np.uint64(3 * (depth - level))
        code ^= parent_code


def _assign_levels(
    codes: UInt64Array, cube_size: float, depth: int, run_blocks: _RunBlocks
) -> tuple[ByteArray, FloatArray]:
    """Return the level of each point along the curve, and the spacing of every level."""
    count = len(codes)
    # Number of cubes around a point that also contain the previous point.
    shared_levels = np.zeros(count, np.uint8)

    def compare(part: slice) -> None:
        start = max(part.start, 1)
        differences = codes[start : part.stop] ^ codes[start - 1 : part.stop - 1]
        for level in range(1, depth + 1):
            shared_levels[start : part.stop] += differences < np.uint64(1 << 3 * (depth - level))

    run_blocks(compare, count)
    # Number of cubes that contain a point, from the outermost level inwards.
    filled_counts = np.cumsum(np.bincount(shared_levels, minlength=depth + 1))[:depth]
    filled_counts = np.concatenate([[1], filled_counts])
    top = depth + 1
    if count > POINTS_PER_NODE:
        top = max(1, int(np.searchsorted(filled_counts, POINTS_PER_NODE, side="right")) - 1)
    levels = np.maximum(shared_levels, top - 1) - np.uint8(top - 1)
    cumulative_counts = np.cumsum(np.bincount(levels, minlength=1))
    # On a surface, the spacing scales with the square root of the number of points per cube.
    coarser_counts = np.maximum(
        np.searchsorted(filled_counts, cumulative_counts / 2.0, side="right") - 1, 0
    )
    return levels, cube_size / 2.0**coarser_counts * np.sqrt(
        filled_counts[coarser_counts] / np.maximum(cumulative_counts, 1)
    )


def _cut_into_nodes(keys: UInt64Array, counts: IntegerArray) -> tuple[IntArray, IntArray, IntArray]:
    """Cut levels into nodes along the same sections of the curve as their parents.

    Return the start, the level and the parent of each node.
    """
    starts: list[int] = []
    node_levels: list[int] = []
    parents: list[int] = []
    parent_nodes = [-1]
    position = 0
    for level, count in enumerate(counts.tolist()):
        level_keys = keys[position : position + count]
        later_starts = [starts[node] for node in parent_nodes[1:]]
        cuts = (
            [0, *np.searchsorted(level_keys, keys[later_starts]).tolist(), count]
            if later_starts
            else [0, count]
        )
        new_nodes = []
        for node, length in zip(parent_nodes, np.diff(cuts).tolist(), strict=True):
            pieces = -(-length // POINTS_PER_NODE)
            for piece in range(pieces):
                new_nodes.append(len(starts))
                starts.append(position + length * piece // pieces)
                node_levels.append(level)
                parents.append(node)
            position += length
        parent_nodes = new_nodes or parent_nodes
    starts.append(position)
    return (
        np.array(starts, np.int64),
        np.array(node_levels, np.int64),
        np.array(parents, np.int64),
    )
