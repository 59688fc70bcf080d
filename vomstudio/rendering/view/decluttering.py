"""Placement of labels without overlap, in pixels; independent of Qt and VTK."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray

CELL_PIXELS = 4
"""Side length of a cell of the occupancy grid, pixels."""
POSITIONS = range(6)
BATCH_SIZE = 256


class LabelGrid:
    """Occupancy grid that accepts rectangles that do not overlap earlier ones.

    A row of cells is stored as the bits of an integer, because small slices of an array would take
    most of the time for a thousand labels at every step of a drag.
    """

    def __init__(self, width: float, height: float) -> None:
        self.width, self.height = width, height
        self._rows = [0] * (int(height) // CELL_PIXELS + 2)

    def block(self, x: float, y: float, width: float, height: float) -> None:
        """Mark a rectangle as occupied."""
        first_row, last_row, mask = self._cell_range(x, y, width, height)
        for row in range(first_row, last_row):
            self._rows[row] |= mask

    def take(self, x: float, y: float, width: float, height: float) -> bool:
        """Occupy a free rectangle. Return False if it overlaps another or leaves the image."""
        if x < 0 or y < 0 or x + width > self.width or y + height > self.height:
            return False
        # Same computation as in `_cell_range`, for a rectangle inside the image.
        left = int(x) // CELL_PIXELS
        mask = ((2 << (int(x + width) // CELL_PIXELS - left)) - 1) << left
        rows = self._rows
        span = range(int(y) // CELL_PIXELS, int(y + height) // CELL_PIXELS + 1)
        for row in span:
            if rows[row] & mask:
                return False
        for row in span:
            rows[row] |= mask
        return True

    def is_free(self, x: float, y: float, width: float, height: float) -> bool:
        """Return whether the part of a rectangle inside the image is free."""
        first_row, last_row, mask = self._cell_range(x, y, width, height)
        return not any(row & mask for row in self._rows[first_row:last_row])

    def collisions(self, boxes: FloatArray) -> BoolArray:
        """Return which rectangles (n, 4) overlap another one or leave the image.

        Rectangles are x, y, width, height. Rejected rectangles stay rejected,
        because occupied cells are never freed.
        """
        x, y, width, height = boxes.T
        is_rejected = (x < 0) | (y < 0) | (x + width > self.width) | (y + height > self.height)
        is_rejected |= ~np.isfinite(boxes).all(axis=1)
        accepted_boxes = np.where(is_rejected[:, None], 0.0, boxes)
        left, top = (accepted_boxes[:, :2].astype(np.int64) // CELL_PIXELS).T
        right, bottom = (
            (accepted_boxes[:, :2] + accepted_boxes[:, 2:]).astype(np.int64) // CELL_PIXELS + 1
        ).T
        # Number of occupied cells above and to the left of each cell (summed-area table).
        columns = int(self.width) // CELL_PIXELS + 2
        sums = np.zeros((len(self._rows) + 1, columns + 1), np.int64)
        size = (columns + 7) // 8
        packed_rows = b"".join(
            (row & ((1 << columns) - 1)).to_bytes(size, "little") for row in self._rows
        )
        cells = np.frombuffer(packed_rows, np.uint8).reshape(-1, size)
        is_filled = np.unpackbits(cells, axis=1, bitorder="little")[:, :columns]
        sums[1:, 1:] = is_filled.cumsum(axis=0, dtype=np.int64).cumsum(axis=1)
        occupied_sums = (
            sums[bottom, right] - sums[top, right] - sums[bottom, left] + sums[top, left]
        )
        return np.asarray(is_rejected | (occupied_sums > 0))

    def _cell_range(self, x: float, y: float, width: float, height: float) -> tuple[int, int, int]:
        """Return the first row, the end row and the column bits of a rectangle."""
        left = max(int(x) // CELL_PIXELS, 0)
        right = max(min(int(x + width), int(self.width)) // CELL_PIXELS + 1, left)
        first_row = max(int(y) // CELL_PIXELS, 0)
        last_row = max(min(int(y + height) // CELL_PIXELS + 1, len(self._rows)), first_row)
        return first_row, last_row, ((1 << (right - left)) - 1) << left


def place_labels(
    grid: LabelGrid,
    anchors: FloatArray,
    sizes: FloatArray,
    order: IntArray,
    gap: float = 7.0,
    position_indices: IntArray | None = None,
    clearances: FloatArray | None = None,
) -> dict[int, tuple[float, float]]:
    """Place labels beside their anchors; return the upper-left corners of labels that fit.

    Each label is tried at the upper right of its anchor, then at the lower right, then on the
    left, and finally centred above or below the anchor.

    Parameters
    ----------
    grid : LabelGrid
    anchors : (n, 2) ndarray
        Anchors in pixels.
    sizes : (n, 2) ndarray
        Width and height of each label, pixels.
    order : (n,) ndarray of int
        Rows of the labels, in decreasing order of importance.
    gap : float, optional
        Distance of a label from its anchor, pixels.
    position_indices : (n,) int, optional
        Index of the previous position of each label, which is preferred so that labels do not
        jump around their anchors while the view rotates. The values of placed labels are updated.
    clearances : (n,) float64, optional
        Margin, in pixels, that must be free around a label at the position that is tried
        first. Otherwise the label is omitted.
    """
    placed_labels: dict[int, tuple[float, float]] = {}
    is_finite_anchor = np.asarray(np.isfinite(anchors).all(axis=1))
    rows = order[is_finite_anchor[order]]
    candidates = _candidate_boxes(grid, anchors[rows], sizes[rows], gap)
    margins = np.zeros(len(rows)) if clearances is None else clearances[rows]
    stop = 0
    while stop < len(rows):
        # Most of thousands of labels do not fit. They are therefore tested in batches, which double
        # in size as the image fills.
        part = slice(stop, max(2 * stop, BATCH_SIZE))
        stop = part.stop
        is_blocked = grid.collisions(candidates[part].reshape(-1, 4)).reshape(-1, len(POSITIONS))
        open_indices = np.flatnonzero(~is_blocked.all(axis=1))
        candidates_by_anchor = zip(
            rows[part][open_indices].tolist(),
            candidates[part][open_indices].tolist(),
            is_blocked[open_indices].tolist(),
            margins[part][open_indices].tolist(),
            strict=True,
        )
        # Uses plain numbers, because accessing single array elements would take longer than the
        # placement.
        for i, anchor_candidates, is_candidate_blocked, clearance in candidates_by_anchor:
            last_position = 0 if position_indices is None else int(position_indices[i])
            if clearance > 0.0:
                x0, y0, width, height = anchor_candidates[last_position]
                if not grid.is_free(
                    x0 - clearance,
                    y0 - clearance,
                    width + 2 * clearance,
                    height + 2 * clearance,
                ):
                    continue
            for k in (last_position, *(k for k in POSITIONS if k != last_position)):
                if not is_candidate_blocked[k] and grid.take(*anchor_candidates[k]):
                    placed_labels[i] = (anchor_candidates[k][0], anchor_candidates[k][1])
                    if position_indices is not None:
                        position_indices[i] = k
                    break
    return placed_labels


def _candidate_boxes(
    grid: LabelGrid,
    anchors: FloatArray,
    sizes: FloatArray,
    gap: float,
) -> FloatArray:
    """Return the candidate rectangles (n, 6, 4) of each label: x, y, width, height."""
    x, y = anchors.T
    width, height = sizes.T
    # Labels at an edge of the image are moved inside.
    right = np.minimum(x + gap, grid.width - width)
    left = np.maximum(x - gap - width, 0.0)
    centre = x - width / 2.0
    y_above, y_below = y - gap - height, y + gap
    columns = [right, right, left, left, centre, centre]
    rows = [y_above, y_below] * 3
    candidates = [
        np.stack([a, b, width, height], axis=1) for a, b in zip(columns, rows, strict=True)
    ]
    return np.stack(candidates, axis=1)


def order_by_importance(
    is_selected: BoolArray,
    was_shown: BoolArray,
    extents: FloatArray,
    *,
    is_moving: bool,
) -> IntArray:
    """Return the order in which labels or symbols (n,) are placed.

    Selected features precede all others, and larger features precede smaller ones. While the view
    moves, previously shown labels precede new ones, because labels that appear and disappear at
    every step would be illegible. At rest, they precede new ones that are not much larger.
    """
    weight = extents if is_moving else extents * np.where(was_shown, 1.5, 1.0)
    return np.lexsort((-weight, ~was_shown & is_moving, ~is_selected))
