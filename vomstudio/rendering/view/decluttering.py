"""Which labels can be shown without lying on one another, in pixels; no Qt, no VTK."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray

CELL = 4
"""Pixels per cell of the occupancy grid."""
_PLACES = range(6)
_TOGETHER = 256


class LabelGrid:
    """Takes rectangles as long as they touch none that was taken before.

    A row of cells is the bits of one integer: with a thousand labels at every step of a drag, small
    slices of an array took most of the time.
    """

    def __init__(self, width: float, height: float) -> None:
        self.width, self.height = width, height
        self._rows = [0] * (int(height) // CELL + 2)

    def block(self, x: float, y: float, width: float, height: float) -> None:
        """Keep a rectangle free of labels."""
        first, last, mask = self._cells(x, y, width, height)
        for row in range(first, last):
            self._rows[row] |= mask

    def take(self, x: float, y: float, width: float, height: float) -> bool:
        """Take a rectangle; False (and nothing taken) where it collides or leaves the image."""
        if x < 0 or y < 0 or x + width > self.width or y + height > self.height:
            return False
        # As in `_cells`, but it lies inside.
        left = int(x) // CELL
        mask = ((2 << (int(x + width) // CELL - left)) - 1) << left
        rows = self._rows
        span = range(int(y) // CELL, int(y + height) // CELL + 1)
        for row in span:
            if rows[row] & mask:
                return False
        for row in span:
            rows[row] |= mask
        return True

    def is_free(self, x: float, y: float, width: float, height: float) -> bool:
        """Whether nothing of a rectangle is taken, as far as it lies in the image."""
        first, last, mask = self._cells(x, y, width, height)
        return not any(row & mask for row in self._rows[first:last])

    def taken(self, boxes: FloatArray) -> BoolArray:
        """Whether rectangles (n, 4) of x, y, width and height collide, or leave the image: `take`
        would refuse each of them now, and ever after."""
        x, y, width, height = boxes.T
        out = (x < 0) | (y < 0) | (x + width > self.width) | (y + height > self.height)
        out |= ~np.isfinite(boxes).all(axis=1)
        inside = np.where(out[:, None], 0.0, boxes)
        left, top = (inside[:, :2].astype(np.int64) // CELL).T
        right, bottom = ((inside[:, :2] + inside[:, 2:]).astype(np.int64) // CELL + 1).T
        # Sums of what is taken above and to the left of each cell.
        columns = int(self.width) // CELL + 2
        sums = np.zeros((len(self._rows) + 1, columns + 1), np.int64)
        size = (columns + 7) // 8
        bits = b"".join((row & ((1 << columns) - 1)).to_bytes(size, "little") for row in self._rows)
        cells = np.frombuffer(bits, np.uint8).reshape(-1, size)
        filled = np.unpackbits(cells, axis=1, bitorder="little")[:, :columns]
        sums[1:, 1:] = filled.cumsum(axis=0, dtype=np.int64).cumsum(axis=1)
        found = sums[bottom, right] - sums[top, right] - sums[bottom, left] + sums[top, left]
        return np.asarray(out | (found > 0))

    def _cells(self, x: float, y: float, width: float, height: float) -> tuple[int, int, int]:
        """First row, the row after the last, and the bits of the columns."""
        left = max(int(x) // CELL, 0)
        right = max(min(int(x + width), int(self.width)) // CELL + 1, left)
        first = max(int(y) // CELL, 0)
        last = max(min(int(y + height) // CELL + 1, len(self._rows)), first)
        return first, last, ((1 << (right - left)) - 1) << left


def place_labels(
    grid: LabelGrid,
    anchors: FloatArray,
    sizes: FloatArray,
    order: IntArray,
    gap: float = 7.0,
    corners: IntArray | None = None,
    clear: FloatArray | None = None,
) -> dict[int, tuple[float, float]]:
    """Top left corners of the labels that fit, tried in `order` beside their anchors (n, 2).

    Each is tried to the right of its anchor and above, then below, then to the left, then in the
    middle. corners : (n,)
    which of these places a label had last, taken up again where it is free, so that labels do not
    jump about their anchors while the view turns; written anew for those that are placed. clear :
    (n,) pixels that must be free all round a label at the first place tried, or it gets none.
    """
    placed: dict[int, tuple[float, float]] = {}
    finite = np.asarray(np.isfinite(anchors).all(axis=1))
    wanted = order[finite[order]]
    spots = _spots(grid, anchors[wanted], sizes[wanted], gap)
    margins = np.zeros(len(wanted)) if clear is None else clear[wanted]
    stop = 0
    while stop < len(wanted):
        # Of thousands of labels nearly all find nothing free: that is told for many at once, and
        # for more and more the fuller the image is.
        part = slice(stop, max(2 * stop, _TOGETHER))
        stop = part.stop
        blocked = grid.taken(spots[part].reshape(-1, 4)).reshape(-1, len(_PLACES))
        open_ = np.flatnonzero(~blocked.all(axis=1))
        each = zip(
            wanted[part][open_].tolist(),
            spots[part][open_].tolist(),
            blocked[open_].tolist(),
            margins[part][open_].tolist(),
            strict=True,
        )
        # Plain numbers: taking them one by one out of arrays would cost more than the placing.
        for i, own, shut, free in each:
            last = 0 if corners is None else int(corners[i])
            if free > 0.0:
                x0, y0, width, height = own[last]
                if not grid.is_free(x0 - free, y0 - free, width + 2 * free, height + 2 * free):
                    continue
            for k in (last, *(k for k in _PLACES if k != last)):
                if not shut[k] and grid.take(*own[k]):
                    placed[i] = (own[k][0], own[k][1])
                    if corners is not None:
                        corners[i] = k
                    break
    return placed


def _spots(
    grid: LabelGrid,
    anchors: FloatArray,
    sizes: FloatArray,
    gap: float,
) -> FloatArray:
    """(n, 6, 4) the places at which each label is tried: x, y, width, height."""
    x, y = anchors.T
    width, height = sizes.T
    # At an edge of the image it moves in.
    right = np.minimum(x + gap, grid.width - width)
    left = np.maximum(x - gap - width, 0.0)
    middle = x - width / 2.0
    above, below = y - gap - height, y + gap
    columns = [right, right, left, left, middle, middle]
    rows = [above, below] * 3
    spots = [np.stack([a, b, width, height], axis=1) for a, b in zip(columns, rows, strict=True)]
    return np.stack(spots, axis=1)


def by_importance(
    selected: BoolArray,
    kept: BoolArray,
    extents: FloatArray,
    *,
    moving: bool,
) -> IntArray:
    """The order in which labels or symbols (n,) get their places: the selected ones, then the
    larger features. Those shown last stay before all others while the view moves, and before those
    that are not much larger when it rests: what comes and goes at every step cannot be read."""
    weight = extents if moving else extents * np.where(kept, 1.5, 1.0)
    return np.lexsort((-weight, ~kept & moving, ~selected))
